/// The compensator of Fig. 11 with LuGre friction in Q31, as compensator_lugre_f32.h has it. Not synchronized: one state, one tick.

#ifndef TRIBO_COMPENSATOR_LUGRE_Q31_H
#define TRIBO_COMPENSATOR_LUGRE_Q31_H

#include "tribo/compensator_q31.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Friction and arm at rest, counters 0.
void tribo_compensator_lugre_q31_reset(tribo_compensator_q31_state_t *state);

/// As tribo_compensator_q31_step: estimated friction f^ for `u` as applied, both Q31. Cannot fail. `lugre` was made for the arm
/// of `params`. Of `signals`, L is that on the side of f^, rise and the relays are 0.
int32_t tribo_compensator_lugre_q31_step(const tribo_compensator_q31_params_t *params,
                                         const tribo_lugre_q31_params_t       *lugre,
                                         tribo_compensator_q31_state_t        *state,
                                         int32_t                               u,
                                         tribo_compensator_q31_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
