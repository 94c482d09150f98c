// The same in Q31, at the full scale of the rig. Forces of the learning are in units of 2^-29 full scales.

#ifndef TESTS_IDENTIFY_LEARN_Q31_H
#define TESTS_IDENTIFY_LEARN_Q31_H

#include "feedforward/breakaway_learning_q31.h"
#include "feedforward/friction_observer_q31.h"
#include "feedforward/hold_q31.h"
#include "feedforward/reference_model_f32.h"
#include "feedforward/reference_model_q31.h"
#include "tribo/feedforward_q31.h"

#include <math.h>
#include <stdlib.h>

typedef struct
{
    tribo_friction_observer_q31_params_t  meter_params;
    tribo_breakaway_learning_q31_params_t learning_params;
    tribo_breakaway_f32_t                 prior;
    tribo_friction_observer_q31_state_t   observer;
    tribo_play_q31_state_t                slide;
    tribo_breakaway_learning_q31_state_t  learning;
    int32_t                               distance;
    int32_t                               z, change; // the last friction, and its change from tick to tick, averaged
} learn_t;

static inline int32_t learn_units(double force_n)
{
    return (int32_t)lround(force_n / FULL_SCALE_N * 536870912.0);
}

static inline double learn_force(int64_t units)
{
    return (double)units / 536870912.0 * FULL_SCALE_N;
}

static inline tribo_status_t learn_init(learn_t *learn, tribo_breakaway_f32_t prior)
{
    const tribo_breakaway_learning_f32_config_t config = tribo_breakaway_learning_f32_default();
    const tribo_reference_model_f32_config_t    path   = tribo_reference_model_f32_paper();

    tribo_status_t status = tribo_breakaway_learning_q31_init(&learn->learning_params, &config, (float)FULL_SCALE_N);
    if (status == TRIBO_OK)
    {
        status = tribo_friction_observer_q31_init(&learn->meter_params, &path, 0.02f, 0.001f);
    }
    learn->prior    = prior;
    learn->distance = learn->z = learn->change = 0;
    tribo_friction_observer_q31_reset(&learn->observer, 0);
    play_q31_reset(&learn->slide, 0);
    tribo_breakaway_learning_q31_reset(&learn->learning_params, &learn->learning);
    return status;
}

/// In a drive the friction params have L(F) in Q31; here it is the belief, rounded.
static inline uint32_t learn_prior(const learn_t *learn, double force_n)
{
    return (uint32_t)learn_units((double)learn->prior.offset_n + (double)learn->prior.slope * fabs(force_n));
}

static inline void learn_step(learn_t *learn, double u, double y)
{
    tribo_friction_observer_q31_signals_t observer;
    friction_observer_q31_step(&learn->meter_params, &learn->observer, learn_units(u), learn_units(y), &observer);
    const int32_t before = learn->slide.sign;
    const int32_t half   = learn_units(0.0015);
    const int32_t moved  = play_q31_step(&learn->slide, observer.force, half, half);
    const int32_t sign   = learn->slide.sign;
    const int32_t travel = sign * moved;
    learn->distance      = (sign == before ? learn->distance : 0) + travel;
    // A loop that hunts shakes friction off: then u - F is no friction, and does not stand.
    learn->change += (abs(observer.friction - learn->z) - learn->change) / 100;
    learn->z             = observer.friction;
    const uint32_t prior = learn_prior(learn, learn_force(observer.force));
    if (travel > 0 && learn->distance > learn_units(0.005) && sign * observer.change < learn_units(0.5 * 0.001) &&
        (uint32_t)learn->change < prior / 500u)
    {
        breakaway_learning_q31_step(&learn->learning_params,
                                    &learn->learning,
                                    sign > 0 ? TRIBO_BREAKAWAY_POSITIVE : TRIBO_BREAKAWAY_NEGATIVE,
                                    (uint32_t)travel,
                                    prior,
                                    sign * observer.friction);
    }
}

static inline double learn_L(const learn_t *learn, uint32_t direction, double force_n, double *relative_variance)
{
    const tribo_breakaway_learning_q31_signals_t at = tribo_breakaway_learning_q31_at(&learn->learning_params,
                                                                                      &learn->learning,
                                                                                      direction,
                                                                                      learn_prior(learn, force_n));
    *relative_variance                              = (double)at.relative_variance / 2147483648.0;
    return learn_force(at.L);
}

#endif
