// The Q31 feed-forward as the contract suite sees it: physical units in double, at a full scale of 2 N or what the build says.

#ifndef TESTS_CONTRACT_FEEDFORWARD_ARITH_Q31_H
#define TESTS_CONTRACT_FEEDFORWARD_ARITH_Q31_H

#include "controller/biquad_f32.h"
#include "controller/biquad_q31.h"
#include "controller/controller_f32.h"
#include "controller/controller_q31.h"
#include "feedforward/breakaway_learning_q31.h"
#include "feedforward/feedforward_q31.h"
#include "feedforward/friction_observer_q31.h"
#include "feedforward/hold_q31.h"
#include "feedforward/reference_model_q31.h"
#include "feedforward_seen.h"
#include "guard/guard_q31.h"
#include "paper/arm_q31.h"
#include "paper/lugre_f32.h"
#include "paper/lugre_q31.h"
#include "tribo/controller_f32.h"
#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_q31.h"

#include <math.h>
#include <stddef.h>

#ifndef FULL_SCALE_N
#define FULL_SCALE_N 2.0
#endif
#define GOLDEN_FEEDFORWARD_TOLERANCE_N 1e-5 // of e, lin, f, b, z, L
#define GOLDEN_LEARNING_TOLERANCE      2e-4 // of what is learned, in prior spreads

typedef struct
{
    tribo_feedforward_q31_params_t  params;
    tribo_friction_q31_params_t     friction;
    tribo_breakaway_point_q31_t     table[TRIBO_BREAKAWAY_POINTS_MAX];
    tribo_feedforward_q31_state_t   state;
    tribo_feedforward_q31_signals_t signals;
    double                          full_scale;
} feedforward_t;

/// To Q31 as a drive would do it: a force beyond full scale, or no number at all, shows as beyond it.
static inline int32_t feedforward_to_q31(const feedforward_t *x, double force_n)
{
    const double q = round(force_n / x->full_scale * 2147483648.0);
    return isnan(q) ? INT32_MIN : (int32_t)fmin(2147483647.0, fmax(-2147483647.0, q));
}

static inline double feedforward_from_q31(const feedforward_t *x, int32_t q)
{
    return q / 2147483648.0 * x->full_scale;
}

/// From the units inside, Q29.
static inline double feedforward_from_units(const feedforward_t *x, int64_t units)
{
    return (double)units / 536870912.0 * x->full_scale;
}

/// With all forces of a config, and full scale, times `scale`.
static inline tribo_status_t feedforward_init_scaled(feedforward_t                        *x,
                                                     const tribo_feedforward_f32_config_t *config,
                                                     const tribo_compensator_f32_config_t *model,
                                                     double                                input_max,
                                                     double                                h,
                                                     double                                scale)
{
    x->full_scale         = scale * FULL_SCALE_N;
    const float    FS     = (float)x->full_scale;
    tribo_status_t status = tribo_friction_q31_init(&x->friction, x->table, &model->friction, (float)h, FS);
    if (status == TRIBO_OK)
    {
        status = tribo_feedforward_q31_init(&x->params, config, model, (float)input_max, (float)h, FS);
    }
    if (status == TRIBO_OK)
    {
        tribo_feedforward_q31_reset(&x->params, &x->state);
    }
    return status;
}

static inline void feedforward_restart(feedforward_t *x)
{
    tribo_feedforward_q31_restart(&x->state);
}

static inline void feedforward_reset(feedforward_t *x)
{
    tribo_feedforward_q31_reset(&x->params, &x->state);
}

static inline void feedforward_enter(feedforward_t *x, double added)
{
    tribo_feedforward_q31_enter(&x->state, feedforward_to_q31(x, added));
}

/// Keeps this tick from being learned from.
static inline void feedforward_do_not_learn(feedforward_t *x)
{
    x->signals.y_good = false;
}

static inline bool feedforward_holds(const feedforward_t *x)
{
    return x->state.hold.active;
}

