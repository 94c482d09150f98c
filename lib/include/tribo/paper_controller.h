/// Coefficients of the controller "paper", made by tribo-design: change its input, not this file.
///
///     input     paper.yaml, SHA-256 913234c6dce60bf29bb06d12e94b6322d8e15eca24864d499df0b9dee508b476
///     tool      tribo-design 0.2.0 (python-control 0.10.2, slycot 0.7.1)
///     plant     gain 0.86, zeros none, poles -55, -200, -139+203j, -139-203j, -56778
///     weights   wp = [0.909090909 20] / [1 0.002]; wu = 1; wT = [1 18.2] / [0.0001 20]
///     gamma     1.7372, K(s) of order 7 by mixsyn
///     reduced   3 modes beyond 1 x Nyquist removed: order 4, K(0) = 12702
///               poles -0.002, -340.23, -167.14 +- 293.43j; zeros -55, -200, -139 +- 203j rad/s
///     K(z)      tustin, sample time 0.001 s
///     loop      with hold and 0.0001 s delay, Q31: gamma 1.7616, gain margin 10.49, phase margin 81.88 deg
///
/// F32: sections as b0, b1, b2, a1, a2 of tribo/controller_f32.h, the first nearest to the input, the slowest pole in the last.
/// Q31: params of tribo/controller_q31.h, as tribo_controller_q31_init makes them of these sections and limits.
/// Constants only, no code; paper_controller.c holds both, declared here for whoever has included their types before.

#ifndef TRIBO_PAPER_CONTROLLER_H
#define TRIBO_PAPER_CONTROLLER_H

// clang-format off
#define TRIBO_PAPER_CONTROLLER_SAMPLE_TIME_S 0.001f
#define TRIBO_PAPER_CONTROLLER_SECTION_COUNT 2u
#define TRIBO_PAPER_CONTROLLER_FULL_SCALE_N 2.0f ///< 2^31 in Q31
#define TRIBO_PAPER_CONTROLLER_U_MAX_N 2.0f ///< in Q31, of either sign

#define TRIBO_PAPER_CONTROLLER_F32                                                             \
    {                                                                                          \
        {1.81855643e+00f, 5.33418715e-01f, 9.53765884e-02f, 3.74956906e-01f, 9.53765884e-02f}, \
        {7.58975148e-01f, 1.78621888e-01f, 7.38661969e-03f, 2.90768296e-01f, 5.81531992e-07f}, \
    }

#define TRIBO_PAPER_CONTROLLER_Q31                                                                         \
    {                                                                                                      \
        .cascade = {.section = {                                                                           \
            {.b0 = 244082512, .c1 = -172488264, .minus_a1 = -100651728, .c2 = 409639328, .d2 = -819278656, \
             .d2_low = 0, .shift = 5, .scale = 4},                                                         \
            {.b0 = 203735840, .c1 = -155787392, .minus_a1 = -78052520, .c2 = 126901160, .d2 = -9991,       \
             .d2_low = 1530920960, .shift = 6, .scale = 4},                                                \
        }, .count = 2, .input_scale = 3, .output_scale = 4},                                               \
        .anti_windup = 1555878016, .taken_max = 1482005627,                                                \
        .u_min = -2147483647, .u_max = 2147483647,                                                         \
        .anti_windup_shift = 2,                                                                            \
    }
// clang-format on

#ifdef TRIBO_CONTROLLER_F32_H
extern const tribo_biquad_f32_section_t tribo_paper_controller_f32[TRIBO_PAPER_CONTROLLER_SECTION_COUNT];
#endif
#ifdef TRIBO_CONTROLLER_Q31_H
extern const tribo_controller_q31_params_t tribo_paper_controller_q31;
#endif

#endif
