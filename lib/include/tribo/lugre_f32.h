/// LuGre friction of a constrained arm, single precision, Eq. (12) with F_C = F_S = L(F), as the paper has it:
///
///     f = sat( s0 z + s1 dz/dt + s2 w )       dz/dt = w - s0 |w| z / L       sat(x) = min(L+, max(-L-, x))
///
/// The rival of friction_f32.h, with the same step: u and F in, f out, L(F) and gravity those of the friction's params. s1/I is
/// 2.6e6 1/s with the paper's parameters, so an explicit step of w and z must stay below 0.7 us. Here one step of any length is
/// stable:
///
///     w at the step's end is that of the arm's own zero-order hold with f held, which is linear in f
///     z by backward Euler, z1 = (z + h w1) / D,  D = 1 + s0 h |w1| / L
///
/// and f comes from a linear equation instead of a quadratic one, with the D* of an arm that sticks; an arm that slides is
/// told by f beyond L. In numbers, with Z = s0 z and r = n - f plus what the arm carries over of its speed (G = gamma_d r; G,
/// gamma_d, gamma_g: arm_f32.h):
///
///     n' = n + gamma_g r[k-1]                    what friction has to hold
///     D* = 1 + |n' - Z| c/(1 + a + b) / L        a = (1 + beta) c,  beta = s1/(s0 h),  b = s2 gamma_d/(K h)
///     P  = ((1 + beta)/D* - beta) Z              c = s0 gamma_d/K
///     f  = sat( n' - (n' - P) / (1 + b + a/D*) ),   r = n' - f
///     Z  = (Z + c r) / (1 + c |r|/L)
///
/// |f| <= L and |Z| <= the largest L seen, whatever comes. A corrupt Z or r starts again from 0. The speed is the module's own,
/// so the arm that its f drives must be the config's. Beside Eq. (12) by CVODE, with the paper's parameters at 1 kHz and ramps of up to 0.4 N/s: F of that arm
/// within 0.1 %, f within 0.1 % of L rms (tests/truth/test_lugre_compensator.c holds 1 %).
/// Source: C. Canudas de Wit et al., IEEE Trans. Automatic Control 40(3), 1995; the linearly implicit step after V. Acary,
/// B. Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008 (implicit time stepping), and, for sampled LuGre,
/// L. Freidovich et al., "LuGre-model-based friction compensation", IEEE Trans. Control Systems Technology 18(1), 2010.
/// Three divisions, no loops; with a breakaway table one more, and a loop over its points. Not synchronized: one state, one tick.

#ifndef TRIBO_LUGRE_F32_H
#define TRIBO_LUGRE_F32_H

#include "tribo/arm_f32.h"
#include "tribo/friction_f32.h"
#include "tribo/status.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Displacement in the arm's unit (arm_f32.h), degrees with the paper's numbers.
typedef struct
{
    float stiffness; ///< s0, over 0, N per unit; c from 1e-6 to 1e6
    float damping;   ///< s1, 0 or more, N s per unit; beta at most 1000
    float viscous;   ///< s2, 0 or more, N s per unit; b at most 1000
} tribo_lugre_f32_config_t;

/// What a step reads, made by tribo_lugre_f32_init. Const from then on; may be shared.
typedef struct
{
    float a, b_and_1, beta, c; ///< above
    float stuck;               ///< c/(1 + a + b)
    float gamma_g;             ///< of the arm
} tribo_lugre_f32_params_t;

typedef struct
{
    float    n_n;        ///< n[k-1]
    uint32_t bad_inputs; ///< steps with a bad input since reset; stops at UINT32_MAX
    float    bristle_n;  ///< Z
    float    drive_n;    ///< r
} tribo_lugre_f32_state_t;

/// Eq. (12) with the paper's parameters: 1e5 N/deg, 10^2.5 and 0.4 N s/deg.
tribo_lugre_f32_config_t tribo_lugre_f32_paper(void);

/// Checks `config` and `arm` and computes `params` for a sample time of 1e-6 to 0.1 s. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// what tribo_arm_f32_init says, TRIBO_ERR_BRISTLE_STIFFNESS, TRIBO_ERR_BRISTLE_DAMPING or TRIBO_ERR_BRISTLE_VISCOUS, in
/// this order. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_lugre_f32_init(tribo_lugre_f32_params_t       *params,
                                    const tribo_lugre_f32_config_t *config,
                                    const tribo_arm_f32_config_t   *arm,
                                    float                           sample_time_s);

/// At rest, bristles relaxed, counter 0.
void tribo_lugre_f32_reset(tribo_lugre_f32_state_t *state);

/// Friction in N at manipulated input `u_n` and end-point force `force_n`, both in N, to be held over the tick. Of `friction` it
/// reads L(F), by law or table, and gravity. Cannot fail: with a bad input (NaN, or beyond TRIBO_F32_FORCE_MAX_N) n stays as it
/// was, a bad force counts as 0 in L(F), and the step is counted. `signals` is written whole and must not be null: L is that on
/// the side of f, v and the relays are 0.
float tribo_lugre_f32_step(const tribo_lugre_f32_params_t    *params,
                           const tribo_friction_f32_params_t *friction,
                           tribo_lugre_f32_state_t           *state,
                           float                              u_n,
                           float                              force_n,
                           tribo_friction_f32_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
