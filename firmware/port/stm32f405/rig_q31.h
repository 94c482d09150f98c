/// Params of the force loop "rig" in Q31, made by tribo-sim params: change its input, not this file.
///
///     scenario     "rig.yaml"
///     description  "the STM32F405's rig: the paper's"
///     tick         0.001 s
///     full scale   4 N is 2^31
///     u            -2 to 2 N
///     |r| and |y|  up to 2 N
///     gain         0.85, of a controller of 2 sections
///
/// As the library's init function makes them. For one file of a program, which then needs no set-up code.

#ifndef RIG_PARAMS_Q31_H
#define RIG_PARAMS_Q31_H

#include "tribo/feedforward_q31.h"

#if TRIBO_FORCE_LOOP_Q31_PARAMS_VERSION != 8
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
    .input_max = 1073741824u,
    .offset_max = 536870912,
    .reversal = 67109u,
    .stop_per_unit = {5442008u, 2040753u, 765282u, 286981u},
    .jump = 40904457,
    .lead = 229376u,
    .distrust = 2147483648u,
    .lag = 209715168u,
    .lag_shift = 0u,
    .damping_shift = 3u,
    .noise_part = 17179870u,
    .noise_floor = 34360u,
    .rate_part = 390451584u,
    .step = 268435,
    .lag_part = 318145760u,
    .actuator_part = 778545536u,
    .sensor_part = 229844560u,
    .observer_part = 390451584u,
    .damping = 4026531584u,
    .jump_lag = 196608u,
    .measured_per_unit = 16383999u,
    .travel_half = 6711u,
    .slip = 671089u,
    .travel_max = 134218u,
    .weighing = 268435u,
    .doubt_per_unit = 409600u,
    .margin_per_unit = 81920u,
    .forgetting_per_unit = 53687088u,
    .constant_sd = 4029098u,
    .constant_max = 21072184,
    .still_ticks = 200u,
    .quick_ticks = 200u,
    .deadband_part = 14268995u,
    .effort_part = 1073741952u,
    .effort_half = 210722u,
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
