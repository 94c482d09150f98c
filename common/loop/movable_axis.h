/// A force axis that may move in memory, for languages and file formats that copy bytes. tribo_axis_f32_t points to itself, to params and to
/// functions, so each call begins with movable_axis_here, which sets these pointers anew.

#ifndef MOVABLE_AXIS_H
#define MOVABLE_AXIS_H

#include "tribo/axis_f32.h"

/// The params of the last tick must stay until those of a change have run, so there are two: the axis' own, and `next`.
typedef struct
{
    tribo_axis_f32_t        axis;
    tribo_axis_f32_params_t next;
    uint8_t                 has_next, had_next; ///< 1: `next` is in use, and was in the last tick
} movable_axis_t;

static inline tribo_axis_f32_params_t *movable_axis_params(movable_axis_t *own, uint8_t is_next)
{
    return is_next != 0u ? &own->next : &own->axis.params;
}

static inline void movable_axis_point(tribo_axis_f32_params_t *params)
{
    params->feedforward.method.functions = tribo_feedforward_f32_method;
    params->guard.step                   = tribo_guard_f32_step;
    params->loop.method                  = &params->feedforward.method;
    params->loop.guard                   = &params->guard;
}

/// The axis, at the address that it has now.
static inline tribo_axis_f32_t *movable_axis_here(movable_axis_t *own)
{
    tribo_axis_f32_t *const axis = &own->axis;
    movable_axis_point(&axis->params);
    movable_axis_point(&own->next);
    axis->active           = movable_axis_params(own, own->has_next);
    axis->loop.active      = axis->loop.active != NULL ? &movable_axis_params(own, own->had_next)->loop : NULL;
    axis->loop.active_seal = ~(uintptr_t)axis->loop.active;
    axis->loop.memory      = &axis->memory.state.tick;
    axis->loop.memory_seal = ~(uintptr_t)axis->loop.memory;
    return axis;
}

/// See tribo_axis_f32_init. Before it nothing else may be called.
static inline tribo_status_t movable_axis_init(movable_axis_t *own, const tribo_axis_f32_config_t *config)
{
    const tribo_status_t status = tribo_axis_f32_init(&own->axis, config);
    if (status == TRIBO_OK)
    {
        own->next     = own->axis.params;
        own->has_next = 0u;
        own->had_next = 0u;
    }
    return status;
}

/// See tribo_axis_f32_prepare and _change.
static inline tribo_status_t movable_axis_change(movable_axis_t *own, const tribo_axis_f32_config_t *config)
{
    tribo_axis_f32_params_t made;
    tribo_status_t          status = tribo_axis_f32_prepare(&made, config);
    if (status == TRIBO_OK)
    {
        status = tribo_axis_f32_change(movable_axis_here(own), &made);
    }
    if (status == TRIBO_OK)
    {
        own->has_next                            = (uint8_t)(1u - own->had_next);
        *movable_axis_params(own, own->has_next) = made;
    }
    return status;
}

/// After a tick, or half of one: the params in use have run.
static inline void movable_axis_ran(movable_axis_t *own)
{
    own->had_next = own->has_next;
}

#endif
