// The loop as the contract suite sees it, in the arithmetic of arith_f32.h or arith_q31.h: physical units in double, in Q31 at a
// full scale of 2 N or what the build says.

#ifndef TESTS_CONTRACT_ARITH_H
#define TESTS_CONTRACT_ARITH_H

#include "../support/init_parts.h"
#include "seen.h"
#if TRIBO_IS_Q31
#include "../support/cascade_q31.h"
#include "arm_q31.h"
#else
#include "../support/cascade_f32.h"
#include "arm_f32.h"
#endif

#include <math.h>
#include <stddef.h>

#ifndef FULL_SCALE_N
#define FULL_SCALE_N 2.0
#endif
#define GOLDEN_FRICTION_TOLERANCE_N    TRIBO_EITHER(2e-7, 5e-7) // asked in f32: 2e-5
#define GOLDEN_COMPENSATOR_TOLERANCE_N TRIBO_EITHER(5e-6, 2e-6) // asked in f32: 5e-5
#define CONTROLLER_TOLERANCE_N         TRIBO_EITHER(5e-5, 2e-6)
#define RIPPLE_TOLERANCE_N             TRIBO_EITHER(6e-6, 1e-7)     // of v, 20 mN at half the sample rate for a minute
#define CHANGE_TOLERANCE_N             TRIBO_EITHER(2e-6, 1e-7)     // of u in the tick that changes params
#define FRICTION_CURVE_ERROR           TRIBO_EITHER(1.2e-6, 9.1e-7) // of f
#define NET_FORCE_SATURATES            TRIBO_IS_Q31                 // at full scale
#define ROUNDING                       1e-7 // of a force of 1 N: params come from single precision

/// Converts as a drive does: a force beyond full scale shows as full scale.
static inline tribo_force_t to_force(double force_n)
{
    return tribo_force_of_n(force_n, FULL_SCALE_N);
}

static inline double from_force(tribo_force_t x)
{
    return tribo_force_n(x, FULL_SCALE_N);
}

typedef struct
{
    TRIBO(friction, params_t) params;
    TRIBO(friction, state_t) state;
    tribo_point_t table[TRIBO_BREAKAWAY_POINTS_MAX];
    double        sample_time_s;
} friction_t;

typedef struct
{
    TRIBO(controller, params_t) params;
    TRIBO(controller, state_t) state;
} controller_t;

typedef struct
{
    TRIBO(compensator, params_t) params;
    TRIBO(compensator, state_t) state;
    tribo_point_t table[TRIBO_BREAKAWAY_POINTS_MAX];
    double        sample_time_s;
} compensator_t;

typedef struct
{
    TRIBO(force_loop, params_t) params;
    TRIBO(force_loop, state_t) state;
    TRIBO(feedforward, params_t) feedforward; // not to be copied: params and state point to these
    TRIBO(feedforward, memory_t) memory;
    tribo_point_t table[TRIBO_BREAKAWAY_POINTS_MAX];
    double        sample_time_s;
} loop_t;

static inline friction_seen_t friction_seen(const TRIBO(friction, signals_t) * s, double sample_time_s)
{
    return (friction_seen_t){
        .n  = from_force(s->TRIBO_N(n)),
        .L  = from_force(s->TRIBO_N(L)),
        .v  = TRIBO_EITHER(((void)sample_time_s, (double)s->v_n_per_s), from_force(s->rise) / sample_time_s),
        .f  = from_force(s->TRIBO_N(f)),
        .q1 = (s->relays & TRIBO_RELAY_Q1) != 0u,
        .q2 = (s->relays & TRIBO_RELAY_Q2) != 0u,
        .q  = (s->relays & TRIBO_RELAY_Q) != 0u};
}

static inline compensator_seen_t compensator_seen(const TRIBO(compensator, signals_t) * s, double sample_time_s)
{
    return (compensator_seen_t){.F        = from_force(s->TRIBO_N(force)),
                                .friction = friction_seen(&s->friction, sample_time_s)};
}

static inline void friction_reset(friction_t *x)
{
    TRIBO(friction, reset)(&x->state);
}

