// What the paper's method and the others share of a tick: the check of its inputs, and what a change of params needs.

#ifndef TRIBO_FORCE_LOOP_F32_STEP_H
#define TRIBO_FORCE_LOOP_F32_STEP_H

#include "tribo/force_loop_f32.h"

#include "controller_f32_step.h"
#include "limit_f32.h"

#include <stddef.h>

// state.active points to the params of the last tick. Its complement is kept as a seal, so that a pointer with a flipped bit
// is recognised and not followed. state.memory likewise.

static inline void force_loop_f32_activate(tribo_force_loop_f32_state_t        *state,
                                           const tribo_force_loop_f32_params_t *params)
{
    state->active      = params;
    state->active_seal = ~(uintptr_t)params;
}

/// The params of the last tick; `params` after a reset or if the pointer is corrupt, which means no change.
static inline const tribo_force_loop_f32_params_t *force_loop_f32_active(const tribo_force_loop_f32_state_t  *state,
                                                                         const tribo_force_loop_f32_params_t *params)
{
    const bool good = state->active != NULL && state->active_seal == ~(uintptr_t)state->active;
    return good ? state->active : params;
}

static inline void force_loop_f32_attach(tribo_force_loop_f32_state_t *state, tribo_feedforward_f32_memory_t *memory)
{
    state->memory      = memory;
    state->memory_seal = ~(uintptr_t)memory;
}

/// Null where none is attached.
static inline tribo_feedforward_f32_memory_t *force_loop_f32_memory(const tribo_force_loop_f32_state_t *state)
{
    return state->memory_seal == ~(uintptr_t)state->memory ? state->memory : NULL;
}

static inline bool force_loop_f32_bad(const tribo_force_loop_f32_params_t *params, float r_n, float y_n)
{
    return exceeds(r_n, params->input_max_n) || exceeds(y_n, params->input_max_n);
}

/// The controller's output for `e`; no state advances.
static inline float force_loop_f32_v(const tribo_controller_f32_params_t *params,
                                     tribo_controller_f32_state_t        *state,
                                     float                                e)
{
    tribo_biquad_f32_outputs_t outputs;
    return biquad_f32_output(&params->cascade, &state->cascade, e, &outputs);
}

/// What u was going to be where the friction of the last tick is fed back.
static inline float force_loop_f32_fed_back(const tribo_force_loop_f32_params_t *params,
                                            tribo_force_loop_f32_state_t        *state,
                                            float                                r_n,
                                            float                                y_n)
{
    const float e = force_loop_f32_bad(params, r_n, y_n) ? 0.0f : r_n - y_n;
    return force_loop_f32_v(&params->controller, &state->controller, e) + params->gain * state->friction_n;
}

/// Of friction `f`, what a guard has left. The feed-forward's memory knows its share.
static inline float force_loop_f32_left(const tribo_force_loop_f32_state_t *state, float f)
{
    const tribo_feedforward_f32_memory_t *const memory = force_loop_f32_memory(state);
    return memory != NULL && memory->state.share < 1.0f ? f * memory->state.share : f;
}

/// What u was going to be in this tick under the params `from`, but for its limit.
float tribo_force_loop_f32_wanted(const tribo_force_loop_f32_params_t *from,
                                  tribo_force_loop_f32_state_t        *state,
                                  float                                r_n,
                                  float                                y_n);

/// What a method hands over to the paper's with. Only methods refer to it: a drive without them does not link it.
void tribo_force_loop_f32_hand_over(const tribo_force_loop_f32_params_t *from,
                                    const tribo_force_loop_f32_params_t *params,
                                    tribo_force_loop_f32_state_t        *state,
                                    float                                r_n,
                                    float                                y_n,
                                    float                                e);

#endif
