// The f32 feed-forward as the contract suite sees it: physical units in double.

#ifndef TESTS_CONTRACT_FEEDFORWARD_ARITH_F32_H
#define TESTS_CONTRACT_FEEDFORWARD_ARITH_F32_H

#include "controller/controller_f32.h"
#include "feedforward/feedforward_f32.h"
#include "feedforward_seen.h"
#include "tribo/controller_f32.h"
#include "tribo/feedforward_f32.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#define GOLDEN_FEEDFORWARD_TOLERANCE_N 1e-5 // of e, lin, f, b, z, L
#define GOLDEN_LEARNING_TOLERANCE      2e-4 // of what is learned, in prior spreads

typedef struct
{
    tribo_feedforward_f32_params_t  params;
    tribo_friction_f32_params_t     friction;
    tribo_feedforward_f32_state_t   state;
    tribo_feedforward_f32_signals_t signals;
    double                          scale_sd, offset_sd;
} feedforward_t;

/// With all forces of a config times `scale`.
static inline tribo_status_t feedforward_init_scaled(feedforward_t                        *x,
                                                     const tribo_feedforward_f32_config_t *config,
                                                     const tribo_compensator_f32_config_t *model,
                                                     double                                input_max,
                                                     double                                h,
                                                     double                                scale)
{
    (void)scale; // a float has none
    x->scale_sd           = (double)config->learning.scale_sd;
    x->offset_sd          = (double)config->learning.offset_sd_n;
    tribo_status_t status = tribo_friction_f32_init(&x->friction, &model->friction, (float)h);
    if (status == TRIBO_OK)
    {
        status = tribo_feedforward_f32_init(&x->params, config, model, (float)input_max, (float)h);
    }
    if (status == TRIBO_OK)
    {
        tribo_feedforward_f32_reset(&x->params, &x->state);
    }
    return status;
}

static inline void feedforward_restart(feedforward_t *x)
{
    tribo_feedforward_f32_restart(&x->state);
}

static inline void feedforward_reset(feedforward_t *x)
{
    tribo_feedforward_f32_reset(&x->params, &x->state);
}

static inline void feedforward_enter(feedforward_t *x, double added)
{
    tribo_feedforward_f32_enter(&x->state, (float)added);
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
    x->state.hold.extra_margin = (float)extra_margin;
}

static inline double feedforward_caution(const feedforward_t *x)
{
    return (double)x->state.hold.extra_margin;
}

/// As if `offset`, in prior standard deviations, had been learned in `direction`.
static inline void feedforward_set_offset(feedforward_t *x, uint32_t direction, double offset)
{
    x->state.learning.of[direction].offset_n = (float)(offset * x->offset_sd);
}

/// As if `scale`, in prior spreads, had been learned in `direction` across 0, or on the side that learning is on.
static inline void feedforward_set_scale(feedforward_t *x, bool across, uint32_t direction, double scale)
{
    tribo_breakaway_learning_f32_state_t *learning                 = &x->state.learning;
    (across ? learning->across.of : learning->of)[direction].scale = (float)(scale * x->scale_sd);
}

