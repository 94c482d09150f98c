// The Q31 loop as the contract suite sees it: physical units in double, at a full scale of 2 N or what the build says.

#ifndef TESTS_CONTRACT_ARITH_Q31_H
#define TESTS_CONTRACT_ARITH_Q31_H

#include "feedforward_q31.h"
#include "seen.h"
#include "tribo/compensator_lugre_q31.h"
#include "tribo/force_loop_feedforward_q31.h"
#include "tribo/force_loop_guard_q31.h"
#include "tribo/force_loop_lugre_q31.h"
#include "tribo/quantize_q31.h"

#include <math.h>
#include <stddef.h>

#ifndef FULL_SCALE_N
#define FULL_SCALE_N 2.0
#endif
#define GOLDEN_FRICTION_TOLERANCE_N    5e-7
#define GOLDEN_COMPENSATOR_TOLERANCE_N 2e-6
#define CONTROLLER_TOLERANCE_N         2e-6
#define RIPPLE_TOLERANCE_N             1e-7   // of v, 20 mN at half the sample rate for a minute
#define CHANGE_TOLERANCE_N             1e-7   // of u in the tick that changes params
#define FRICTION_CURVE_ERROR           9.1e-7 // of f
#define NET_FORCE_SATURATES            true   // at full scale
#define ROUNDING                       1e-7   // of a force of 1 N: params come from single precision

typedef struct
{
    tribo_friction_q31_params_t params;
    tribo_friction_q31_state_t  state;
    tribo_breakaway_point_q31_t table[TRIBO_BREAKAWAY_POINTS_MAX];
    double                      sample_time_s;
} friction_t;

typedef struct
{
    tribo_arm_q31_params_t params;
    tribo_arm_q31_state_t  state;
} arm_t;

typedef struct
{
    tribo_controller_q31_params_t params;
    tribo_controller_q31_state_t  state;
} controller_t;

typedef struct
{
    tribo_compensator_q31_params_t params;
    tribo_compensator_q31_state_t  state;
    tribo_breakaway_point_q31_t    table[TRIBO_BREAKAWAY_POINTS_MAX];
    double                         sample_time_s;
} compensator_t;

typedef struct
{
    tribo_force_loop_q31_params_t  params;
    tribo_force_loop_q31_state_t   state;
    tribo_feedforward_q31_params_t feedforward; // not to be copied: params and state point to these
    tribo_feedforward_q31_memory_t memory;
    tribo_lugre_q31_params_t       lugre;
    tribo_breakaway_point_q31_t    table[TRIBO_BREAKAWAY_POINTS_MAX];
    double                         sample_time_s;
} loop_t;

/// To Q31 as a drive would do it: a force beyond full scale shows as full scale.
static inline int32_t to_q31(double force_n)
{
    const double x = round(force_n / FULL_SCALE_N * 2147483648.0);
    return (int32_t)fmin(2147483647.0, fmax(-2147483647.0, x));
}

static inline double from_q31(int32_t x)
{
    return x / 2147483648.0 * FULL_SCALE_N;
}

static inline friction_seen_t friction_seen(const tribo_friction_q31_signals_t *s, double sample_time_s)
{
    return (friction_seen_t){.n  = from_q31(s->n),
                             .L  = from_q31(s->L),
                             .v  = from_q31(s->rise) / sample_time_s,
                             .f  = from_q31(s->f),
                             .q1 = (s->relays & TRIBO_RELAY_Q1) != 0u,
                             .q2 = (s->relays & TRIBO_RELAY_Q2) != 0u,
                             .q  = (s->relays & TRIBO_RELAY_Q) != 0u};
}

static inline compensator_seen_t compensator_seen(const tribo_compensator_q31_signals_t *s, double sample_time_s)
{
    return (compensator_seen_t){.F = from_q31(s->force), .friction = friction_seen(&s->friction, sample_time_s)};
}