static inline void feedforward_set_caution(feedforward_t *x, double extra_margin)
{
    x->state.hold.extra_margin = (uint32_t)(extra_margin * 4294967295.0);
}

static inline double feedforward_caution(const feedforward_t *x)
{
    return x->state.hold.extra_margin / 4294967295.0;
}

/// As if `offset`, in prior standard deviations, had been learned in `direction`.
static inline void feedforward_set_offset(feedforward_t *x, uint32_t direction, double offset)
{
    x->state.learning.of[direction].offset = (int32_t)lround(offset * 268435456.0);
}

/// As if `scale`, in prior spreads, had been learned in `direction` across 0, or on the side that learning is on.
static inline void feedforward_set_scale(feedforward_t *x, bool across, uint32_t direction, double scale)
{
    tribo_breakaway_learning_q31_state_t *learning                 = &x->state.learning;
    (across ? learning->across.of : learning->of)[direction].scale = (int32_t)lround(scale * 268435456.0);
}

/// What was learned is the same, of the other direction and side of 0 where `mirrored`.
static inline bool feedforward_knows_the_same(const feedforward_t *a, const feedforward_t *b, bool mirrored)
{
    tribo_breakaway_learning_q31_state_t p = a->state.learning;
    tribo_breakaway_learning_q31_state_t q = b->state.learning;

    bool same = true;
    for (int side = 0; side < 2; side++)
    {
        same = same && p.shared[0] == q.shared[0] && p.shared[3] == q.shared[3] &&
               p.shared[1] == q.shared[mirrored ? 2 : 1] && p.shared[2] == q.shared[mirrored ? 1 : 2];
        for (int d = 0; d < 2; d++)
        {
            const tribo_breakaway_learned_q31_t *m = &p.of[d];
            const tribo_breakaway_learned_q31_t *n = &q.of[mirrored ? 1 - d : d];
            same = same && m->scale == n->scale && m->offset == n->offset && m->ss == n->ss && m->so == n->so &&
                   m->oo == n->oo && p.travel[d] == q.travel[mirrored ? 1 - d : d];
        }
        for (int d = 0; d < 2; d++)
        {
            p.of[d]         = p.across.of[d];
            q.of[d]         = q.across.of[d];
            p.travel[d]     = p.across.travel[d];
            q.travel[d]     = q.across.travel[d];
            p.shared[d]     = p.across.shared[d];
            q.shared[d]     = q.across.shared[d];
            p.shared[2 + d] = p.across.shared[2 + d];
            q.shared[2 + d] = q.across.shared[2 + d];
        }
    }
    return same;
}

static inline double feedforward_before(feedforward_t *x, double r, double y)
{
    return feedforward_from_q31(x,
                                tribo_feedforward_q31_before(&x->params,
                                                             &x->friction,
                                                             &x->state,
                                                             feedforward_to_q31(x, r),
                                                             feedforward_to_q31(x, y),
                                                             &x->signals));
}

static inline double feedforward_added(feedforward_t *x, double v)
{
    return feedforward_from_q31(
        x,
        tribo_feedforward_q31_added(&x->params, &x->state, feedforward_to_q31(x, v), &x->signals));
}

static inline void feedforward_after(feedforward_t *x, double v, double u, bool limited)
{
    tribo_feedforward_q31_after(&x->params,
                                &x->friction,
                                &x->state,
                                feedforward_to_q31(x, v),
                                feedforward_to_q31(x, u),
                                limited,
                                &x->signals);
}

