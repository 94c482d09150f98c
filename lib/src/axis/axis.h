// A force axis. This text serves both arithmetics and is included by axis_f32.c and axis_q31.c, after the functions
// that differ.

#include "../feedforward/learner.h"
#include "../loop/method.h"
#include "axis_config.h"

typedef NAME(axis, t) axis_t;
typedef NAME(axis, params_t) axis_params_t;
typedef NAME(axis, blob_t) axis_blob_t;

_Static_assert(offsetof(axis_t, feedforward) % _Alignof(NAME(feedforward, memory_t)) == 0 &&
                   _Alignof(axis_t) >= _Alignof(NAME(feedforward, memory_t)),
               "axis_memory points to a feed-forward's memory");

/// The config of the guard, from the configured breakaway at the usual force.
static tribo_guard_f32_config_t guard_config(const tribo_force_loop_f32_config_t *loop,
                                             const tribo_axis_f32_config_t       *config,
                                             float                                full_scale_n)
{
    const tribo_breakaway_f32_t *const up   = &loop->compensator.friction.positive;
    const tribo_breakaway_f32_t *const down = &loop->compensator.friction.negative;
    (void)full_scale_n; // not used in float32

    const float B   = 0.5f * (up->offset_n + down->offset_n + (up->slope + down->slope) * loop->usual_force_n);
    const float lag = tribo_feedforward_f32_lag_s(&config->feedforward, &loop->compensator.arm);

    tribo_guard_f32_config_t guard = tribo_guard_f32_tuned(B, lag, config->noise_n, loop->sample_time_s);
    guard.turn_n                   = limit_f32(guard.turn_n, GUARD_LEAST_N(full_scale_n), GUARD_MOST_N(full_scale_n));
    guard.stray_n                  = limit_f32(guard.stray_n, GUARD_LEAST_N(full_scale_n), GUARD_MOST_N(full_scale_n));
    return guard;
}

/// The status of the loop's init, about the field that the axis' config has instead of a derived one.
static tribo_status_t status_of(tribo_status_t status, const tribo_axis_f32_config_t *config)
{
    const bool is_derived = (status == TRIBO_ERR_PRESLIDING && config->feedforward.presliding_n == 0.0f) ||
                            (status == TRIBO_ERR_REVERSAL_WIDTH && config->feedforward.reversal_n == 0.0f);
    return is_derived ? TRIBO_ERR_AXIS_BREAKAWAY : status;
}

static tribo_status_t prepare(axis_params_t *params, const tribo_axis_f32_config_t *config, float full_scale_n)
{
    tribo_force_loop_f32_config_t loop;
    axis_params_t                 made;
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_axis_config_expand(&loop, config, MOST_N(full_scale_n));
    if (status == TRIBO_OK)
    {
        const tribo_guard_f32_config_t guard = guard_config(&loop, config, full_scale_n);
        loop.method                          = NAME(feedforward, use)(&made.feedforward, &config->feedforward);
        loop.guard                           = NAME(guard, use)(&made.guard, &guard);
        status = status_of(axis_make_loop(&made.loop, &loop, config->controller.make, full_scale_n), config);
    }
    if (status == TRIBO_OK)
    {
        made.sample_time_s  = config->sample_time_s;
        made.full_scale_n   = full_scale_n;
        made.usual_force_n  = loop.usual_force_n;
        made.is_own         = config->controller.kind == TRIBO_CONTROLLER_OWN;
        *params             = made;
        params->loop.method = &params->feedforward.method;
        params->loop.guard  = &params->guard;
    }
    return status;
}

#include "report.h"

/// Learns from a sample, and latches that the configured breakaway is far too small, because the learned values fall off
/// again at the next reversal. Returns true if there was a sample.
static bool learn(axis_t *axis)
{
    if (!NAME(feedforward, learn)(&axis->active->loop, axis_memory(axis)))
    {
        return false;
    }
    if (is_far_below(axis))
    {
        axis->is_far_below = 1;
    }
    return true;
}

static tribo_status_t start(axis_t *axis, const tribo_axis_f32_config_t *config, float full_scale_n)
{
    const tribo_status_t status = axis != NULL ? prepare(&axis->params, config, full_scale_n) : TRIBO_ERR_NULL;
    if (status == TRIBO_OK)
    {
        axis->active       = &axis->params;
        axis->ran          = NULL;
        axis->OF(excess)   = 0;
        axis->bad_inputs   = 0;
        axis->is_far_below = 0;
        axis->is_miscalled = 0;
        axis->is_half_done = 0;
        NAME(guard, reset)(&axis->guard);
        NAME(controller, reset)(&axis->controller);
        NAME(feedforward, reset)(&axis->feedforward);
        tribo_learner_check(&axis->params.feedforward.learning, &axis->feedforward.learner);
    }
    return status;
}

/// The first half of a tick, which loop/begin.h does for any method and guard: takes over new params, and calls the
/// feed-forward and the guard. Returns the controller's error.
static force_t begin(axis_t *axis, force_t r, force_t y, loop_functions_t *functions)
{
    const loop_params_t *const params = &axis->active->loop;
    const loop_tick_t *const   tick   = &axis->feedforward.tick;
    const bool                 good   = !loop_input_is_bad(params, r, y);
    if (!good)
    {
        count_one(&axis->bad_inputs);
    }
    NAME(feedforward, method)(functions);
    if (axis->ran != axis->active && axis->ran != NULL)
    {
        // With the error of the last tick, which is 0 if no tick has been good.
        const loop_controller_t *const from = &axis->ran->loop.controller;
        NAME(biquad, change)(&from->cascade, &params->controller.cascade, &axis->controller.cascade, tick->OF(e), 0);
        functions->enter(axis_memory(axis), tick->OF(term), false);
    }
    axis->ran       = axis->active;
    const force_t e = functions->error(params, axis_memory(axis), r, y, axis->guard.fade);
    (void)NAME(guard, step)(&axis->active->guard, &axis->guard, r, y, tick->OF(friction), good);
    return e;
}