/// At rest but for the relays' outputs `armed` and net force n of the tick before.
static inline void friction_start(friction_t *x, uint8_t armed, double n)
{
    friction_reset(x);
    x->state.relay.latch.held = armed;
    x->state.TRIBO_N(n)       = to_force(n);
}

static inline uint32_t friction_pulse_width(const friction_t *x)
{
    return x->params.pulse_width;
}

static inline tribo_status_t friction_init(friction_t                        *x,
                                           const tribo_friction_f32_config_t *config,
                                           double                             sample_time_s)
{
    friction_reset(x);
    x->sample_time_s = sample_time_s;
    return TRIBO_EITHER(TRIBO(friction, init)(&x->params, config, (float)sample_time_s),
                        TRIBO(friction, init)(&x->params, x->table, config, (float)sample_time_s, (float)FULL_SCALE_N));
}

static inline friction_seen_t friction_step(friction_t *x, double u, double F)
{
    TRIBO(friction, signals_t) signals;
    (void)TRIBO(friction, step)(&x->params, &x->state, to_force(u), to_force(F), &signals);
    return friction_seen(&signals, x->sample_time_s);
}

static inline void controller_reset(controller_t *x)
{
    TRIBO(controller, reset)(&x->state);
}

static inline tribo_status_t controller_init(controller_t *x, const tribo_controller_f32_config_t *config)
{
    controller_reset(x);
    return TRIBO_EITHER(TRIBO(controller, init)(&x->params, config),
                        TRIBO(controller, init)(&x->params, config, (float)FULL_SCALE_N, NULL));
}

static inline controller_seen_t controller_step(controller_t *x, double e, double feedforward)
{
    TRIBO(controller, signals_t) signals;
    const tribo_force_t u =
        TRIBO_PART(controller, step)(&x->params, &x->state, to_force(e), to_force(feedforward), &signals);
    return (controller_seen_t){.v = from_force(signals.TRIBO_N(v)), .u = from_force(u), .limited = signals.limited};
}

/// Takes `x` over to the params of `to`.
/// c/D of the anti-windup.
static inline double controller_anti_windup(const controller_t *x)
{
#if TRIBO_IS_Q31
    const int scale = (int)x->params.cascade.input_scale - (int)x->params.cascade.output_scale;
    return ldexp(x->params.anti_windup, x->params.anti_windup_shift - 32 + scale);
#else
    return (double)x->params.anti_windup;
#endif
}

static inline void controller_change(controller_t *x, const controller_t *to, double e, double offset)
{
    TRIBO(biquad, change)(&x->params.cascade, &to->params.cascade, &x->state.cascade, to_force(e), to_force(offset));
    x->params = to->params;
}

/// State w1 of section i, in N.
static inline double controller_w1(const controller_t *x, uint32_t i)
{
    return TRIBO_EITHER((double)x->state.cascade.section[i].w1,
                        ldexp((double)x->state.cascade.section[i].w1, x->params.cascade.section[i].scale - 59) *
                            FULL_SCALE_N);
}

static inline void compensator_reset(compensator_t *x)
{
    TRIBO(compensator, reset)(&x->state);
}

static inline tribo_status_t compensator_init(compensator_t                        *x,
                                              const tribo_compensator_f32_config_t *config,
                                              double                                sample_time_s)
{
    compensator_reset(x);
    x->sample_time_s = sample_time_s;
    return TRIBO_EITHER(
        TRIBO(compensator, init)(&x->params, config, (float)sample_time_s),
        TRIBO(compensator, init)(&x->params, x->table, config, (float)sample_time_s, (float)FULL_SCALE_N));
}

static inline compensator_seen_t compensator_step(compensator_t *x, double u)
{
    TRIBO(compensator, signals_t) signals;
    (void)TRIBO(compensator, step)(&x->params, &x->state, to_force(u), &signals);
    return compensator_seen(&signals, x->sample_time_s);
}

/// The limits of u in the params.
static inline void *loop_u_min(loop_t *x)
{
    return &x->params.controller.TRIBO_N(u_min);
}

