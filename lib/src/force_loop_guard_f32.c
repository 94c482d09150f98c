#include "tribo/force_loop_guard_f32.h"

#include "force_loop_f32_step.h"
#include "guard_f32_step.h"

#include <stddef.h>

void tribo_force_loop_guard_f32_watch(const tribo_guard_f32_params_t       *params,
                                      tribo_guard_f32_state_t              *guard,
                                      const tribo_force_loop_f32_params_t  *loop_params,
                                      tribo_force_loop_f32_state_t         *loop,
                                      float                                 r_n,
                                      float                                 y_n,
                                      const tribo_force_loop_f32_signals_t *signals)
{
    // The paper's method adds nothing but friction; the feed-forward adds the reference as well.
    tribo_feedforward_f32_memory_t *const memory = force_loop_f32_memory(loop);
    const float f = (memory != NULL && loop_params->feedforward != NULL) ? memory->signals.f_n : signals->feedforward_n;
    if (!force_loop_f32_bad(loop_params, r_n, y_n) && !exceeds(f, TRIBO_F32_FORCE_MAX_N))
    {
        guard_f32_watch(params, guard, r_n, y_n, f);
    }
    const float share = guard_f32_fade(params, guard);
    loop->friction_n *= share;
    if (memory != NULL) // in use or not, for a method that takes over
    {
        memory->state.share = share;
    }
}
