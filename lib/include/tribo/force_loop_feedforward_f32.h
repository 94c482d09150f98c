/// The force loop with the reversal feed-forward (feedforward_f32.h) in place of the paper's compensator, single precision.
///
///     tribo_force_loop_feedforward_f32_init(&params, &feedforward, &config, &feedforward_config);
///     tribo_force_loop_f32_reset(&state);
///     tribo_feedforward_f32_reset(&feedforward, &memory.state);     // nothing learned; left out, what was learned is kept
///     tribo_force_loop_feedforward_f32_attach(&state, &memory);
///     u = tribo_force_loop_f32_step(&params, &state, r, y, &signals);
///
/// The loop is otherwise the same, and so are its guarantees: limits, anti-windup, bad inputs (counted by the loop), change of
/// params by pointer, between methods as well. u goes on from where it was. A method that is taken up again has kept what it had
/// learned. While it runs, the paper's compensator stands still, and of its signals F^ is the force that the feed-forward expects
/// without friction, n is u - F^, L that of the way that r goes and f^ the friction fed forward; the rest is 0.
///
/// Without memory attached nothing is compensated. A corrupt memory is forgotten whole, once it gives a number that no force is.
/// Params for another breakaway or spread leave what was learned as it is, relative to these: reset it if that is not meant.
/// Not synchronized: one state and one memory, one tick.

#ifndef TRIBO_FORCE_LOOP_FEEDFORWARD_F32_H
#define TRIBO_FORCE_LOOP_FEEDFORWARD_F32_H

#include "tribo/force_loop_f32.h"

#ifdef __cplusplus
extern "C" {
#endif

/// params.method of a loop with the feed-forward.
extern const tribo_force_loop_f32_method_t tribo_force_loop_feedforward_f32;

/// Makes `params` of a loop with the feed-forward, and its own, to which `params` will point: they must live as long. Returns
/// what tribo_force_loop_f32_init and then tribo_feedforward_f32_init say. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_force_loop_feedforward_f32_init(tribo_force_loop_f32_params_t        *params,
                                                     tribo_feedforward_f32_params_t       *feedforward,
                                                     const tribo_force_loop_f32_config_t  *config,
                                                     const tribo_feedforward_f32_config_t *feedforward_config);

/// After a reset of `state`: `memory` starts anew with it, and keeps what was learned. It must live as long as `state`, and have
/// been reset once itself. Null: none.
void tribo_force_loop_feedforward_f32_attach(tribo_force_loop_f32_state_t   *state,
                                             tribo_feedforward_f32_memory_t *memory);

#ifdef __cplusplus
}
#endif

#endif
