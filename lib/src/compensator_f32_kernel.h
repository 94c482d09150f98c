// One tick of the compensator without a table, inline, for an input that is known to be good. F^ always is: the arm sees to
// it.

#ifndef TRIBO_COMPENSATOR_F32_KERNEL_H
#define TRIBO_COMPENSATOR_F32_KERNEL_H

#include "tribo/compensator_f32.h"

#include "arm_f32_kernel.h"
#include "friction_f32_kernel.h"

static inline float compensator_f32_kernel(const tribo_compensator_f32_params_t *params,
                                           tribo_compensator_f32_state_t        *state,
                                           float                                 u_n,
                                           tribo_compensator_f32_signals_t      *signals)
{
    const float force_n = state->arm.force_n;
    const float n       = u_n - force_n + params->friction.gravity_n;
    signals->force_n    = force_n;
    const float f = friction_f32_kernel(&params->friction, &state->friction, n, force_n, &signals->friction, false);

    // n - f is u + g - F^ - f^, and exactly 0 while the arm sticks.
    (void)arm_f32_kernel(&params->arm, &state->arm, n - f);
    return f;
}

#endif
