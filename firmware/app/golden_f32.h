/// Params of the force loop "golden" in f32, made by tribo-sim params: change its input, not this file.
///
///     scenario     "golden.yaml"
///     description  "the drive's self-test"
///     tick         0.001 s
///     u            -2 to 2 N
///     |r| and |y|  up to 2 N
///     gain         0.85, of a controller of 3 sections
///
/// Equal to the result of the library's init function. Include it in one file of a program, which then needs no set-up code.

#ifndef GOLDEN_PARAMS_F32_H
#define GOLDEN_PARAMS_F32_H

#include "tribo/force_loop_f32.h"

#if TRIBO_FORCE_LOOP_F32_PARAMS_VERSION != 9
#error "made for another version of tribo: run tribo-sim params again"
#endif

#if defined(__cplusplus) && __cplusplus < 202002L && defined(__GNUC__)
#pragma GCC system_header // no warning that members are named as in C and C++20
#endif

// clang-format off
#define GOLDEN_SAMPLE_TIME_S 1.00000005e-03f

static const tribo_force_loop_f32_params_t golden_params = {
    .input_max_n = 2.00000000e+00f,
    .gain = 8.50000024e-01f,
    .controller = {
        .cascade = {
            .section = {
                {
                    .b0 = 1.81250000e+00f,
                    .b1 = 5.31250000e-01f,
                    .b2 = 9.37500000e-02f,
                    .a1 = 3.75000000e-01f,
                    .a2 = 9.37500000e-02f,
                },
                {
                    .b0 = 1.25000000e+00f,
                    .b1 = 1.50000000e+00f,
                    .b2 = 4.37500000e-01f,
                    .a1 = 1.25000000e+00f,
                    .a2 = 4.37500000e-01f,
                },
                {
                    .b0 = 7.50000000e-01f,
                    .b1 = 1.87500000e-01f,
                    .b2 = 7.81250000e-03f,
                    .a1 = 2.81250000e-01f,
                    .a2 = 5.96046448e-07f,
                },
            },
            .count = 3u,
        },
        .anti_windup = 5.88505745e-01f,
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
    .method = NULL,
    .guard = NULL,
};
// clang-format on

#endif