static inline feedforward_seen_t feedforward_seen(const feedforward_t *x)
{
    const tribo_feedforward_q31_signals_t      *s        = &x->signals;
    feedforward_seen_t                          seen     = {.e       = feedforward_from_q31(x, s->e),
                                                            .lin     = feedforward_from_units(x, s->lin),
                                                            .f       = feedforward_from_units(x, s->f),
                                                            .b       = feedforward_from_units(x, s->b),
                                                            .added   = feedforward_from_q31(x, s->added),
                                                            .sigma   = s->sigma / 536870912.0,
                                                            .z       = feedforward_from_units(x, s->observer.friction),
                                                            .travel  = feedforward_from_units(x, s->travel),
                                                            .reached = feedforward_from_units(x, s->reached),
                                                            .turns   = s->turns,
                                                            .bad     = x->state.bad_inputs};
    const tribo_breakaway_learning_q31_state_t *learning = &x->state.learning;
    for (int d = 0; d < 2; d++)
    {
        const uint32_t load  = 4u * tribo_q31_magnitude(s->reached);
        const uint32_t prior = (x->friction.law[d].offset + tribo_q31_high(x->friction.law[d].slope, load)) / 4u;
        const tribo_breakaway_learning_q31_signals_t at =
            tribo_breakaway_learning_q31_at(&x->params.learning, learning, (uint32_t)d, prior);
        seen.rho[d]               = learning->of[d].scale / 268435456.0;
        seen.off[d]               = learning->of[d].offset / 268435456.0;
        seen.L[d]                 = feedforward_from_units(x, at.weighted);
        seen.relative_variance[d] = at.relative_variance / 2147483648.0;
    }
    return seen;
}

static inline feedforward_learned_t feedforward_learned(const feedforward_t *x, uint32_t direction, double force)
{
    const tribo_feedforward_q31_learned_t at =
        tribo_feedforward_q31_learned(&x->params, &x->friction, &x->state, direction, feedforward_to_q31(x, force));
    return (feedforward_learned_t){.L                 = feedforward_from_units(x, at.L),
                                   .relative_variance = at.relative_variance / 2147483648.0,
                                   .travel            = feedforward_from_units(x, (int64_t)at.travel),
                                   .at_bound          = at.at_bound,
                                   .stays_at_bound    = at.stays_at_bound};
}

/// Controller and feed-forward, as the force loop joins them.
typedef struct
{
    tribo_controller_q31_params_t  controller;
    tribo_controller_q31_state_t   controller_state;
    tribo_controller_q31_signals_t controller_signals;
    feedforward_t                  feedforward;
    bool                           off; // no compensation
} fed_loop_t;

static inline tribo_status_t fed_loop_init(fed_loop_t                           *x,
                                           const tribo_controller_f32_config_t  *controller,
                                           const tribo_feedforward_f32_config_t *config,
                                           const tribo_compensator_f32_config_t *model,
                                           double                                input_max,
                                           double                                h)
{
    x->off                      = config == NULL;
    x->feedforward.full_scale   = FULL_SCALE_N;
    const tribo_status_t status = tribo_controller_q31_init(&x->controller, controller, (float)FULL_SCALE_N, NULL);
    tribo_controller_q31_reset(&x->controller_state);
    if (status != TRIBO_OK || config == NULL)
    {
        return status;
    }
    return feedforward_init_scaled(&x->feedforward, config, model, input_max, h, 1.0);
}

/// One tick; returns u.
static inline double fed_loop_step(fed_loop_t *x, double r, double y)
{
    feedforward_t *const f = &x->feedforward;
    const int32_t        R = feedforward_to_q31(f, r);
    const int32_t        Y = feedforward_to_q31(f, y);
    const int32_t        e =
        x->off ? R - Y : tribo_feedforward_q31_before(&f->params, &f->friction, &f->state, R, Y, &f->signals);
    tribo_controller_q31_state_t   copy = x->controller_state;
    tribo_controller_q31_signals_t signals;
    (void)controller_q31_step(&x->controller, &copy, e, 0, &signals);
    const int32_t v     = signals.v; // before the limit
    const int32_t added = x->off ? 0 : tribo_feedforward_q31_added(&f->params, &f->state, v, &f->signals);
    const int32_t u     = controller_q31_step(&x->controller, &x->controller_state, e, added, &x->controller_signals);
    if (!x->off)
    {
        tribo_feedforward_q31_after(&f->params,
                                    &f->friction,
                                    &f->state,
                                    v,
                                    u,
                                    x->controller_signals.limited,
                                    &f->signals);
    }
    return feedforward_from_q31(f, u);
}

#endif
