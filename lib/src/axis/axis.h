// A force axis. This text serves both arithmetics and is included by axis_f32.c and axis_q31.c, after the functions
// that differ.

#include "axis_config.h"

#define axis_init    NAME(axis, init)
#define axis_step    NAME(axis, step)
#define axis_error   NAME(axis, error)
#define axis_command NAME(axis, command)
#define axis_excess  NAME(axis, excess)
#define axis_report  NAME(axis, report)
#define axis_restore NAME(axis, restore)
#define axis_change  NAME(axis, change)
#define axis_export  NAME(axis, export)
#define axis_import  NAME(axis, import)

typedef NAME(axis, t) axis_t;
typedef NAME(axis, params_t) axis_params_t;
typedef NAME(axis, blob_t) axis_blob_t;

static tribo_status_t prepare(axis_params_t *params, const tribo_axis_f32_config_t *config, float full_scale_n)
{
    tribo_force_loop_f32_config_t loop;
    axis_params_t                 made;
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_axis_config_expand(&loop, config);
    if (status == TRIBO_OK)
    {
        const tribo_guard_f32_config_t guard = tribo_axis_config_guard(&loop, config);
        loop.method                          = NAME(feedforward, use)(&made.feedforward, &config->feedforward);
        loop.guard                           = NAME(guard, use)(&made.guard, &guard);
        status                               = axis_make_loop(&made.loop, &loop, full_scale_n);
    }
    if (status == TRIBO_OK)
    {
        made.sample_time_s  = config->sample_time_s;
        made.full_scale_n   = full_scale_n;
        made.usual_force_n  = tribo_force_loop_f32_usual_force_n(&loop);
        made.breakaway_n    = tribo_axis_config_breakaway(&loop);
        made.rig            = tribo_axis_config_rig(&loop, config, full_scale_n);
        *params             = made;
        params->loop.method = &params->feedforward.method;
        params->loop.guard  = &params->guard;
    }
    return status;
}

static tribo_status_t start(axis_t *axis, const tribo_axis_f32_config_t *config, float full_scale_n)
{
    const tribo_status_t status = axis != NULL ? prepare(&axis->params, config, full_scale_n) : TRIBO_ERR_NULL;
    if (status == TRIBO_OK)
    {
        axis->active     = &axis->params;
        axis->OF(excess) = 0;
        axis->loop       = (NAME(force_loop, state_t)){.memory = &axis->memory.state.tick};
        (void)NAME(force_loop, start)(&axis->loop, &axis->params.loop, false); // cannot fail: the loop has its memory
    }
    return status;
}

force_t axis_step(axis_t *axis, force_t r, force_t y)
{
    if (axis->active == NULL)
    {
        return 0;
    }
    const force_t u = NAME(force_loop, step)(&axis->active->loop, &axis->loop, r, y, NULL);
    axis_learn_at_once(axis);
    return u;
}

force_t axis_error(axis_t *axis, force_t r, force_t y)
{
    return axis->active != NULL ? NAME(force_loop, error)(&axis->active->loop, &axis->loop, r, y) : 0;
}

force_t axis_command(axis_t *axis, force_t v)
{
    if (axis->active == NULL)
    {
        return 0;
    }
    const force_t u = NAME(force_loop, command)(&axis->active->loop, &axis->loop, v, &axis->OF(excess));
    axis_learn_at_once(axis);
    return u;
}

force_t axis_excess(const axis_t *axis)
{
    return axis->OF(excess);
}

void axis_report(const axis_t *axis, tribo_axis_report_t *report)
{
    *report = (tribo_axis_report_t){.share = 1.0f};
    if (axis->active == NULL)
    {
        return;
    }
    const float                 ratio   = axis->memory.state.learner.ratio;
    tribo_feedforward_learned_t learned = {.L_n = 0.0f};
    for (uint32_t direction = TRIBO_BREAKAWAY_POSITIVE; direction <= TRIBO_BREAKAWAY_NEGATIVE; direction++)
    {
        learned = axis_learned(axis, direction);
        tribo_axis_report_direction(report, direction, &learned, axis->active->breakaway_n);
    }
    report->times_less    = ratio > 0.0f ? 1.0f / ratio : 0.0f;
    report->share         = axis_share(axis);
    report->bad_inputs    = axis->loop.bad_inputs;
    report->limited_ticks = axis->loop.controller.limited_ticks;
    report->forgotten     = learned.forgotten;
    report->late          = learned.late;
    tribo_axis_report_warn(report, &learned, axis->loop.guard.cause);
}

void axis_restore(axis_t *axis)
{
    NAME(guard, restore)(&axis->loop.guard);
    NAME(feedforward, restore)(&axis->memory.state);
}

tribo_status_t axis_change(axis_t *axis, const axis_params_t *next)
{
    if (axis == NULL || next == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (axis->active == NULL || next->loop.method == NULL)
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
    axis->active = next;
    return TRIBO_OK;
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

static uint32_t checksum_of(const axis_blob_t *blob)
{
    return tribo_axis_checksum(blob, offsetof(axis_blob_t, checksum));
}

void axis_export(const axis_t *axis, axis_blob_t *blob)
{
    *blob     = (axis_blob_t){.version = BLOB_VERSION};
    blob->rig = axis->active != NULL ? axis->active->rig : 0u;
    copy_bytes(blob->learned, &axis->memory.state.learner, sizeof blob->learned);
    blob->checksum = checksum_of(blob);
}

tribo_status_t axis_import(axis_t *axis, const axis_blob_t *blob)
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
    if (blob->rig != axis->active->rig)
    {
        return TRIBO_ERR_BLOB_RIG;
    }
    const bool    was_running = axis->memory.state.mode != TRIBO_FEEDFORWARD_RESTART;
    const force_t term        = axis->memory.state.tick.OF(term);
    NAME(feedforward, reset)(&axis->memory.state);
    copy_bytes(&axis->memory.state.learner, blob->learned, sizeof blob->learned);
    if (was_running) // b takes over, so that u continues with the imported weights
    {
        NAME(force_loop, functions_t) functions;
        NAME(feedforward, method)(&functions);
        functions.enter(&axis->memory, term, true);
    }
    return TRIBO_OK;
}
