/// The guard against over-compensation (guard_q31.h) beside a force loop, in fixed point, whatever its method:
///
///     u = tribo_force_loop_q31_step(&params, &state, r, y, &signals);
///     tribo_force_loop_guard_q31_watch(&guard_params, &guard, &params, &state, r, y, &signals);
///
/// A loop without a guard pays nothing for it. While the share of friction is below 1, a change of the friction model is not
/// without a bump: it is made up for whole, and takes effect in part. Not synchronized: one loop and its guard, one tick.

#ifndef TRIBO_FORCE_LOOP_GUARD_Q31_H
#define TRIBO_FORCE_LOOP_GUARD_Q31_H

#include "tribo/force_loop_q31.h"
#include "tribo/guard_q31.h"

#ifdef __cplusplus
extern "C" {
#endif

/// After a tick with `r` and `y` that gave `signals`: judges it, and sets the share of friction for the next one. A bad r or y
/// is not judged. Cannot fail.
void tribo_force_loop_guard_q31_watch(const tribo_guard_q31_params_t       *params,
                                      tribo_guard_q31_state_t              *guard,
                                      const tribo_force_loop_q31_params_t  *loop_params,
                                      tribo_force_loop_q31_state_t         *loop,
                                      int32_t                               r,
                                      int32_t                               y,
                                      const tribo_force_loop_q31_signals_t *signals);

#ifdef __cplusplus
}
#endif

#endif
