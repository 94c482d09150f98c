/// Params of the force loop "rig" in Q31, made by tribo-sim params: change its input, not this file.
///
///     scenario     "rig_1khz.yaml"
///     description  "the examples' rig at 1 kHz"
///     tick         0.001 s
///     full scale   4 N is 2^31
///     u            -2 to 2 N
///     |r| and |y|  up to 2 N
///     gain         0.85, of a controller of 2 sections
///
/// Equal to the result of the library's init function. Include it in one file of a program, which then needs no set-up code.

#ifndef RIG_PARAMS_Q31_H
#define RIG_PARAMS_Q31_H

#include "tribo/feedforward_q31.h"

#if TRIBO_FORCE_LOOP_Q31_PARAMS_VERSION != 9
#error "made for another version of tribo: run tribo-sim params again"
#endif

#if defined(__cplusplus) && __cplusplus < 202002L && defined(__GNUC__)
#pragma GCC system_header // no warning that members are named as in C and C++20
#endif

// clang-format off
#define RIG_SAMPLE_TIME_S 1.00000005e-03f
#define RIG_FULL_SCALE_N 4.00000000e+00f

static const tribo_feedforward_q31_params_t rig_feedforward = {
    .method = {tribo_feedforward_q31_method},
    .input_max = 1073741824,
    .offset_max = 536870912,
    .reversal = 67109,
    .stop_gain = {48978068u, 18366776u},
    .jump = 40904457,
    .lead_gain = 229376u,
    .lag_gain = 12800u,
    .damping_gain = 491520u,
    .step = 268435,
    .noise_floor = 8590,
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
        .unit_n = 7.45058060e-09f,
        .rig = 1579341918u,
    },
};
static const tribo_guard_q31_params_t rig_guard = {
    .step = tribo_guard_q31_step,
    .on = 1u,
    .half = 3355443,
    .stray = 671089,
    .work = INT64_C(274878038),
    .fade_step = 8589935u,
    .quick_ticks = 201u,
};
static const tribo_force_loop_q31_params_t rig_params = {
    .input_max = 1073741824,
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
                    .b0 = 407471680,
                    .c1 = -311574784,
                    .minus_a1 = -78052520,
                    .c2 = 253802320,
                    .d2 = -9991,
                    .d2_low = 1530920960,
                    .shift = 6u,
                    .scale = 3u,
                },
            },
            .count = 2u,
            .input_scale = 3u,
            .output_scale = 3u,
        },
        .anti_windup = 1555878016,
        .taken_max = 2147462139,
        .u_min = -1073741824,
        .u_max = 1073741824,
        .anti_windup_shift = 1u,
    },
    .compensator = {
        .friction = {
            .rise_max = 17651u,
            .exponent_rate = 316568480u,
            .exponent_at_rest = 36306608,
            .k_min = 805306368u,
            .k_max = 2684354560u,
            .law = {
                {.offset = 3758097u, .slope = 1288490240u},
                {.offset = 3758097u, .slope = 1288490240u},
            },
            .table = NULL,
            .set_level = 3221225472u,
            .reset_level = 3435973888u,
            .gravity = 0,
            .law_whole = {0u, 0u},
            .rise_shift = 17u,
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
    .method = &rig_feedforward.method,
    .guard = &rig_guard,
};
// clang-format on

#endif