static inline void friction_reset(friction_t *x)
{
    tribo_friction_q31_reset(&x->state);
}

/// At rest but for the relays' outputs `armed` and net force n of the tick before.
static inline void friction_start(friction_t *x, uint8_t armed, double n)
{
    friction_reset(x);
    x->state.relay.latch.held = armed;
    x->state.n                = to_q31(n);
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
    return tribo_friction_q31_init(&x->params, x->table, config, (float)sample_time_s, (float)FULL_SCALE_N);
}

static inline friction_seen_t friction_step(friction_t *x, double u, double F)
{
    tribo_friction_q31_signals_t signals;
    (void)tribo_friction_q31_step(&x->params, &x->state, to_q31(u), to_q31(F), &signals);
    return friction_seen(&signals, x->sample_time_s);
}

static inline tribo_status_t arm_init(arm_t *x, const tribo_arm_f32_config_t *config, double sample_time_s)
{
    tribo_arm_q31_reset(&x->state);
    return tribo_arm_q31_init(&x->params, config, (float)sample_time_s);
}

static inline double arm_force(const arm_t *x)
{
    return from_q31(tribo_arm_q31_force(&x->state));
}

static inline double arm_step(arm_t *x, double drive)
{
    return from_q31(tribo_arm_q31_step(&x->params, &x->state, to_q31(drive)));
}

static inline void controller_reset(controller_t *x)
{
    tribo_controller_q31_reset(&x->state);
}

static inline tribo_status_t controller_init(controller_t *x, const tribo_controller_f32_config_t *config)
{
    controller_reset(x);
    return tribo_controller_q31_init(&x->params, config, (float)FULL_SCALE_N, NULL);
}

static inline controller_seen_t controller_step(controller_t *x, double e, double feedforward)
{
    tribo_controller_q31_signals_t signals;
    const int32_t u = tribo_controller_q31_step(&x->params, &x->state, to_q31(e), to_q31(feedforward), &signals);
    return (controller_seen_t){.v = from_q31(signals.v), .u = from_q31(u), .limited = signals.limited};
}

/// Takes `x` over to the params of `to`.
static inline void controller_change(controller_t *x, const controller_t *to, double e, double offset)
{
    tribo_controller_q31_change(&x->params, &to->params, &x->state, to_q31(e), to_q31(offset));
    x->params = to->params;
}

/// State w1 of section i, in N.
static inline double controller_w1(const controller_t *x, uint32_t i)
{
    return ldexp((double)x->state.cascade.section[i].w1, x->params.cascade.section[i].scale - 59) * FULL_SCALE_N;
}

static inline void compensator_reset(compensator_t *x)
{
    tribo_compensator_q31_reset(&x->state);
}

static inline tribo_status_t compensator_init(compensator_t                        *x,
                                              const tribo_compensator_f32_config_t *config,
                                              double                                sample_time_s)
{
    compensator_reset(x);
    x->sample_time_s = sample_time_s;
    return tribo_compensator_q31_init(&x->params, x->table, config, (float)sample_time_s, (float)FULL_SCALE_N);
}

static inline compensator_seen_t compensator_step(compensator_t *x, double u)
{
    tribo_compensator_q31_signals_t signals;
    (void)tribo_compensator_q31_step(&x->params, &x->state, to_q31(u), &signals);
    return compensator_seen(&signals, x->sample_time_s);
}

/// The limits of u in the params.
static inline void *loop_u_min(loop_t *x)
{
    return &x->params.controller.u_min;
}

static inline void *loop_u_max(loop_t *x)
{
    return &x->params.controller.u_max;
}

static inline void loop_reset(loop_t *x)
{
    tribo_force_loop_q31_reset(&x->state);
}

static inline tribo_status_t loop_init(loop_t *x, const tribo_force_loop_f32_config_t *config)
{
    loop_reset(x);
    x->sample_time_s = (double)config->sample_time_s;
    return tribo_force_loop_q31_init(&x->params, x->table, config, (float)FULL_SCALE_N, NULL);
}

