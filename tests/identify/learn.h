// Breakaway learned beside any loop, from its u and y alone: an observer in double precision, and the learner of the library.

#ifndef TESTS_IDENTIFY_LEARN_H
#define TESTS_IDENTIFY_LEARN_H

#include ARITH_HEADER
#include "feedforward/learner.h"

#include <math.h>

typedef struct
{
    tribo_force_loop_f32_params_t  loop; // with the belief
    tribo_feedforward_f32_params_t params;
    tribo_feedforward_f32_memory_t memory;
    double                         offset, slope;
    double                         actuator, sensor, force, difference, travelled, friction;
    long                           ticks;
} learn_t;

static inline tribo_status_t learn_init(learn_t *learn, tribo_breakaway_f32_t belief)
{
    const tribo_feedforward_f32_config_t method = tribo_feedforward_f32_default();
    tribo_force_loop_f32_config_t        config = tribo_force_loop_f32_paper();
    config.compensator.friction.positive        = belief;
    config.compensator.friction.negative        = belief;
    *learn = (learn_t){.offset = (double)belief.offset_n, .slope = (double)belief.slope};
    tribo_feedforward_f32_reset(&learn->memory.state);
    config.method = tribo_feedforward_f32_use(&learn->params, &method);
    return tribo_force_loop_f32_init(&learn->loop, &config);
}

/// After each tick, with u as applied and the sensor's y: step 8 of docs/feedforward.md, without noise.
static inline void learn_step(learn_t *learn, double u, double y)
{
    const double fast   = (double)learn->params.fast_part;
    const double before = learn->force;
    const double half   = 0.1 * (double)learn->params.reversal;
    learn->actuator += (double)learn->params.actuator_part * (u - learn->actuator);
    learn->sensor += (double)learn->params.sensor_part * (learn->actuator - learn->sensor);
    learn->force += fast * (y - learn->force);
    learn->difference += fast * (learn->sensor - y - learn->difference);
    learn->friction  = learn->difference - (double)learn->params.damping_gain * (learn->force - before);
    learn->travelled = fmin(learn->force + half, fmax(learn->force - half, learn->travelled));
    learn->ticks++;
    if (learn->ticks % 10 == 0)
    {
        tribo_feedforward_f32_weights_t unused;
        const learner_sample_t          sample = {.travelled_n = (float)learn->travelled,
                                                  .force_n     = (float)learn->force,
                                                  .friction_n  = (float)learn->friction,
                                                  .L_n    = (float)(learn->offset + learn->slope * fabs(learn->force)),
                                                  .learns = true,
                                                  .starts = learn->ticks == 10};
        tribo_learner_step(&learn->params.learning, &learn->memory.state.learner, &sample, &unused);
    }
}

/// L and its relative variance, 0 to 1, at a force.
static inline double learn_L(const learn_t *learn, uint32_t direction, double force_n, double *relative_variance)
{
    const tribo_feedforward_learned_t at =
        tribo_feedforward_f32_learned(&learn->loop, &learn->memory.state, direction, (float)force_n);
    *relative_variance = (double)at.relative_variance;
    return (double)at.L_n;
}

#endif