force_t NAME(axis, step)(axis_t *axis, force_t r, force_t y)
{
    if (axis->active == NULL)
    {
        return 0;
    }
    axis->is_miscalled |= axis->active->is_own;
    loop_functions_t functions;
    loop_signals_t   unseen;
    const force_t    e = begin(axis, r, y, &functions);
    const force_t    u =
        loop_method_step(&axis->active->loop, &axis->controller, &functions, axis_memory(axis), 0, e, &unseen);
    LEARN_AT_ONCE(axis);
    return u;
}

force_t NAME(axis, error)(axis_t *axis, force_t r, force_t y)
{
    if (axis->active == NULL)
    {
        return 0;
    }
    axis->is_miscalled |= axis->active->is_own == 0u;
    axis->is_half_done = 1;
    loop_functions_t functions;
    return begin(axis, r, y, &functions);
}

force_t NAME(axis, command)(axis_t *axis, force_t v)
{
    if (axis->active == NULL)
    {
        return 0;
    }
    axis->is_miscalled |= axis->is_half_done == 0u;
    axis->is_half_done = 0;
    loop_functions_t functions;
    NAME(feedforward, method)(&functions);
    const force_t u = loop_method_command(&axis->active->loop,
                                          &axis->controller,
                                          &axis->bad_inputs,
                                          &functions,
                                          axis_memory(axis),
                                          v,
                                          &axis->OF(excess));
    LEARN_AT_ONCE(axis);
    return u;
}

force_t NAME(axis, excess)(const axis_t *axis)
{
    return axis->OF(excess);
}

void NAME(axis, rest)(axis_t *axis)
{
    NAME(biquad, reset)(&axis->controller.cascade); // the count of limited ticks stays
    axis->ran                    = NULL;
    axis->OF(excess)             = 0;
    axis->guard.running          = 0;
    axis->feedforward.mode       = TRIBO_FEEDFORWARD_RESTART;
    axis->feedforward.tick.has_e = false;
}

void NAME(axis, restore)(axis_t *axis)
{
    NAME(guard, restore)(&axis->guard);
    NAME(feedforward, restore)(&axis->feedforward);
    axis->is_far_below = 0;
    axis->is_miscalled = 0;
}

/// Copies bytes, because a struct assignment may leave out those between members.
static void copy_bytes(void *to, const void *from, size_t size)
{
    unsigned char *const       target = (unsigned char *)to;
    const unsigned char *const source = (const unsigned char *)from;
    for (size_t i = 0; i < size; i++)
    {
        target[i] = source[i];
    }
}

tribo_status_t NAME(axis, change)(axis_t *axis, const axis_params_t *next)
{
    if (axis == NULL || next == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (axis->active == NULL || next->loop.method == NULL || next == axis->active)
    {
        return TRIBO_ERR_AXIS_ORDER;
    }
    if (next->sample_time_s != axis->active->sample_time_s)
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    if (next->full_scale_n != axis->active->full_scale_n)
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    if (next->feedforward.learning.rig != axis->active->feedforward.learning.rig)
    {
        axis->is_far_below = 0; // the learner forgets
    }
    tribo_learner_check(&next->feedforward.learning, &axis->feedforward.learner);
    axis->active = next;
    return TRIBO_OK;
}

/// CRC-32 (IEEE 802.3) of all that is before the checksum.
static uint32_t checksum_of(const axis_blob_t *blob)
{
    const unsigned char *const at  = (const unsigned char *)blob;
    uint32_t                   crc = UINT32_MAX;
    for (size_t i = 0; i < offsetof(axis_blob_t, checksum); i++)
    {
        crc ^= at[i];
        for (uint32_t bit = 0; bit < 8u; bit++)
        {
            crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
        }
    }
    return ~crc;
}

void NAME(axis, export)(const axis_t *axis, axis_blob_t *blob)
{
    *blob = (axis_blob_t){.version = BLOB_VERSION};
    copy_bytes(blob->learned, &axis->feedforward.learner, sizeof blob->learned);
    blob->checksum = checksum_of(blob);
}

tribo_status_t NAME(axis, import)(axis_t *axis, const axis_blob_t *blob)
{
    if (axis == NULL || blob == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (axis->active == NULL)
    {
        return TRIBO_ERR_AXIS_ORDER;
    }
    if (blob->version != BLOB_VERSION)
    {
        return TRIBO_ERR_BLOB_VERSION;
    }
    if (blob->checksum != checksum_of(blob))
    {
        return TRIBO_ERR_BLOB_CHECKSUM;
    }
    const uint32_t rig = blob->learned[offsetof(tribo_feedforward_learner_t, rig) / sizeof(uint32_t)];
    if (rig != axis->active->feedforward.learning.rig)
    {
        return TRIBO_ERR_BLOB_RIG;
    }
    // The tick takes new weights from the next sample on, and b absorbs what they change: u does not jump.
    copy_bytes(&axis->feedforward.learner, blob->learned, sizeof blob->learned);
    NAME(feedforward, restore)(&axis->feedforward);
    axis->is_far_below = 0;
    return TRIBO_OK;
}