/// At rest, what was learned kept.
static inline void loop_restart_with_memory(loop_t *x)
{
    loop_reset(x);
    tribo_force_loop_feedforward_q31_attach(&x->state, &x->memory);
}

/// A loop of which nothing is learned, with the feed-forward, or with null the paper's method and memory for a feed-forward.
static inline tribo_status_t loop_init_feedforward(loop_t                               *x,
                                                   const tribo_force_loop_f32_config_t  *config,
                                                   const tribo_feedforward_f32_config_t *feedforward)
{
    const tribo_feedforward_f32_config_t standard = tribo_feedforward_f32_default();
    const tribo_status_t                 status   = tribo_force_loop_feedforward_q31_init(&x->params,
                                                                        x->table,
                                                                        &x->feedforward,
                                                                        config,
                                                                        feedforward != NULL ? feedforward : &standard,
                                                                        (float)FULL_SCALE_N,
                                                                        NULL);
    x->sample_time_s                              = (double)config->sample_time_s;
    tribo_feedforward_q31_reset(&x->feedforward, &x->memory.state);
    loop_restart_with_memory(x);
    if (status == TRIBO_OK && feedforward == NULL)
    {
        return tribo_force_loop_q31_init(&x->params, x->table, config, (float)FULL_SCALE_N, NULL);
    }
    return status;
}

/// A loop with LuGre, and memory for a feed-forward.
static inline tribo_status_t loop_init_lugre(loop_t                              *x,
                                             const tribo_force_loop_f32_config_t *config,
                                             const tribo_lugre_f32_config_t      *lugre)
{
    const tribo_status_t status = loop_init_feedforward(x, config, NULL);
    return status != TRIBO_OK ? status
                              : tribo_force_loop_lugre_q31_init(&x->params,
                                                                x->table,
                                                                &x->lugre,
                                                                config,
                                                                lugre,
                                                                (float)FULL_SCALE_N,
                                                                NULL);
}

/// Loop `x` as it is, with a memory of its own.
static inline void loop_copy(loop_t *to, const loop_t *x)
{
    *to                    = *x;
    to->params.feedforward = &to->feedforward;
    to->params.lugre       = &to->lugre;
    to->state.memory       = x->state.memory != NULL ? &to->memory : NULL;
    to->state.memory_seal  = ~(uintptr_t)to->state.memory;
}

/// A tick of loop `x` under the params of loop `by`, which may be another.
static inline loop_seen_t loop_step_by(loop_t *x, const loop_t *by, double r, double y)
{
    tribo_force_loop_q31_signals_t signals;
    const int32_t u = tribo_force_loop_q31_step(&by->params, &x->state, to_q31(r), to_q31(y), &signals);
    return (loop_seen_t){.e           = from_q31(signals.e),
                         .feedforward = from_q31(signals.feedforward),
                         .v           = from_q31(signals.controller.v),
                         .u           = from_q31(u),
                         .limited     = signals.controller.limited,
                         .compensator = compensator_seen(&signals.compensator, x->sample_time_s)};
}

/// Likewise without signals: u alone.
static inline double loop_step_unseen_by(loop_t *x, const loop_t *by, double r, double y)
{
    return from_q31(tribo_force_loop_q31_step(&by->params, &x->state, to_q31(r), to_q31(y), NULL));
}

static inline loop_seen_t loop_step(loop_t *x, double r, double y)
{
    return loop_step_by(x, x, r, y);
}

/// The guard beside a loop.
typedef struct
{
    tribo_guard_q31_params_t params;
    tribo_guard_q31_state_t  state;
} guard_t;

static inline tribo_status_t guard_init(guard_t *x, double sample_time_s)
{
    const tribo_guard_f32_config_t standard = tribo_guard_f32_default();
    tribo_guard_q31_reset(&x->state);
    return tribo_guard_q31_init(&x->params, &standard, (float)sample_time_s, (float)FULL_SCALE_N);
}

