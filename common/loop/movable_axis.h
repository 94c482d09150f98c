/// A force axis that may move in memory, for languages and file formats that copy bytes; in Q31 if TRIBO_ARITHMETIC_Q31 is
/// defined. An axis points to itself, to params and to functions, so each call begins with movable_axis_here, which sets
/// these pointers anew.

#ifndef MOVABLE_AXIS_H
#define MOVABLE_AXIS_H

#ifdef TRIBO_ARITHMETIC_Q31
#include "tribo/axis_q31.h"
#define MOVABLE(noun, verb) tribo_##noun##_q31_##verb
typedef int32_t movable_force_t;
#else
#include "tribo/axis_f32.h"
#define MOVABLE(noun, verb) tribo_##noun##_f32_##verb
typedef float movable_force_t;
#endif

typedef MOVABLE(axis, params_t) movable_params_t;

/// An axis with two sets of params, its own and `next`, because the params of the last tick must stay until those of a
/// change have run.
typedef struct
{
    MOVABLE(axis, t) axis;
    movable_params_t next;
    uint8_t          has_next, had_next; ///< 1: `next` is in use, or was in the last tick
} movable_axis_t;

static inline movable_params_t *movable_axis_params(movable_axis_t *own, uint8_t is_next)
{
    return is_next != 0u ? &own->next : &own->axis.params;
}

static inline void movable_axis_point(movable_params_t *params)
{
    params->feedforward.method.functions = MOVABLE(feedforward, method);
    params->guard.step                   = MOVABLE(guard, step);
    params->loop.method                  = &params->feedforward.method;
    params->loop.guard                   = &params->guard;
}

/// Returns the axis at its present address.
static inline MOVABLE(axis, t) * movable_axis_here(movable_axis_t *own)
{
    MOVABLE(axis, t) *const axis = &own->axis;
    movable_axis_point(&axis->params);
    movable_axis_point(&own->next);
    axis->active = movable_axis_params(own, own->has_next);
    axis->ran    = axis->ran != NULL ? movable_axis_params(own, own->had_next) : NULL;
    return axis;
}

/// Does what tribo_axis_f32_init, which has no full scale, or tribo_axis_q31_init does. Call it before any other function.
static inline tribo_status_t movable_axis_init(movable_axis_t                *own,
                                               const tribo_axis_f32_config_t *config,
                                               float                          full_scale_n)
{
#ifdef TRIBO_ARITHMETIC_Q31
    const tribo_status_t status = tribo_axis_q31_init(&own->axis, config, full_scale_n);
#else
    (void)full_scale_n;
    const tribo_status_t status = tribo_axis_f32_init(&own->axis, config);
#endif
    if (status == TRIBO_OK)
    {
        own->next     = own->axis.params;
        own->has_next = 0u;
        own->had_next = 0u;
    }
    return status;
}

/// Does what tribo_axis_f32_prepare and tribo_axis_f32_change do. The full scale stays.
static inline tribo_status_t movable_axis_change(movable_axis_t *own, const tribo_axis_f32_config_t *config)
{
    movable_params_t made;
#ifdef TRIBO_ARITHMETIC_Q31
    tribo_status_t status = tribo_axis_q31_prepare(&made, config, own->axis.params.full_scale_n);
#else
    tribo_status_t status = tribo_axis_f32_prepare(&made, config);
#endif
    if (status == TRIBO_OK)
    {
        status = MOVABLE(axis, change)(movable_axis_here(own), &made);
    }
    if (status == TRIBO_OK)
    {
        own->has_next                            = (uint8_t)(1u - own->had_next);
        *movable_axis_params(own, own->has_next) = made;
    }
    return status;
}

/// Records that the params in use have run. Call it after a tick, or after half of one.
static inline void movable_axis_ran(movable_axis_t *own)
{
    own->had_next = own->has_next;
}

#endif