static inline void *loop_u_max(loop_t *x)
{
    return &x->params.controller.TRIBO_N(u_max);
}

/// At rest, without a memory.
static inline void loop_reset(loop_t *x)
{
    x->state.memory = NULL;
    (void)TRIBO(force_loop, start)(&x->state, &x->params, false);
}

static inline tribo_status_t loop_init(loop_t *x, const tribo_force_loop_f32_config_t *config)
{
    x->sample_time_s            = (double)config->sample_time_s;
    const tribo_status_t status = tribo_init_loop(&x->params, x->table, config, (float)FULL_SCALE_N);
    loop_reset(x);
    return status;
}

/// At rest, what was learned kept.
static inline void loop_restart_with_memory(loop_t *x)
{
    x->state.memory = &x->memory.state.tick;
    (void)TRIBO(force_loop, start)(&x->state, &x->params, true);
}

/// A loop of which nothing is learned, with the feed-forward, or with null the paper's method and memory for a feed-forward.
static inline tribo_status_t loop_init_feedforward(loop_t                               *x,
                                                   const tribo_force_loop_f32_config_t  *config,
                                                   const tribo_feedforward_f32_config_t *feedforward)
{
    const tribo_feedforward_f32_config_t standard = tribo_feedforward_f32_default();
    const tribo_status_t                 status   = tribo_init_feedforward(&x->params,
                                                         x->table,
                                                         &x->feedforward,
                                                         config,
                                                         feedforward != NULL ? feedforward : &standard,
                                                         (float)FULL_SCALE_N);
    x->sample_time_s                              = (double)config->sample_time_s;
    TRIBO(feedforward, reset)(&x->memory.state);
    loop_restart_with_memory(x);
    if (status == TRIBO_OK && feedforward == NULL)
    {
        return tribo_init_loop(&x->params, x->table, config, (float)FULL_SCALE_N);
    }
    return status;
}

/// Loop `x` as it is, with a memory of its own.
static inline void loop_copy(loop_t *to, const loop_t *x)
{
    *to                   = *x;
    to->params.method     = x->params.method != NULL ? &to->feedforward.method : NULL;
    to->state.memory      = x->state.memory != NULL ? &to->memory.state.tick : NULL;
    to->state.memory_seal = ~(uintptr_t)to->state.memory;
}

/// A tick of loop `x` under the params of loop `by`, which may be another.
static inline loop_seen_t loop_step_by(loop_t *x, const loop_t *by, double r, double y)
{
    TRIBO(force_loop, signals_t) signals;
    const tribo_force_t u = TRIBO(force_loop, step)(&by->params, &x->state, to_force(r), to_force(y), &signals);
    (void)TRIBO(feedforward, learn)(&by->params, &x->memory);
    return (loop_seen_t){.e           = from_force(signals.TRIBO_N(e)),
                         .feedforward = from_force(signals.TRIBO_N(friction_term)),
                         .v           = from_force(signals.controller.TRIBO_N(v)),
                         .u           = from_force(u),
                         .limited     = signals.controller.limited,
                         .compensator = compensator_seen(&signals.compensator, x->sample_time_s)};
}

/// Does the same without signals, and returns u alone.
static inline double loop_step_unseen_by(loop_t *x, const loop_t *by, double r, double y)
{
    const tribo_force_t u = TRIBO(force_loop, step)(&by->params, &x->state, to_force(r), to_force(y), NULL);
    (void)TRIBO(feedforward, learn)(&by->params, &x->memory);
    return from_force(u);
}

static inline loop_seen_t loop_step(loop_t *x, double r, double y)
{
    return loop_step_by(x, x, r, y);
}

/// The guard beside a loop.
typedef struct
{
    TRIBO(guard, params_t) params;
    TRIBO(guard, state_t) state;
} guard_t;

static inline tribo_status_t guard_init(guard_t *x, double sample_time_s)
{
    const tribo_guard_f32_config_t standard = tribo_guard_f32_default();
    TRIBO(guard, reset)(&x->state);
    return tribo_init_guard(&x->params, &standard, (float)sample_time_s, (float)FULL_SCALE_N);
}

