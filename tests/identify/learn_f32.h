// Breakaway learned beside any loop, from its u and y alone, float32: the library's observer, play and learning in a row.

#ifndef TESTS_IDENTIFY_LEARN_F32_H
#define TESTS_IDENTIFY_LEARN_F32_H

#include "feedforward/breakaway_learning_f32.h"
#include "feedforward/friction_observer_f32.h"
#include "feedforward/play_f32.h"
#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"

typedef struct
{
    tribo_friction_observer_f32_params_t  meter_params;
    tribo_breakaway_learning_f32_params_t learning_params;
    tribo_breakaway_f32_t                 prior; // L(F) as it is believed
    tribo_friction_observer_f32_state_t   observer;
    tribo_play_f32_state_t                slide;
    tribo_breakaway_learning_f32_state_t  learning;
    float                                 distance_n;
    float z_n, change_n; // the last friction, and its change from tick to tick, averaged
} learn_t;

static inline tribo_status_t learn_init(learn_t *learn, tribo_breakaway_f32_t prior)
{
    const tribo_breakaway_learning_f32_config_t config = tribo_breakaway_learning_f32_default();
    const tribo_reference_model_f32_config_t    path   = tribo_reference_model_f32_paper();

    tribo_status_t status = tribo_breakaway_learning_f32_init(&learn->learning_params, &config);
    if (status == TRIBO_OK)
    {
        status = tribo_friction_observer_f32_init(&learn->meter_params, &path, 0.02f, 0.001f);
    }
    learn->prior      = prior;
    learn->distance_n = learn->z_n = learn->change_n = 0.0f;
    tribo_friction_observer_f32_reset(&learn->observer, 0.0f);
    play_f32_reset(&learn->slide, 0.0f);
    tribo_breakaway_learning_f32_reset(&learn->learning_params, &learn->learning);
    return status;
}

static inline float learn_prior(const learn_t *learn, float force_n)
{
    return learn->prior.offset_n + learn->prior.slope * (force_n < 0.0f ? -force_n : force_n);
}

/// After each tick, with u as applied and the sensor's y.
static inline void learn_step(learn_t *learn, double u, double y)
{
    tribo_friction_observer_f32_signals_t observer;
    friction_observer_f32_step(&learn->meter_params, &learn->observer, (float)u, (float)y, &observer);
    const int32_t before = learn->slide.sign;
    const float   moved  = play_f32_step(&learn->slide, observer.force_n, 0.0015f, 0.0015f);
    const int32_t sign   = learn->slide.sign;
    const float   travel = (float)sign * moved;
    const float   change = (float)sign * observer.change_n;
    learn->distance_n    = (sign == before ? learn->distance_n : 0.0f) + travel;
    // A loop that hunts shakes friction off: then u - F is no friction, and does not stand.
    const float jump = observer.friction_n - learn->z_n;
    learn->change_n += 0.01f * ((jump < 0.0f ? -jump : jump) - learn->change_n);
    learn->z_n        = observer.friction_n;
    const float prior = learn_prior(learn, observer.force_n);
    const bool  slides =
        travel > 0.0f && learn->distance_n > 0.005f && change < 0.5f * 0.001f && learn->change_n < 0.002f * prior;
    const uint32_t towards = sign > 0 ? TRIBO_BREAKAWAY_POSITIVE : TRIBO_BREAKAWAY_NEGATIVE;
    if (slides)
    {
        breakaway_learning_f32_step(&learn->learning_params,
                                    &learn->learning,
                                    towards,
                                    travel,
                                    prior,
                                    (float)sign * observer.friction_n);
    }
}

/// L and its relative variance, 0 to 1, at a force.
static inline double learn_L(const learn_t *learn, uint32_t direction, double force_n, double *relative_variance)
{
    const tribo_breakaway_learning_f32_signals_t at =
        tribo_breakaway_learning_f32_at(&learn->learning_params,
                                        &learn->learning,
                                        direction,
                                        learn_prior(learn, (float)force_n));
    *relative_variance = (double)at.relative_variance;
    return (double)at.L_n;
}

#endif
