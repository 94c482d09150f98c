// Shared by the tick and a change of params.

#ifndef TRIBO_LOOP_LOOP_F32_H
#define TRIBO_LOOP_LOOP_F32_H

#include "tribo/force_loop_f32.h"

#include "../number/ieee_f32.h"

#include <stddef.h>

/// Each pointer in the state has a seal, its complement: one with a flipped bit is not used, and counted where it is found.
static inline bool loop_sealed(const void *pointer, uintptr_t seal)
{
    return seal == ~(uintptr_t)pointer;
}

static inline void force_loop_f32_activate(tribo_force_loop_f32_state_t        *state,
                                           const tribo_force_loop_f32_params_t *params)
{
    state->active      = params;
    state->active_seal = ~(uintptr_t)params;
}

/// The memory of the method; null where none is attached.
static inline void *force_loop_f32_memory(const tribo_force_loop_f32_state_t *state)
{
    return loop_sealed(state->memory, state->memory_seal) ? state->memory : NULL;
}

/// The guard's factor on friction, 0 to 1.
static inline float force_loop_f32_fade(const tribo_force_loop_f32_params_t *params,
                                        const tribo_force_loop_f32_state_t  *state)
{
    return params->guard != NULL ? state->fade : 1.0f;
}

static inline bool force_loop_f32_bad(const tribo_force_loop_f32_params_t *params, float r_n, float y_n)
{
    return exceeds(r_n, params->input_max_n) || exceeds(y_n, params->input_max_n);
}

/// f^ of the last tick, faded by a guard.
static inline float force_loop_f32_faded(const tribo_force_loop_f32_params_t *params,
                                         const tribo_force_loop_f32_state_t  *state)
{
    return state->friction_n * force_loop_f32_fade(params, state);
}

/// Before the controller's step in the first tick with `params`: takes over from the old params without a jump of u. state.active
/// is not yet `params`: tribo_force_loop_f32_change_friction completes the change.
void tribo_force_loop_f32_change(const tribo_force_loop_f32_params_t *params,
                                 tribo_force_loop_f32_state_t        *state,
                                 float                                r_n,
                                 float                                y_n,
                                 float                                e_n);

/// Before the compensator's step: makes the controller subtract the jump of u that new friction would cause in the next tick.
void tribo_force_loop_f32_change_friction(const tribo_force_loop_f32_params_t *params,
                                          tribo_force_loop_f32_state_t        *state,
                                          float                                e_n,
                                          float                                u_n);

#endif
