#include "tribo/axis_q31.h"

#include "../loop/loop_q31.h"
#include "../loop/prepare.h"
#include "../number/ieee_f32.h"
#include "axis_config.h"

#define BLOB_VERSION                TRIBO_AXIS_Q31_BLOB_VERSION
#define MOST_N(full_scale_n)        (full_scale_n)
#define GUARD_LEAST_N(full_scale_n) (1.001e-6f * (full_scale_n)) // what tribo_guard_q31_init accepts, rounding included
#define GUARD_MOST_N(full_scale_n)  (0.999999f * (full_scale_n))
#define LEARN_AT_ONCE(axis)         (void)(axis)           // the background learns by tribo_axis_q31_learn
#define PART_UNIT                   (1.0f / 2147483648.0f) // Q31

static tribo_status_t axis_make_loop(tribo_force_loop_q31_params_t       *params,
                                     const tribo_force_loop_f32_config_t *loop,
                                     tribo_controller_f32_make_t         *make,
                                     float                                full_scale_n)
{
    (void)make; // a PI is quantised like sections
    const tribo_force_loop_q31_config_t config = {.loop = *loop, .full_scale_n = full_scale_n};
    const tribo_status_t                status = tribo_force_loop_q31_init_method(params, &config);
    const bool fits = loop->usual_force_n <= full_scale_n; // the report asks for friction there
    return status == TRIBO_OK && !fits ? TRIBO_ERR_USUAL_FORCE : status;
}

static tribo_feedforward_learned_t axis_learned(const tribo_axis_q31_t *axis, uint32_t direction)
{
    const tribo_axis_q31_params_t *const params = axis->active;
    const int32_t force = (int32_t)(params->usual_force_n / params->full_scale_n * 2147483520.0f);
    return tribo_feedforward_q31_learned(&params->loop, &axis->feedforward, direction, force);
}

/// axis_f32.c explains it.
static tribo_feedforward_q31_memory_t *axis_memory(tribo_axis_q31_t *axis)
{
    return (tribo_feedforward_q31_memory_t *)&axis->feedforward;
}

static float axis_share(const tribo_axis_q31_t *axis)
{
    return (float)axis->guard.fade * (0.5f * PART_UNIT);
}

#include "axis.h"

tribo_status_t tribo_axis_q31_init(tribo_axis_q31_t *axis, const tribo_axis_f32_config_t *config, float full_scale_n)
{
    return start(axis, config, full_scale_n);
}

tribo_status_t tribo_axis_q31_prepare(tribo_axis_q31_params_t       *next,
                                      const tribo_axis_f32_config_t *config,
                                      float                          full_scale_n)
{
    return prepare(next, config, full_scale_n);
}

bool tribo_axis_q31_learn(tribo_axis_q31_t *axis)
{
    return axis->active != NULL && learn(axis);
}
