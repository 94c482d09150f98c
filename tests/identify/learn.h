// Breakaway learned beside any loop, from its u and y alone: the observer and the learning of the library's feed-forward in a row.

#ifndef TESTS_IDENTIFY_LEARN_H
#define TESTS_IDENTIFY_LEARN_H

#include ARITH_HEADER
#if TRIBO_IS_Q31
#include "feedforward/learning_q31.h"
#else
#include "feedforward/learning_f32.h"
#endif

typedef struct
{
    TRIBO(force_loop, params_t) loop; // with the belief
    TRIBO(feedforward, params_t) params;
    TRIBO(feedforward, state_t) state;
    tribo_point_t table[TRIBO_BREAKAWAY_POINTS_MAX];
} learn_t;

static inline tribo_status_t learn_init(learn_t *learn, tribo_breakaway_f32_t belief)
{
    const tribo_feedforward_f32_config_t method = tribo_feedforward_f32_default();
    tribo_force_loop_f32_config_t        config = tribo_force_loop_f32_paper();
    config.compensator.friction.positive        = belief;
    config.compensator.friction.negative        = belief;
    TRIBO(feedforward, reset)(&learn->state);
    TRIBO_PART(observer, start)(&learn->state.observer, 0);
    return tribo_init_feedforward(&learn->loop, learn->table, &learn->params, &config, &method, (float)FULL_SCALE_N);
}

/// After each tick, with u as applied and the sensor's y.
static inline void learn_step(learn_t *learn, double u, double y)
{
    const tribo_force_t full = TRIBO_EITHER(1, 4); // forces inside are Q29
    TRIBO_PART(observer, step)(&learn->params, &learn->state.observer, to_force(u) / full, to_force(y) / full);
    TRIBO_PART(learning, step)(&learn->params, &learn->loop.compensator.friction, &learn->state, 0, true);
}

/// L and its relative variance, 0 to 1, at a force.
static inline double learn_L(const learn_t *learn, uint32_t direction, double force_n, double *relative_variance)
{
    const TRIBO(feedforward, learned_t) at =
        TRIBO(feedforward, learned)(&learn->loop.compensator.friction, &learn->state, direction, to_force(force_n));
    *relative_variance = TRIBO_LEARNED_RELATIVE_VARIANCE(double, at.relative_variance);
    return TRIBO_LEARNED_N(double, at.TRIBO_N(L), FULL_SCALE_N);
}

#endif
