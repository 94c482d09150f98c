/// Coefficients of the paper's H-infinity controller, Eqs. (13), (14), at a sample time of 1 ms.
///
///     plant     gain 0.86, poles -55, -200, -139 +- 203j, -56778 rad/s
///     weights   wp = (s/1.1 + 20)/(s + 20e-4), wu = 1, wT = (s + 18.2)/(1e-4 s + 20)
///     K(s)      python-control 0.10.2 mixsyn (slycot 0.7.1) on a balanced realisation: gamma 1.7372, order 7
///     reduced   poles beyond pi/h (-3.6e8, -2e5, -56778) and their zeros dropped, order 4, K(0) = 12701.7:
///               poles -340.232, -167.142 +- 293.427j, -0.002; zeros -55, -200, -139 +- 203j rad/s
///     K(z)      Tustin, root by root: (s + p) -> d + 2p/(2/h + p), d = z - 1
///     sections  fast complex pair first with gain 1 at rest, then the slow pole, which holds the output
///
/// Each section as b0, b1, b2, a1, a2 of tribo/biquad_f32.h. Constants only, no code.

#ifndef TRIBO_PAPER_CONTROLLER_H
#define TRIBO_PAPER_CONTROLLER_H

#define TRIBO_PAPER_CONTROLLER_SAMPLE_TIME_S 1.0e-3f
#define TRIBO_PAPER_CONTROLLER_SECTION_COUNT 2u

// clang-format off
#define TRIBO_PAPER_CONTROLLER_F32                                                       \
    {                                                                                    \
        {1.81853446e+00f, 5.33412299e-01f, 9.53754363e-02f, 3.74958507e-01f, 9.53754363e-02f}, \
        {7.58963177e-01f, 1.78619071e-01f, 7.38650294e-03f, 2.90770064e-01f, 5.81535546e-07f}, \
    }
// clang-format on

#endif
