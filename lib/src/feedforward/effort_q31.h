// Learning from the effort of another loop in fixed point; effort_f32.h has the equations.
//
//     quantity                   format      range           bounded by
//     motion of a tick, slack    Q28         +-3.9; +-1/2    limited
//     z                          Q29 of FS   +-2             limited
//     X                          Q28         +-2^22          ticks of a slide
//     W, G                       Q29 of FS   +-2^23          likewise
//     |X'|, delta                Q8          2^22            likewise
//     a, l                       Q27 of FS   +-4             limited
//     V^; g                      Q26; Q32    0 to 4; 1/2     limited
//
// Sums wrap in a corrupt state alone; its slide does not count. Rounded towards zero: mirrored slides give mirrored results.
// Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_EFFORT_Q31_H
#define TRIBO_FEEDFORWARD_EFFORT_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"
#include "bank_q31.h"
#include "constants.h"
#include "learning_q31.h"
#include "state_q31.h"

#define EFFORT_Q31_WIDTH (INT32_C(1) << 28)
#define EFFORT_Q31_Q8    256u
#define EFFORT_Q31_MOST  (2 * (BANK_Q31_ONE - 1)) // of z

static inline void effort_q31_start(tribo_feedforward_q31_memory_t *memory, int32_t u)
{
    memory->motion.effort           = (tribo_feedforward_q31_effort_t){.side = 0};
    memory->state.observer.actuator = u;
}

/// Q29.
static inline int32_t effort_q31_weight(const tribo_feedforward_q31_memory_t *memory)
{
    return memory->motion.was_known != 0u ? memory->state.learned.weight[0] : BANK_Q31_ONE;
}

/// V times a level of friction, up to FS.
static inline uint32_t effort_q31_level(uint32_t level, int32_t V)
{
    return (uint32_t)bank_q31_times((int32_t)level, (uint32_t)V, 29, (uint32_t)BANK_Q31_ONE);
}

static inline uint32_t effort_q31_fold(const tribo_feedforward_weights_q31_t *x)
{
    return (uint32_t)x->weight[0] ^ (uint32_t)x->use[0] ^ (uint32_t)x->constant ^ learning_q31_fold(x->covariance, 4);
}

/// Sums of Q28 and Q29.
static inline int64_t effort_q31_sum(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a + (uint64_t)b);
}

/// A sum over the slide, Q29 of FS, over its travel of `k` bits less: Q27 of FS, within +-4.
static inline int32_t effort_q31_mean(int64_t sum, const learning_q31_divisor_t *travel, uint32_t k)
{
    const int64_t whole = tribo_q31_shift_to_zero(sum, k);
    const int32_t most  = whole < 0 ? -INT32_MAX : INT32_MAX;
    const int32_t mean  = learning_q31_over((int32_t)whole == whole ? (int32_t)whole : most, travel);
    return limit_q31(mean, -BANK_Q31_ONE, BANK_Q31_ONE);
}

static inline void effort_q31_change(const tribo_feedforward_q31_params_t *params,
                                     tribo_feedforward_weights_q31_t      *learned,
                                     int32_t                               by_V,
                                     int32_t                               by_c,
                                     uint32_t                              gain,
                                     uint32_t                              delta)
{
    const uint64_t wide   = tribo_q31_product(params->reversal, delta) >> 8; // Q29
    const uint32_t travel = wide < UINT32_MAX ? (uint32_t)wide : UINT32_MAX;
    const uint32_t back   = ~learning_q31_left(travel, params->forgetting_per_unit, 24);
    const int32_t  before = learned->weight[0];
    const int32_t  least  = BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MIN);

    learned->seal ^= effort_q31_fold(learned);
    learned->weight[0] = limit_q31(sum_q31(before, by_V), least, BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MAX));
    learned->constant  = limit_q31(sum_q31(learned->constant, by_c), -params->constant_max, params->constant_max);
    learned->use[0]    = sum_q31(learned->use[0], difference_q31(learned->weight[0], before));
    for (uint32_t j = 0; j < 4u; j++)
    {
        learned->covariance[j] -= part_of_q31(learned->covariance[j], gain);
    }
    learned->covariance[0] = learning_q31_left_of(learned->covariance[0], 0, 0, LEARNING_Q31_ONE, back);
    learned->seal ^= effort_q31_fold(learned);
}

