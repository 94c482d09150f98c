#include "tribo/axis_f32.h"

#include "../number/words_f32.h"
#include "axis_config.h"

#define BLOB_VERSION TRIBO_AXIS_F32_BLOB_VERSION

static tribo_status_t axis_make_loop(tribo_axis_f32_params_t       *made,
                                     const axis_parts_t            *parts,
                                     const tribo_axis_f32_config_t *config,
                                     float                          full_scale_n)
{
    (void)full_scale_n;
    return tribo_force_loop_feedforward_f32_init(&made->loop, &made->feedforward, &parts->loop, &config->feedforward);
}

static tribo_status_t axis_make_guard(tribo_axis_f32_params_t        *made,
                                      const tribo_guard_f32_config_t *guard,
                                      float                           sample_time_s,
                                      float                           full_scale_n)
{
    (void)full_scale_n;
    return tribo_guard_f32_init(&made->guard, guard, sample_time_s);
}

static axis_learned_t axis_learned(const tribo_axis_f32_t *axis, uint32_t direction)
{
    const tribo_axis_f32_params_t *const  params  = axis->active;
    const tribo_feedforward_f32_learned_t learned = tribo_feedforward_f32_learned(&params->loop.compensator.friction,
                                                                                  &axis->memory.state,
                                                                                  direction,
                                                                                  params->usual_force_n);
    return (axis_learned_t){learned.L_n,
                            learned.relative_variance,
                            learned.travel_n,
                            learned.stays_at_bound,
                            learned.harms};
}

static float axis_times_less(const tribo_axis_f32_t *axis)
{
    const float ratio = axis->memory.state.monitor.ratio;
    return ratio > 0.0f ? 1.0f / ratio : 0.0f;
}

static float axis_share(const tribo_axis_f32_t *axis)
{
    return axis->loop.fade;
}

#include "axis.h"

tribo_status_t tribo_axis_f32_init(tribo_axis_f32_t *axis, const tribo_axis_f32_config_t *config)
{
    return start(axis, config, 1.0f);
}

tribo_status_t tribo_axis_f32_prepare(tribo_axis_f32_params_t *next, const tribo_axis_f32_config_t *config)
{
    return prepare(next, config, 1.0f);
}
