// What the paper's method and the others share of a tick: the check of its inputs, and what a change of params needs.

#ifndef TRIBO_FORCE_LOOP_Q31_STEP_H
#define TRIBO_FORCE_LOOP_Q31_STEP_H

#include "tribo/force_loop_q31.h"

#include "controller_q31_step.h"
#include "first_order_q31.h"
#include "limit_q31.h"

#include <stddef.h>

#define FORCE_LOOP_Q31_GAIN_FRACTION 29

// state.active points to the params of the last tick. Its complement is kept as a seal, so that a pointer with a flipped bit
// is recognised and not followed. state.memory likewise.

static inline void force_loop_q31_activate(tribo_force_loop_q31_state_t        *state,
                                           const tribo_force_loop_q31_params_t *params)
{
    state->active      = params;
    state->active_seal = ~(uintptr_t)params;
}

/// The params of the last tick; `params` after a reset or if the pointer is corrupt, which means no change.
static inline const tribo_force_loop_q31_params_t *force_loop_q31_active(const tribo_force_loop_q31_state_t  *state,
                                                                         const tribo_force_loop_q31_params_t *params)
{
    const bool good = state->active != NULL && state->active_seal == ~(uintptr_t)state->active;
    return good ? state->active : params;
}

static inline void force_loop_q31_attach(tribo_force_loop_q31_state_t *state, tribo_feedforward_q31_memory_t *memory)
{
    state->memory      = memory;
    state->memory_seal = ~(uintptr_t)memory;
}

/// Null where none is attached.
static inline tribo_feedforward_q31_memory_t *force_loop_q31_memory(const tribo_force_loop_q31_state_t *state)
{
    return state->memory_seal == ~(uintptr_t)state->memory ? state->memory : NULL;
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

/// r - y, or 0 for a bad input.
static inline int32_t force_loop_q31_error(const tribo_force_loop_q31_params_t *params,
                                           int32_t                              r,
                                           int32_t                              y,
                                           uint32_t                            *saturated)
{
    return force_loop_q31_bad(params, r, y) ? 0 : tribo_q31_subtract(r, y, saturated);
}

/// The controller's output for `e`, within 32 bits; no state advances.
static inline int32_t force_loop_q31_v(const tribo_controller_q31_params_t *params,
                                       tribo_controller_q31_state_t        *state,
                                       int32_t                              e)
{
    tribo_biquad_q31_outputs_t outputs;
    const uint32_t             carry       = state->cascade.carry;
    uint32_t                   not_counted = 0;
    const int32_t              y           = biquad_q31_output(&params->cascade, &state->cascade, e, &outputs);
    state->cascade.carry                   = carry;
    return tribo_q31_widen(y, params->cascade.output_scale, &not_counted);
}

/// Of friction `f`, what a guard has left. The feed-forward's memory knows its share.
static inline int32_t force_loop_q31_left(const tribo_force_loop_q31_state_t *state, int32_t f)
{
    const tribo_feedforward_q31_memory_t *const memory = force_loop_q31_memory(state);
    return memory != NULL && memory->state.share != UINT32_MAX ? part_of_q31(f, memory->state.share) : f;
}

/// What u was going to be in this tick under the params `from`, but for its limit, within 32 bits.
int32_t tribo_force_loop_q31_wanted(const tribo_force_loop_q31_params_t *from,
                                    tribo_force_loop_q31_state_t        *state,
                                    int32_t                              r,
                                    int32_t                              y);

/// What a method hands over to the paper's with. Only methods refer to it: a drive without them does not link it.
void tribo_force_loop_q31_hand_over(const tribo_force_loop_q31_params_t *from,
                                    const tribo_force_loop_q31_params_t *params,
                                    tribo_force_loop_q31_state_t        *state,
                                    int32_t                              r,
                                    int32_t                              y,
                                    int32_t                              e);

#endif
