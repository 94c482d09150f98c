/// Force controller, single precision: cascade, output limit, anti-windup, bumpless change of params.
///
///     v = K(z) e                         the cascade
///     u = limit(v + feedforward)         u_min to u_max
///
/// While u is limited the cascade's states advance as if the input had been e + (u - feedforward - v) c / D, D being
/// the cascade's direct feedthrough. c = 1 (Hanus' conditioning: the input that would have given just u) needs
/// zeros inside the unit circle; tribo_controller_f32_init finds the largest |c| = 1, 1/2, 1/4 ... of either sign
/// for which the conditioned cascade dies away within 2^24 ticks. A stable biproper cascade has such a c, and one with a
/// pole at z = 1 has one of either sign; with two such poles many have. Rejected if no |c| of 1e-6 or more stabilises it:
/// an integrator cancelled by a zero, or poles slower than some 10^-7 a tick cancelled by zeros together with a zero
/// outside the unit circle.
///
/// Rounding, against double precision: 1.4e-7 N over the paper's triangle. A ripple that stands for minutes is worse, as
/// each output is rounded to one side and the slow pole adds that up: with +-20 mN at the Nyquist frequency up to 6e-6 N
/// in a minute (tests/contract/test_controller.c). In Q31 what is rounded off is carried, 1.7e-8 N for the same ripple.
///
/// tribo_controller_f32_change takes a running controller over to other params without a bump in u.
///
/// No loop but the one over the sections. Not synchronized: one state, one tick.
/// Source: R. Hanus, M. Kinnaert, J.-L. Henrotte, "Conditioning technique, a general anti-windup and bumpless
/// transfer method", Automatica 23(6), 1987.

#ifndef TRIBO_CONTROLLER_F32_H
#define TRIBO_CONTROLLER_F32_H

#include "tribo/biquad_f32.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct
{
    const tribo_biquad_f32_section_t *sections;      ///< K(z), the first nearest to e; |b0| of each 1e-6 to 1e6
    uint32_t                          section_count; ///< 1 to TRIBO_BIQUAD_SECTIONS_MAX
    float                             u_min_n;       ///< -1e6 to 0 N
    float                             u_max_n;       ///< 0 to 1e6 N, over u_min_n
} tribo_controller_f32_config_t;

/// What a step reads, made by tribo_controller_f32_init. Const from then on; may be shared.
typedef struct
{
    tribo_biquad_f32_params_t cascade;
    float                     anti_windup; ///< c / D
    float                     u_min_n, u_max_n;
} tribo_controller_f32_params_t;

typedef struct
{
    tribo_biquad_f32_state_t cascade;
    uint32_t                 bad_inputs;    ///< since reset; stops at UINT32_MAX
    uint32_t                 limited_ticks; ///< since reset; stops at UINT32_MAX
} tribo_controller_f32_state_t;

/// What one step saw, for logging.
typedef struct
{
    float v_n;     ///< the cascade's output
    float u_n;     ///< the limited sum
    bool  limited; ///< u is not v + feedforward
} tribo_controller_f32_signals_t;

/// Checks `config`, copies the sections and finds the anti-windup. Returns TRIBO_OK, TRIBO_ERR_NULL, what
/// tribo_biquad_f32_init says, TRIBO_ERR_SECTION_FEEDTHROUGH, TRIBO_ERR_U_MIN, TRIBO_ERR_U_MAX or
/// TRIBO_ERR_ANTI_WINDUP (see above). Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_controller_f32_init(tribo_controller_f32_params_t       *params,
                                         const tribo_controller_f32_config_t *config);

/// Cascade at rest, counters 0.
void tribo_controller_f32_reset(tribo_controller_f32_state_t *state);

/// One tick: error `e_n` and feedforward in N give u in N, within u_min_n to u_max_n. Cannot fail: a bad input (NaN,
/// or beyond 4e6 N) counts as 0 and is counted. `signals` is written whole and must not be null.
float tribo_controller_f32_step(const tribo_controller_f32_params_t *params,
                                tribo_controller_f32_state_t        *state,
                                float                                e_n,
                                float                                feedforward_n,
                                tribo_controller_f32_signals_t      *signals);

/// Between two ticks: takes the state over from params `from` to `to`, so that for error `e_n` v is and moves as it would
/// have under `from`, plus `offset_n` (what v has to make up for in the sum, 0 if nothing). Cannot fail; a bad `e_n` or
/// `offset_n` counts as 0. Costs up to two ticks of the loop.
void tribo_controller_f32_change(const tribo_controller_f32_params_t *from,
                                 const tribo_controller_f32_params_t *to,
                                 tribo_controller_f32_state_t        *state,
                                 float                                e_n,
                                 float                                offset_n);

#ifdef __cplusplus
}
#endif

#endif