/// `now` of Q8, `work` and `prior` of Q27.
static inline void effort_q31_learn(const tribo_feedforward_q31_params_t *params,
                                    tribo_feedforward_q31_state_t        *state,
                                    const tribo_feedforward_q31_effort_t *x,
                                    uint32_t                              now,
                                    int32_t                               work,
                                    int32_t                               prior)
{
    tribo_feedforward_weights_q31_t *const learned = &state->learned;

    const int32_t  last_work  = limit_q31(x->last_work, -BANK_Q31_ONE, BANK_Q31_ONE);
    const int32_t  last_prior = limit_q31(x->last_prior, 0, BANK_Q31_ONE);
    const uint32_t last       = tribo_q31_magnitude(x->last_travel);
    const uint32_t delta      = now < last ? now : last;
    const uint32_t gain       = ratio_q31(delta, delta + (uint32_t)EFFORT_WEIGHING * EFFORT_Q31_Q8); // Q32, by g_0

    const learning_q31_divisor_t both = learning_q31_divisor((uint32_t)(prior + last_prior));
    const int32_t                most = EFFORT_Q31_WIDTH - 1; // 4
    const int32_t                V    = limit_q31(learning_q31_over(work + last_work, &both), 0, most);
    const int32_t                rest = bank_q31_times(prior - last_prior, (uint32_t)V, 26, INT32_MAX);
    const int32_t                net  = limit_q31(difference_q31(work - last_work, rest), -2 * most, 2 * most);
    const int32_t                c    = x->side < 0 ? -2 * net : 2 * net; // half of it, Q29
    const int32_t                far  = 2 * params->constant_max;
    const int32_t                step = BANK_Q31_Q29(EFFORT_SURPRISE) / 8; // Q26
    const int32_t                by_V = 8 * limit_q31(V - learned->weight[0] / 8, -step, step);
    const int32_t                by_c = limit_q31(difference_q31(c, learned->constant), -far, far);
    effort_q31_change(params, learned, part_of_q31(by_V, gain), part_of_q31(by_c, gain), gain, delta);
    learned->travel += tribo_q31_product(params->reversal, now) / EFFORT_Q31_Q8;
    state_q31_note_bound(state);
}

static inline void effort_q31_end(const tribo_feedforward_q31_params_t *params, tribo_feedforward_q31_memory_t *memory)
{
    tribo_feedforward_q31_effort_t *const x = &memory->motion.effort;

    const int64_t travel = x->side < 0 ? effort_q31_sum(~x->travel, 1) : x->travel;
    if (x->ticks >= EFFORT_TICKS_MAX || travel < (int64_t)EFFORT_TRAVEL_MIN * EFFORT_Q31_WIDTH ||
        travel > (int64_t)EFFORT_TICKS_MAX * INT32_MAX)
    {
        return;
    }
    const uint32_t k     = 32u - tribo_q31_leading_zeros((uint32_t)(travel >> 28)); // 5 to 23
    const uint32_t now   = (uint32_t)(travel >> 20);                                // Q8
    const int64_t  known = x->side < 0 ? effort_q31_sum(~x->prior, 1) : x->prior;

    const learning_q31_divisor_t way   = learning_q31_divisor((uint32_t)(travel >> k));
    const int32_t                work  = effort_q31_mean(x->work, &way, k);
    const int32_t                mean  = effort_q31_mean(known, &way, k);
    const int32_t                prior = mean + part_of_q31(mean, 2u * ratio_q31(2u * EFFORT_Q31_Q8, now));
    if (prior <= 0)
    {
        return;
    }
    const int32_t signed_now = x->side < 0 ? -(int32_t)now : (int32_t)now;
    if (bank_q31_sign(x->last_travel) == -bank_q31_sign(signed_now))
    {
        effort_q31_learn(params, &memory->state, x, now, work, prior);
    }
    x->last_travel = signed_now;
    x->last_work   = work;
    x->last_prior  = prior;
}

static inline void effort_q31_step(const tribo_feedforward_q31_params_t *params,
                                   tribo_feedforward_q31_memory_t       *memory,
                                   const bank_q31_prior_t               *prior)
{
    tribo_feedforward_q31_effort_t *const x = &memory->motion.effort;

    const int32_t most = BANK_Q31_Q29(EFFORT_FASTEST_Q31);
    const int32_t z =
        limit_q31(difference_q31(memory->state.observer.actuator, prior->load), -EFFORT_Q31_MOST, EFFORT_Q31_MOST);
    const int32_t measured = memory->motion.measured;
    const bool    beyond   = measured > most || measured < -most;
    const int32_t moved    = limit_q31(x->moved, -most / 2, most / 2);
    const int32_t effort   = limit_q31(x->effort, -EFFORT_Q31_MOST, EFFORT_Q31_MOST);
    x->moved               = first_order_q31_step(moved, beyond ? 0 : measured / 2, params->observer_part);
    x->effort              = first_order_q31_step(effort, z, params->observer_part);

    const int32_t half   = EFFORT_Q31_WIDTH / 2;
    const int32_t wanted = limit_q31(x->slack, -half, half) + x->moved;
    x->slack             = limit_q31(wanted, -half, half);
    const int32_t sign   = bank_q31_sign(wanted - x->slack);
    if (sign != 0 && sign != x->side)
    {
        effort_q31_end(params, memory);
        x->side   = (int8_t)sign;
        x->ticks  = 0;
        x->travel = 0;
        x->work   = 0;
        x->prior  = 0;
    }
    x->ticks = beyond ? EFFORT_TICKS_MAX : x->ticks;
    if (x->ticks < EFFORT_TICKS_MAX)
    {
        x->ticks++;
        x->travel = effort_q31_sum(x->travel, x->moved);
        x->work   = effort_q31_sum(x->work, tribo_q31_shift_to_zero(tribo_q31_multiply(x->effort, x->moved), 28));
        x->prior =
            effort_q31_sum(x->prior, tribo_q31_shift_to_zero(tribo_q31_multiply((int32_t)prior->L, x->moved), 28));
    }
}

#endif
