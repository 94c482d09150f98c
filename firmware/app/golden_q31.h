/// Params of the force loop "golden" in Q31, made by tribo-sim params: change its input, not this file.
///
///     scenario     "golden.yaml"
///     description  "the drive's self-test"
///     tick         0.001 s
///     full scale   4 N is 2^31
///     u            -2 to 2 N
///     |r| and |y|  up to 2 N
///     gain         0.85, of a controller of 3 sections
///
/// Equal to the result of the library's init function. Include it in one file of a program, which then needs no set-up code.

#ifndef GOLDEN_PARAMS_Q31_H
#define GOLDEN_PARAMS_Q31_H

#include "tribo/force_loop_q31.h"

#if TRIBO_FORCE_LOOP_Q31_PARAMS_VERSION != 9
#error "made for another version of tribo: run tribo-sim params again"
#endif

#if defined(__cplusplus) && __cplusplus < 202002L && defined(__GNUC__)
#pragma GCC system_header // no warning that members are named as in C and C++20
#endif

// clang-format off
#define GOLDEN_SAMPLE_TIME_S 1.00000005e-03f
#define GOLDEN_FULL_SCALE_N 4.00000000e+00f

static const tribo_force_loop_q31_params_t golden_params = {
    .input_max = 1073741824,
    .gain = 456340288,
    .controller = {
        .cascade = {
            .section = {
                {
                    .b0 = 243269632,
                    .c1 = -171966464,
                    .minus_a1 = -100663296,
                    .c2 = 402653184,
                    .d2 = -805306368,
                    .d2_low = 0,
                    .shift = 5u,
                    .scale = 4u,
                },
                {
                    .b0 = 335544320,
                    .c1 = 67108864,
                    .minus_a1 = -335544320,
                    .c2 = 939524096,
                    .d2 = -939524096,
                    .d2_low = 0,
                    .shift = 3u,
                    .scale = 4u,
                },
                {
                    .b0 = 201326592,
                    .c1 = -150994944,
                    .minus_a1 = -75497472,
                    .c2 = 268435456,
                    .d2 = -20480,
                    .d2_low = 0,
                    .shift = 7u,
                    .scale = 4u,
                },
            },
            .count = 3u,
            .input_scale = 3u,
            .output_scale = 4u,
        },
        .anti_windup = 1263806464,
        .taken_max = 1610596731,
        .u_min = -1073741824,
        .u_max = 1073741824,
        .anti_windup_shift = 2u,
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
    .method = NULL,
    .guard = NULL,
};
// clang-format on

#endif
