/// Params of the force loop "rig" in f32, made by tribo-sim params: change its input, not this file.
///
///     scenario     "rig_500hz.yaml"
///     description  "the examples' rig at 500 Hz"
///     tick         0.002 s
///     u            -2 to 2 N
///     |r| and |y|  up to 2 N
///     gain         0.85, of a controller of 1 sections
///
/// Equal to the result of the library's init function. Include it in one file of a program, which then needs no set-up code.

#ifndef RIG_PARAMS_F32_H
#define RIG_PARAMS_F32_H

#include "tribo/feedforward_f32.h"

#if TRIBO_FORCE_LOOP_F32_PARAMS_VERSION != 9
#error "made for another version of tribo: run tribo-sim params again"
#endif

#if defined(__cplusplus) && __cplusplus < 202002L && defined(__GNUC__)
#pragma GCC system_header // no warning that members are named as in C and C++20
#endif

// clang-format off
#define RIG_SAMPLE_TIME_S 2.00000009e-03f

static const tribo_feedforward_f32_params_t rig_feedforward = {
    .method = {tribo_feedforward_f32_method},
    .input_max = 2.00000000e+00f,
    .offset_max = 8.00000000e+00f,
    .reversal = 5.00000024e-04f,
    .stop_gain = {1.86836502e+02f, 7.00636902e+01f},
    .jump = 1.52380973e-01f,
    .lead_gain = 1.75000000e+00f,
    .lag_gain = 6.24999952e+00f,
    .damping_gain = 3.74999976e+00f,
    .step = 4.00000019e-03f,
    .noise_floor = 1.00000011e-06f,
    .noise_part = 6.62251655e-03f,
    .slow_part = 6.62251655e-03f,
    .fast_part = 1.66666657e-01f,
    .lag_part = 1.37931049e-01f,
    .actuator_part = 3.29679966e-01f,
    .sensor_part = 1.04165874e-01f,
    .leak_part = 1.59744429e-03f,
    .trust = 5.00000000e-01f,
    .still_ticks = 100u,
    .quick_ticks = 150u,
    .learning = {
        .breakaway_n = 1.57000005e-01f,
        .reversal_n = 5.00000024e-04f,
        .per_n = {3.99999976e+03f, 1.86836502e+02f, 7.00636902e+01f},
        .deviation = {4.00000006e-01f, 5.50000012e-01f, 5.50000012e-01f, 4.71000038e-02f, 1.00000001e-01f},
        .jump_lag = 1.96874964e+00f,
        .forgetting_per_n = 9.99999940e-02f,
        .trust = 5.00000000e-01f,
        .unit_n = 1.00000000e+00f,
        .rig = 1579341918u,
    },
};
static const tribo_guard_f32_params_t rig_guard = {
    .step = tribo_guard_f32_step,
    .on = 1u,
    .half_n = 2.50000004e-02f,
    .stray_n = 9.99999978e-03f,
    .work = 5.00000024e-04f,
    .fade_step = 4.00000019e-03f,
    .quick_ticks = 101u,
};
static const tribo_force_loop_f32_params_t rig_params = {
    .input_max_n = 2.00000000e+00f,
    .gain = 8.50000024e-01f,
    .controller = {
        .cascade = {
            .section = {
                {
                    .b0 = 3.84003013e-01f,
                    .b1 = 4.24003005e-01f,
                    .b2 = 3.99999991e-02f,
                    .a1 = 1.00000000e+00f,
                    .a2 = 0.00000000e+00f,
                },
                {
                    .b0 = 1.00000000e+00f,
                    .b1 = 2.00000000e+00f,
                    .b2 = 1.00000000e+00f,
                    .a1 = 2.00000000e+00f,
                    .a2 = 1.00000000e+00f,
                },
            },
            .count = 2u,
        },
        .anti_windup = 2.60414624e+00f,
        .u_min_n = -2.00000000e+00f,
        .u_max_n = 2.00000000e+00f,
    },
    .compensator = {
        .friction = {
            .rate_hz = 4.99999969e+02f,
            .exponent_per_rise = 6.18297812e+05f,
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
            .pulse_width = 2u,
        },
        .arm = {
            .phi_d = 5.43160513e-02f,
            .phi_g = 7.77430534e-01f,
            .gamma_d = 9.95111018e-02f,
            .gamma_g = 5.72517276e-01f,
        },
    },
    .method = &rig_feedforward.method,
    .guard = &rig_guard,
};
// clang-format on

#endif
