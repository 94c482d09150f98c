/// Params of the force loop "fed" in f32, made by tribo-sim params: change its input, not this file.
///
///     scenario     "fed.yaml"
///     description  "the loop of image_f32_fed and image_q31_fed"
///     tick         0.001 s
///     u            -2 to 2 N
///     |r| and |y|  up to 2 N
///     gain         0.85, of a controller of 2 sections
///
/// Equal to the result of the library's init function. Include it in one file of a program, which then needs no set-up code.

#ifndef FED_PARAMS_F32_H
#define FED_PARAMS_F32_H

#include "tribo/feedforward_f32.h"

#if TRIBO_FORCE_LOOP_F32_PARAMS_VERSION != 9
#error "made for another version of tribo: run tribo-sim params again"
#endif

#if defined(__cplusplus) && __cplusplus < 202002L && defined(__GNUC__)
#pragma GCC system_header // no warning that members are named as in C and C++20
#endif

// clang-format off
#define FED_SAMPLE_TIME_S 1.00000005e-03f

static const tribo_feedforward_f32_params_t fed_feedforward = {
    .method = {tribo_feedforward_f32_method},
    .input_max = 2.00000000e+00f,
    .offset_max = 8.00000000e+00f,
    .reversal = 5.00000024e-04f,
    .stop_gain = {1.86836502e+02f, 7.00636902e+01f},
    .jump = 7.61904866e-02f,
    .lead_gain = 3.50000000e+00f,
    .lag_gain = 1.24999990e+01f,
    .damping_gain = 7.49999952e+00f,
    .step = 2.00000009e-03f,
    .noise_floor = 1.00000011e-06f,
    .noise_part = 3.32225929e-03f,
    .slow_part = 3.32225929e-03f,
    .fast_part = 9.09090936e-02f,
    .lag_part = 7.40740821e-02f,
    .actuator_part = 1.81269258e-01f,
    .sensor_part = 5.35148568e-02f,
    .leak_part = 7.99360627e-04f,
    .trust = 5.00000000e-01f,
    .still_ticks = 200u,
    .quick_ticks = 300u,
    .learning = {
        .breakaway_n = 1.57000005e-01f,
        .reversal_n = 5.00000024e-04f,
        .per_n = {3.99999976e+03f, 1.86836502e+02f, 7.00636902e+01f},
        .deviation = {4.00000006e-01f, 5.50000012e-01f, 5.50000012e-01f, 4.71000038e-02f, 1.00000001e-01f},
        .jump_lag = 3.93749928e+00f,
        .forgetting_per_n = 9.99999940e-02f,
        .trust = 5.00000000e-01f,
        .unit_n = 1.00000000e+00f,
        .rig = 1579341918u,
    },
};
static const tribo_force_loop_f32_params_t fed_params = {
    .input_max_n = 2.00000000e+00f,
    .gain = 8.50000024e-01f,
    .controller = {
        .cascade = {
            .section = {
                {
                    .b0 = 1.81855643e+00f,
                    .b1 = 5.33418715e-01f,
                    .b2 = 9.53765884e-02f,
                    .a1 = 3.74956906e-01f,
                    .a2 = 9.53765884e-02f,
                },
                {
                    .b0 = 7.58975148e-01f,
                    .b1 = 1.78621888e-01f,
                    .b2 = 7.38661969e-03f,
                    .a1 = 2.90768296e-01f,
                    .a2 = 5.81531992e-07f,
                },
            },
            .count = 2u,
        },
        .anti_windup = 7.24512160e-01f,
        .u_min_n = -2.00000000e+00f,
        .u_max_n = 2.00000000e+00f,
    },
    .compensator = {
        .friction = {
            .rate_hz = 9.99999939e+02f,
            .exponent_per_rise = 1.23659562e+06f,
            .exponent_at_rest = 8.65616989e+00f,
            .k = {
                {.at_0 = 1.17831051e+00f, .per_power = 3.14216137e+01f},
                {.at_0 = 3.92770171e+00f, .per_power = 9.42648411e+00f},
            },
            .law = {
                {.offset_n = 7.00000022e-03f, .slope = 3.00000012e-01f},
                {.offset_n = 7.00000022e-03f, .slope = 3.00000012e-01f},
            },
            .table = NULL,
            .set_level = 7.50000000e-01f,
            .reset_level = 8.00000012e-01f,
            .gravity_n = 0.00000000e+00f,
            .table_length = 0u,
            .pulse_width = 3u,
        },
        .arm = {
            .phi_d = 1.47544909e-02f,
            .phi_g = 8.84321094e-01f,
            .gamma_d = 2.82982737e-02f,
            .gamma_g = 7.73008466e-01f,
        },
    },
    .method = &fed_feedforward.method,
    .guard = NULL,
};
// clang-format on

#endif
