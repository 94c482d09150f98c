// Shared by the tick and a change of params.

#ifndef TRIBO_LOOP_LOOP_Q31_H
#define TRIBO_LOOP_LOOP_Q31_H

#include "tribo/force_loop_q31.h"

#include "../number/first_order_q31.h"
#include "loop_f32.h"

#include <stddef.h>

#define FORCE_LOOP_Q31_GAIN_FRACTION 29

static inline void force_loop_q31_activate(tribo_force_loop_q31_state_t        *state,
                                           const tribo_force_loop_q31_params_t *params)
{
    state->active      = params;
    state->active_seal = ~(uintptr_t)params;
}

/// The memory of the method; null where none is attached.
static inline void *force_loop_q31_memory(const tribo_force_loop_q31_state_t *state)
{
    return loop_sealed(state->memory, state->memory_seal) ? state->memory : NULL;
}

/// The guard's factor on friction, Q32.
static inline uint32_t force_loop_q31_fade(const tribo_force_loop_q31_params_t *params,
                                           const tribo_force_loop_q31_state_t  *state)
{
    return params->guard != NULL ? state->fade : UINT32_MAX;
}

/// True if |x| > max >= 0. x + max is within 0 to 2 max otherwise, and 2 max fits an unsigned number.
static inline bool force_loop_q31_exceeds(int32_t x, int32_t max)
{
    return (uint32_t)x + (uint32_t)max > 2u * (uint32_t)max;
}

static inline bool force_loop_q31_bad(const tribo_force_loop_q31_params_t *params, int32_t r, int32_t y)
{
    return force_loop_q31_exceeds(r, params->input_max) || force_loop_q31_exceeds(y, params->input_max);
}

/// The paper's friction term of u, gain f^[k-1]: Q29 x Q31, rounded down to Q31.
static inline int32_t force_loop_q31_term(const tribo_force_loop_q31_params_t *params, int32_t f, uint32_t *saturated)
{
    return tribo_q31_narrow(tribo_q31_multiply(params->gain, f), FORCE_LOOP_Q31_GAIN_FRACTION, saturated);
}

/// A friction times a guard's factor, Q32.
static inline int32_t faded_q31(int32_t f, uint32_t fade)
{
    return fade != UINT32_MAX ? part_of_q31(f, fade) : f;
}

/// f^ of the last tick, faded by a guard.
static inline int32_t force_loop_q31_faded(const tribo_force_loop_q31_params_t *params,
                                           const tribo_force_loop_q31_state_t  *state)
{
    return faded_q31(state->friction, force_loop_q31_fade(params, state));
}

/// Before the controller's step in the first tick with `params`: takes over from the old params without a jump of u. state.active
/// is not yet `params`: tribo_force_loop_q31_change_friction completes the change.
void tribo_force_loop_q31_change(const tribo_force_loop_q31_params_t *params,
                                 tribo_force_loop_q31_state_t        *state,
                                 int32_t                              r,
                                 int32_t                              y,
                                 int32_t                              e);

/// Before the compensator's step: makes the controller subtract the jump of u that new friction would cause in the next tick.
void tribo_force_loop_q31_change_friction(const tribo_force_loop_q31_params_t *params,
                                          tribo_force_loop_q31_state_t        *state,
                                          int32_t                              e,
                                          int32_t                              u);

#endif
