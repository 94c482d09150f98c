// Breakaway learned beside any loop, from its u and y alone, float32: the library's meter, play and learning in a row.

#ifndef TESTS_IDENTIFY_LEARN_F32_H
#define TESTS_IDENTIFY_LEARN_F32_H

#include "tribo/breakaway_learning_f32.h"
#include "tribo/friction_meter_f32.h"
#include "tribo/play_f32.h"

typedef struct
{
    tribo_friction_meter_f32_params_t     meter_params;
    tribo_breakaway_learning_f32_params_t learning_params;
    tribo_breakaway_f32_t                 prior; // L(F) as it is believed
    tribo_friction_meter_f32_state_t      meter;
    tribo_play_f32_state_t                slide;
    tribo_breakaway_learning_f32_state_t  learning;
    float                                 distance_n;
    float z_n, change_n; // the last friction, and its change from tick to tick, averaged
} learn_t;

static inline tribo_status_t learn_init(learn_t *learn, tribo_breakaway_f32_t prior)
{
    const tribo_breakaway_learning_f32_config_t config = tribo_breakaway_learning_f32_default();
    const tribo_path_f32_config_t               path   = tribo_path_f32_paper();

    tribo_status_t status = tribo_breakaway_learning_f32_init(&learn->learning_params, &config);
    if (status == TRIBO_OK)
    {
        status = tribo_friction_meter_f32_init(&learn->meter_params, &path, 0.02f, 0.001f);
    }
    learn->prior      = prior;
    learn->distance_n = learn->z_n = learn->change_n = 0.0f;
    tribo_friction_meter_f32_reset(&learn->meter, 0.0f);
    tribo_play_f32_reset(&learn->slide, 0.0f);
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
    tribo_friction_meter_f32_signals_t meter;
    tribo_friction_meter_f32_step(&learn->meter_params, &learn->meter, (float)u, (float)y, &meter);
    const int32_t before = learn->slide.way;
    const float   moved  = tribo_play_f32_step(&learn->slide, meter.force_n, 0.0015f, 0.0015f);
    const int32_t way    = learn->slide.way;
    const float   travel = (float)way * moved;
    const float   change = (float)way * meter.change_n;
    learn->distance_n    = (way == before ? learn->distance_n : 0.0f) + travel;
    // A loop that hunts shakes friction off: then u - F is no friction, and does not stand.
    const float jump = meter.friction_n - learn->z_n;
    learn->change_n += 0.01f * ((jump < 0.0f ? -jump : jump) - learn->change_n);
    learn->z_n        = meter.friction_n;
    const float prior = learn_prior(learn, meter.force_n);
    const bool  slides =
        travel > 0.0f && learn->distance_n > 0.005f && change < 0.5f * 0.001f && learn->change_n < 0.002f * prior;
    const uint32_t towards = way > 0 ? TRIBO_BREAKAWAY_POSITIVE : TRIBO_BREAKAWAY_NEGATIVE;
    if (slides)
    {
        tribo_breakaway_learning_f32_step(&learn->learning_params,
                                          &learn->learning,
                                          towards,
                                          travel,
                                          prior,
                                          (float)way * meter.friction_n);
    }
}

/// L and its doubt, 0 to 1, at a force.
static inline double learn_L(const learn_t *learn, uint32_t direction, double force_n, double *doubt)
{
    const tribo_breakaway_learning_f32_signals_t at =
        tribo_breakaway_learning_f32_at(&learn->learning_params,
                                        &learn->learning,
                                        direction,
                                        learn_prior(learn, (float)force_n));
    *doubt = (double)at.doubt;
    return (double)at.L_n;
}

#endif