static inline void guard_restore(guard_t *x)
{
    TRIBO(guard, restore)(&x->state);
}

/// Returns the part of friction that the guard of a loop lets through.
static inline double loop_share(const loop_t *x)
{
    const double fade = (double)x->state.guard.fade;
    return x->state.guard.fade == TRIBO_ALL ? 1.0 : fade / TRIBO_EITHER(1.0, 4294967296.0);
}

/// Puts `guard` beside loop `x`.
static inline void loop_guard(loop_t *x, guard_t *guard)
{
    x->params.guard = &guard->params;
    x->state.guard  = guard->state;
}

/// One tick of a loop with a guard; returns u.
static inline double loop_step_guarded(loop_t *x, guard_t *guard, double r, double y)
{
    loop_guard(x, guard);
    const double u = loop_step_unseen_by(x, x, r, y);
    guard->state   = x->state.guard;
    return u;
}

/// A force of a feed-forward's state, in N.
static inline double inner_n(tribo_force_t force, double full_scale_n)
{
    (void)full_scale_n;
    return TRIBO_EITHER((double)force, (double)force * full_scale_n / 536870912.0);
}

/// Friction that was fed forward in the last tick, in N.
static inline double loop_fed_friction(const loop_t *x)
{
    return inner_n(x->memory.state.f, FULL_SCALE_N);
}

/// Nothing learned, and nothing remembered of the last tick.
static inline void loop_forget(loop_t *x)
{
    TRIBO(feedforward, reset)(&x->memory.state);
}

static inline void loop_other_functions(TRIBO(force_loop, functions_t) * functions)
{
    TRIBO(feedforward, method)(functions);
}

/// Makes the loop's feed-forward a method of another kind.
static inline void loop_other_method(loop_t *x)
{
    x->feedforward.method.functions = loop_other_functions;
}

static inline void loop_detach_guard(loop_t *x)
{
    x->params.guard = NULL;
}

static inline void loop_detach_memory(loop_t *x)
{
    x->state.memory      = NULL;
    x->state.memory_seal = ~(uintptr_t)NULL;
}

/// In N.
static inline double loop_learned_travel(const loop_t *x)
{
    return (double)x->memory.state.learner.travel_n;
}

static inline uint32_t loop_bad_inputs(const loop_t *x)
{
    return x->state.bad_inputs;
}

/// Values that were clamped.
static inline uint32_t loop_saturations(const loop_t *x)
{
#if TRIBO_IS_Q31
    return x->state.saturated + x->state.controller.cascade.saturated + x->state.compensator.friction.saturated +
           x->state.compensator.arm.saturated;
#else
    (void)x;
    return 0; // none in f32
#endif
}

static inline uint32_t loop_limited_ticks(const loop_t *x)
{
    return x->state.controller.limited_ticks;
}

typedef struct
{
    TRIBO(controller, state_t) controller;
    TRIBO(compensator, state_t) compensator;
} parts_t;

static inline void parts_reset(parts_t *x)
{
    TRIBO(controller, reset)(&x->controller);
    TRIBO(compensator, reset)(&x->compensator);
}

/// Controller and compensator, each on its own, under the params of loop `by`.
static inline loop_seen_t parts_step(parts_t *x, const loop_t *by, double e, double feedforward)
{
    TRIBO(controller, signals_t) signals;
    TRIBO(compensator, signals_t) estimate;
    const tribo_force_t u =
        TRIBO_PART(controller,
                   step)(&by->params.controller, &x->controller, to_force(e), to_force(feedforward), &signals);
    (void)TRIBO(compensator, step)(&by->params.compensator, &x->compensator, u, &estimate);
    return (loop_seen_t){.e           = e,
                         .feedforward = feedforward,
                         .v           = from_force(signals.TRIBO_N(v)),
                         .u           = from_force(u),
                         .limited     = signals.limited,
                         .compensator = compensator_seen(&estimate, by->sample_time_s)};
}

#endif
