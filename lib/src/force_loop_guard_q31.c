#include "tribo/force_loop_guard_q31.h"

#include "feedforward_q31_step.h"
#include "first_order_q31.h"
#include "force_loop_q31_step.h"
#include "guard_q31_step.h"

#include <stddef.h>

void tribo_force_loop_guard_q31_watch(const tribo_guard_q31_params_t       *params,
                                      tribo_guard_q31_state_t              *guard,
                                      const tribo_force_loop_q31_params_t  *loop_params,
                                      tribo_force_loop_q31_state_t         *loop,
                                      int32_t                               r,
                                      int32_t                               y,
                                      const tribo_force_loop_q31_signals_t *signals)
{
    // The paper's method adds nothing but friction; the feed-forward adds the reference as well.
    tribo_feedforward_q31_memory_t *const memory = force_loop_q31_memory(loop);
    const int32_t f = (memory != NULL && loop_params->feedforward != NULL) ? feedforward_q31_outside(memory->signals.f)
                                                                           : signals->feedforward;
    if (!force_loop_q31_bad(loop_params, r, y))
    {
        guard_q31_watch(params, guard, r, y, f);
    }
    const uint32_t share = guard_q31_fade(params, guard);
    if (share != UINT32_MAX)
    {
        loop->friction = part_of_q31(loop->friction, share);
    }
    if (memory != NULL) // in use or not, for a method that takes over
    {
        memory->state.share = share;
    }
}
