/// The compensator of Fig. 11 (compensator_f32.h) with LuGre friction (lugre_f32.h) in place of the paper's, single precision. It
/// takes the same params, of which it reads L(F), gravity and arm, and the same state. Not synchronized: one state, one tick.

#ifndef TRIBO_COMPENSATOR_LUGRE_F32_H
#define TRIBO_COMPENSATOR_LUGRE_F32_H

#include "tribo/compensator_f32.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Friction and arm at rest, counters 0.
void tribo_compensator_lugre_f32_reset(tribo_compensator_f32_state_t *state);

/// As tribo_compensator_f32_step: estimated friction f^ in N for `u_n` in N as applied. Cannot fail. `lugre` was made for the
/// arm of `params`. Of `signals`, L is that on the side of f^, v and the relays are 0.
float tribo_compensator_lugre_f32_step(const tribo_compensator_f32_params_t *params,
                                       const tribo_lugre_f32_params_t       *lugre,
                                       tribo_compensator_f32_state_t        *state,
                                       float                                 u_n,
                                       tribo_compensator_f32_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
