#include "tribo/axis_f32.h"

#include "../loop/loop_f32.h"
#include "../loop/prepare.h"
#include "axis_config.h"

#define BLOB_VERSION                TRIBO_AXIS_F32_BLOB_VERSION
#define MOST_N(full_scale_n)        TRIBO_F32_FORCE_MAX_N
#define GUARD_LEAST_N(full_scale_n) 0.0f
#define GUARD_MOST_N(full_scale_n)  TRIBO_F32_FORCE_MAX_N
#define LEARN_AT_ONCE(axis)         (void)learn(axis) // a processor with an FPU has the time for it in a tick

static tribo_status_t axis_make_loop(tribo_force_loop_f32_params_t       *params,
                                     const tribo_force_loop_f32_config_t *loop,
                                     tribo_controller_f32_make_t         *make,
                                     float                                full_scale_n)
{
    (void)full_scale_n;
    return tribo_force_loop_f32_init_method(params, loop, make);
}

static tribo_feedforward_learned_t axis_learned(const tribo_axis_f32_t *axis, uint32_t direction)
{
    return tribo_feedforward_f32_learned(&axis->active->loop,
                                         &axis->feedforward,
                                         direction,
                                         axis->active->usual_force_n);
}

/// The functions of the feed-forward take its whole memory, and read its first member only; the motion after it belongs
/// to the method without a force sensor.
static tribo_feedforward_f32_memory_t *axis_memory(tribo_axis_f32_t *axis)
{
    return (tribo_feedforward_f32_memory_t *)&axis->feedforward;
}

static float axis_share(const tribo_axis_f32_t *axis)
{
    return axis->guard.fade;
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
