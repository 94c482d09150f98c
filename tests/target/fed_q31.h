/// Params of the force loop "fed" in Q31, made by tribo-sim params: change its input, not this file.
///
///     scenario     "fed.yaml"
///     description  "the loop of image_f32_fed and image_q31_fed"
///     tick         0.001 s
///     full scale   2 N is 2^31
///     u            -2 to 2 N
///     |r| and |y|  up to 2 N
///     gain         0.85, of a controller of 2 sections
///
/// Equal to the result of the library's init function. Include it in one file of a program, which then needs no set-up code.

#ifndef FED_PARAMS_Q31_H
#define FED_PARAMS_Q31_H

#include "tribo/feedforward_q31.h"

#if TRIBO_FORCE_LOOP_Q31_PARAMS_VERSION != 9
#error "made for another version of tribo: run tribo-sim params again"
#endif

#if defined(__cplusplus) && __cplusplus < 202002L && defined(__GNUC__)
#pragma GCC system_header // no warning that members are named as in C and C++20
#endif

// clang-format off
#define FED_SAMPLE_TIME_S 1.00000005e-03f
#define FED_FULL_SCALE_N 2.00000000e+00f

static const tribo_feedforward_q31_params_t fed_feedforward = {
    .method = {tribo_feedforward_q31_method},
    .input_max = 2147483646,
    .offset_max = 536870912,
    .reversal = 134218,
    .stop_gain = {24489034u, 9183388u},
    .jump = 40904457,
    .lead_gain = 229376u,
    .lag_gain = 12800u,
    .damping_gain = 491520u,
    .step = 536871,
    .noise_floor = 17180,
    .noise_part = 14268995u,
    .slow_part = 14268995u,
    .fast_part = 390451584u,
    .lag_part = 318145760u,
    .actuator_part = 778545536u,
    .sensor_part = 229844560u,
    .leak_part = 3433228u,
    .trust = 2147483648u,
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
        .unit_n = 3.72529030e-09f,
        .rig = 1579341918u,
    },
};
static const tribo_force_loop_q31_params_t fed_params = {
    .input_max = 2147483646,
    .gain = 456340288,
    .controller = {
        .cascade = {
            .section = {
                {
                    .b0 = 244082512,
                    .c1 = -172488264,
                    .minus_a1 = -100651728,
                    .c2 = 409639328,
                    .d2 = -819278656,
                    .d2_low = 0,
                    .shift = 5u,
                    .scale = 4u,
                },
                {
                    .b0 = 203735840,
                    .c1 = -155787392,
                    .minus_a1 = -78052520,
                    .c2 = 126901160,
                    .d2 = -9991,
                    .d2_low = 1530920960,
                    .shift = 6u,
                    .scale = 4u,
                },
            },
            .count = 2u,
            .input_scale = 3u,
            .output_scale = 4u,
        },
        .anti_windup = 1555878016,
        .taken_max = 1482005627,
        .u_min = -2147483647,
        .u_max = 2147483647,
        .anti_windup_shift = 2u,
    },
    .compensator = {
        .friction = {
            .rise_max = 35302u,
            .exponent_rate = 316568480u,
            .exponent_at_rest = 36306608,
            .k_min = 805306368u,
            .k_max = 2684354560u,
            .law = {
                {.offset = 7516193u, .slope = 1288490240u},
                {.offset = 7516193u, .slope = 1288490240u},
            },
            .table = NULL,
            .set_level = 3221225472u,
            .reset_level = 3435973888u,
            .gravity = 0,
            .law_whole = {0u, 0u},
            .rise_shift = 16u,
            .k_shift = 5u,
            .is_shallow = true,
            .table_length = 0u,
            .pulse_width = 3u,
        },
        .arm = {
            .phi_d = 15842514,
            .phi_g = 237383136,
            .gamma_d = 30385040,
            .gamma_g = 207502880,
            .shift = 2u,
        },
    },
    .method = &fed_feedforward.method,
    .guard = NULL,
};
// clang-format on

#endif