static inline void guard_restore(guard_t *x)
{
    tribo_guard_q31_restore(&x->state);
}

static inline double guard_share(const guard_t *x)
{
    return x->state.share == UINT32_MAX ? 1.0 : (double)x->state.share / 4294967296.0;
}

/// One tick of a loop with a guard; returns u.
static inline double loop_step_guarded(loop_t *x, guard_t *guard, double r, double y)
{
    tribo_force_loop_q31_signals_t signals;
    const int32_t                  r_q31 = to_q31(r);
    const int32_t                  y_q31 = to_q31(y);
    const int32_t                  u     = tribo_force_loop_q31_step(&x->params, &x->state, r_q31, y_q31, &signals);
    tribo_force_loop_guard_q31_watch(&guard->params, &guard->state, &x->params, &x->state, r_q31, y_q31, &signals);
    return from_q31(u);
}

/// Of both directions on both sides of 0, in N.
static inline double loop_learned_travel(const loop_t *x)
{
    double travel = 0.0;
    for (int d = 0; d < 2; d++)
    {
        travel += (double)x->memory.state.learning.travel[d] + (double)x->memory.state.learning.across.travel[d];
    }
    return travel / 536870912.0 * FULL_SCALE_N;
}

static inline uint32_t loop_bad_inputs(const loop_t *x)
{
    return x->state.bad_inputs;
}

/// Values that were clamped.
static inline uint32_t loop_saturations(const loop_t *x)
{
    return x->state.saturated + x->state.controller.cascade.saturated + x->state.compensator.friction.paper.saturated +
           x->state.compensator.arm.saturated;
}

static inline uint32_t loop_limited_ticks(const loop_t *x)
{
    return x->state.controller.limited_ticks;
}

typedef struct
{
    tribo_controller_q31_state_t  controller;
    tribo_compensator_q31_state_t compensator;
} parts_t;

static inline void parts_reset(parts_t *x)
{
    tribo_controller_q31_reset(&x->controller);
    tribo_compensator_q31_reset(&x->compensator);
}

/// Controller and compensator, each on its own, under the params of loop `by`.
static inline loop_seen_t parts_step(parts_t *x, const loop_t *by, double e, double feedforward)
{
    tribo_controller_q31_signals_t  signals;
    tribo_compensator_q31_signals_t estimate;
    const int32_t                   u =
        tribo_controller_q31_step(&by->params.controller, &x->controller, to_q31(e), to_q31(feedforward), &signals);
    (void)tribo_compensator_q31_step(&by->params.compensator, &x->compensator, u, &estimate);
    return (loop_seen_t){.e           = e,
                         .feedforward = feedforward,
                         .v           = from_q31(signals.v),
                         .u           = from_q31(u),
                         .limited     = signals.limited,
                         .compensator = compensator_seen(&estimate, by->sample_time_s)};
}

static inline void parts_reset_lugre(parts_t *x)
{
    tribo_controller_q31_reset(&x->controller);
    tribo_compensator_lugre_q31_reset(&x->compensator);
}

/// Likewise of a loop with LuGre.
static inline loop_seen_t parts_step_lugre(parts_t *x, const loop_t *by, double e, double feedforward)
{
    tribo_controller_q31_signals_t  signals;
    tribo_compensator_q31_signals_t estimate;
    const int32_t                   u =
        tribo_controller_q31_step(&by->params.controller, &x->controller, to_q31(e), to_q31(feedforward), &signals);
    (void)tribo_compensator_lugre_q31_step(&by->params.compensator, &by->lugre, &x->compensator, u, &estimate);
    return (loop_seen_t){.e           = e,
                         .feedforward = feedforward,
                         .v           = from_q31(signals.v),
                         .u           = from_q31(u),
                         .limited     = signals.limited,
                         .compensator = compensator_seen(&estimate, by->sample_time_s)};
}

#endif