/// What was learned is the same, of the other direction and side of 0 where `mirrored`.
static inline bool feedforward_knows_the_same(const feedforward_t *a, const feedforward_t *b, bool mirrored)
{
    tribo_breakaway_learning_f32_state_t p = a->state.learning;
    tribo_breakaway_learning_f32_state_t q = b->state.learning;

    bool same = true;
    for (int side = 0; side < 2; side++)
    {
        same = same && p.shared[0] == q.shared[0] && p.shared[3] == q.shared[3] &&
               p.shared[1] == q.shared[mirrored ? 2 : 1] && p.shared[2] == q.shared[mirrored ? 1 : 2];
        for (int d = 0; d < 2; d++)
        {
            const tribo_breakaway_learned_f32_t *m = &p.of[d];
            const tribo_breakaway_learned_f32_t *n = &q.of[mirrored ? 1 - d : d];
            same = same && m->scale == n->scale && m->offset_n == n->offset_n && m->ss == n->ss && m->so == n->so &&
                   m->oo == n->oo && p.travel_n[d] == q.travel_n[mirrored ? 1 - d : d];
        }
        for (int d = 0; d < 2; d++)
        {
            p.of[d]         = p.across.of[d];
            q.of[d]         = q.across.of[d];
            p.travel_n[d]   = p.across.travel_n[d];
            q.travel_n[d]   = q.across.travel_n[d];
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
    return (double)tribo_feedforward_f32_before(&x->params, &x->friction, &x->state, (float)r, (float)y, &x->signals);
}

static inline double feedforward_added(feedforward_t *x, double v)
{
    return (double)tribo_feedforward_f32_added(&x->params, &x->state, (float)v, &x->signals);
}

static inline void feedforward_after(feedforward_t *x, double v, double u, bool limited)
{
    tribo_feedforward_f32_after(&x->params, &x->friction, &x->state, (float)v, (float)u, limited, &x->signals);
}

static inline feedforward_seen_t feedforward_seen(const feedforward_t *x)
{
    const tribo_feedforward_f32_signals_t      *s        = &x->signals;
    feedforward_seen_t                          seen     = {.e       = (double)s->e_n,
                                                            .lin     = (double)s->lin_n,
                                                            .f       = (double)s->f_n,
                                                            .b       = (double)s->b_n,
                                                            .added   = (double)s->added_n,
                                                            .sigma   = (double)s->sigma,
                                                            .z       = (double)s->observer.friction_n,
                                                            .travel  = (double)s->travel_n,
                                                            .reached = (double)s->reached_n,
                                                            .turns   = s->turns,
                                                            .bad     = x->state.bad_inputs};
    const tribo_breakaway_learning_f32_state_t *learning = &x->state.learning;
    for (int d = 0; d < 2; d++)
    {
        seen.rho[d]       = (double)learning->of[d].scale / x->scale_sd;
        seen.off[d]       = (double)learning->of[d].offset_n / x->offset_sd;
        const float load  = fabsf(s->reached_n);
        const float prior = x->friction.law[d].offset_n + x->friction.law[d].slope * load;
        const tribo_breakaway_learning_f32_signals_t at =
            tribo_breakaway_learning_f32_at(&x->params.learning, learning, (uint32_t)d, prior);
        seen.L[d]                 = (double)at.weighted_n;
        seen.relative_variance[d] = (double)at.relative_variance;
    }
    return seen;
}

static inline feedforward_learned_t feedforward_learned(const feedforward_t *x, uint32_t direction, double force)
{
    const tribo_feedforward_f32_learned_t at =
        tribo_feedforward_f32_learned(&x->params, &x->friction, &x->state, direction, (float)force);
    return (feedforward_learned_t){.L                 = (double)at.L_n,
                                   .relative_variance = (double)at.relative_variance,
                                   .travel            = (double)at.travel_n,
                                   .at_bound          = at.at_bound,
                                   .stays_at_bound    = at.stays_at_bound};
}

/// Controller and feed-forward, as the force loop joins them.
typedef struct
{
    tribo_controller_f32_params_t  controller;
    tribo_controller_f32_state_t   controller_state;
    tribo_controller_f32_signals_t controller_signals;
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
    const tribo_status_t status = tribo_controller_f32_init(&x->controller, controller);
    tribo_controller_f32_reset(&x->controller_state);
    if (status != TRIBO_OK || config == NULL)
    {
        return status;
    }
    return feedforward_init_scaled(&x->feedforward, config, model, input_max, h, 1.0);
}

/// One tick; returns u.
static inline double fed_loop_step(fed_loop_t *x, double r, double y)
{
    const double                 e = x->off ? (double)((float)r - (float)y) : feedforward_before(&x->feedforward, r, y);
    tribo_controller_f32_state_t copy = x->controller_state;
    tribo_controller_f32_signals_t signals;
    (void)controller_f32_step(&x->controller, &copy, (float)e, 0.0f, &signals);
    const double v     = (double)signals.v_n; // before the limit
    const double added = x->off ? 0.0 : feedforward_added(&x->feedforward, v);
    const float  u =
        controller_f32_step(&x->controller, &x->controller_state, (float)e, (float)added, &x->controller_signals);
    if (!x->off)
    {
        feedforward_after(&x->feedforward, v, (double)u, x->controller_signals.limited);
    }
    return (double)u;
}

#endif
