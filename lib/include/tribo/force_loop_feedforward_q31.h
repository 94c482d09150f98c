/// The force loop with the reversal feed-forward in Q31: the twin of force_loop_feedforward_f32.h, which says how it is used and what
/// it keeps to. tribo_force_loop_feedforward_q31_init is in quantize_feedforward_q31.h.
/// Not synchronized: one state and one memory, one tick.

#ifndef TRIBO_FORCE_LOOP_FEEDFORWARD_Q31_H
#define TRIBO_FORCE_LOOP_FEEDFORWARD_Q31_H

#include "tribo/force_loop_q31.h"

#ifdef __cplusplus
extern "C" {
#endif

/// params.method of a loop with the feed-forward.
extern const tribo_force_loop_q31_method_t tribo_force_loop_feedforward_q31;

/// After a reset of `state`: `memory` starts anew with it, and keeps what was learned. It must live as long as `state`, and have
/// been reset once itself. Null: none.
void tribo_force_loop_feedforward_q31_attach(tribo_force_loop_q31_state_t   *state,
                                             tribo_feedforward_q31_memory_t *memory);

#ifdef __cplusplus
}
#endif

#endif
