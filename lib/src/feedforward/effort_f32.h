// Learning from the effort of another loop, single precision: "Learned from another loop's effort" of docs/feedforward.md.
//
// From a reversal to the next no kinetic energy is left over. So u does the work of friction and load alone:
//
//     W = integral of z dx = V l |X| + c X          z = u_1 - D          X: of a slide, with its sign
//
// and two slides, one in each direction, tell V and c apart. No loops; divisions only where a slide ends.
// Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_EFFORT_F32_H
#define TRIBO_FEEDFORWARD_EFFORT_F32_H

#include "tribo/feedforward_f32.h"

#include "../number/first_order_f32.h"
#include "bank_f32.h"
#include "constants.h"
#include "learning_f32.h"
#include "state_f32.h"

/// No slide yet, at u.
static inline void effort_f32_start(tribo_feedforward_f32_memory_t *memory, float u)
{
    memory->motion.effort             = (tribo_feedforward_f32_effort_t){.side = 0};
    memory->state.observer.actuator_n = u;
}

/// V.
static inline float effort_f32_weight(const tribo_feedforward_f32_memory_t *memory)
{
    return memory->motion.was_known != 0u ? memory->state.learned.weight[0] : 1.0f;
}

/// The bits of the numbers that a slide changes.
static inline uint32_t effort_f32_fold(const tribo_feedforward_weights_f32_t *x)
{
    return bits_f32(x->weight[0]) ^ bits_f32(x->use[0]) ^ bits_f32(x->constant_n) ^ learning_f32_fold(x->covariance, 4);
}

/// Two slides, `work` and `prior` of this one: V_0 and c_0.
static inline void effort_f32_learn(const tribo_feedforward_f32_params_t *params,
                                    tribo_feedforward_f32_state_t        *state,
                                    const tribo_feedforward_f32_effort_t *x,
                                    float                                 work,
                                    float                                 prior)
{
    tribo_feedforward_weights_f32_t *const learned = &state->learned;

    const float now    = magnitude(x->travel);
    const float last   = magnitude(x->last_travel);
    const float delta  = now < last ? now : last;
    const float gain   = EFFORT_GAIN * delta / (delta + EFFORT_WEIGHING);
    const float V      = limit_f32((work + x->last_work) / (prior + x->last_prior), 0.0f, FEEDFORWARD_F_MAX);
    const float net    = work - x->last_work - V * (prior - x->last_prior);
    const float c      = x->side < 0 ? -0.5f * net : 0.5f * net;
    const float most   = params->constant_max_n;
    const float by_V   = gain * bound_f32(V - learned->weight[0], EFFORT_SURPRISE);
    const float by_c   = gain * bound_f32(c - learned->constant_n, 2.0f * most);
    const float back   = limit_f32(params->forgetting_per_n * params->reversal_n * delta, 0.0f, 1.0f);
    const float before = learned->weight[0];

    learned->seal ^= effort_f32_fold(learned);
    learned->weight[0]  = learning_f32_moved(before, by_V, FEEDFORWARD_WEIGHT_MIN, FEEDFORWARD_WEIGHT_MAX);
    learned->constant_n = learning_f32_moved(learned->constant_n, by_c, -most, most);
    learned->use[0] += learned->weight[0] - before;
    for (uint32_t j = 0; j < 4u; j++)
    {
        learned->covariance[j] *= 1.0f - gain;
    }
    learned->covariance[0] = learning_f32_left(learned->covariance[0], 0.0f, back);
    learned->travel_n += params->reversal_n * now;
    learned->seal ^= effort_f32_fold(learned);
    state_f32_note_bound(state);
}

/// Step 5: a slide ends.
static inline void effort_f32_end(const tribo_feedforward_f32_params_t *params, tribo_feedforward_f32_memory_t *memory)
{
    tribo_feedforward_f32_effort_t *const x = &memory->motion.effort;

    const float travel = x->side < 0 ? -x->travel : x->travel;
    if (x->ticks >= EFFORT_TICKS_MAX || !(travel >= EFFORT_TRAVEL_MIN))
    {
        return;
    }
    const float work  = x->work / travel;
    const float prior = x->prior / x->travel * (1.0f + 2.0f / travel); // back by a width: friction there and back
    if (!(prior > 0.0f) || exceeds(work, FEEDFORWARD_FORCE_MAX_N))
    {
        return;
    }
    if (x->last_travel * x->travel < 0.0f)
    {
        effort_f32_learn(params, &memory->state, x, work, prior);
    }
    x->last_travel = x->travel;
    x->last_work   = work;
    x->last_prior  = prior;
}

/// Steps 2 to 5 of a tick with a known motion.
static inline void effort_f32_step(const tribo_feedforward_f32_params_t *params,
                                   tribo_feedforward_f32_memory_t       *memory,
                                   const bank_f32_prior_t               *prior)
{
    tribo_feedforward_f32_effort_t *const x = &memory->motion.effort;

    const float z      = memory->state.observer.actuator_n - prior->load_n;
    const bool  beyond = exceeds(memory->motion.measured, EFFORT_FASTEST_F32);
    const float moved  = first_order_f32_step(x->moved, beyond ? 0.0f : memory->motion.measured, params->observer_part);
    const float effort = first_order_f32_step(x->effort_n, z, params->observer_part);
    x->moved           = exceeds(moved, EFFORT_FASTEST_F32) ? 0.0f : moved;
    x->effort_n        = exceeds(effort, FEEDFORWARD_FORCE_MAX_N) ? 0.0f : effort;

    const float wanted = x->slack + x->moved;
    x->slack           = bound_f32(wanted, 0.5f);
    const int32_t sign = bank_f32_sign(wanted - x->slack);
    if (sign != 0 && sign != x->side)
    {
        effort_f32_end(params, memory);
        x->side   = (int8_t)sign;
        x->ticks  = 0;
        x->travel = 0.0f;
        x->work   = 0.0f;
        x->prior  = 0.0f;
    }
    x->ticks = beyond ? EFFORT_TICKS_MAX : x->ticks;
    if (x->ticks < EFFORT_TICKS_MAX)
    {
        x->ticks++;
        x->travel += x->moved;
        x->work += x->effort_n * x->moved;
        x->prior += prior->L_n * x->moved;
    }
}

#endif
