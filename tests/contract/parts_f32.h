// The f32 parts as the contract suite sees them: physical units in double.

#ifndef TESTS_CONTRACT_PARTS_F32_H
#define TESTS_CONTRACT_PARTS_F32_H

#include "arm_f32.h"
#include "cascade_f32.h"
#include "feedforward/breakaway_learning_f32.h"
#include "feedforward/friction_observer_f32.h"
#include "feedforward/hold_f32.h"
#include "feedforward/play_f32.h"
#include "feedforward/reference_model_f32.h"
#include "guard/guard_f32.h"
#include "paper/lugre_f32.h"
#include "parts_seen.h"
#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/friction_f32.h"

#include <stdbool.h>
#include <stddef.h>

#define CASCADE_ROUNDING          1e-6   // of a node
#define REFERENCE_MODEL_TOLERANCE 1.5e-7 // N, of steps of up to 0.5 N
#define REFERENCE_MODEL_REST      1e-20
#define OBSERVER_REST             1e-7   // N, of friction that stands
#define OBSERVER_TOLERANCE        1.5e-7 // N, of forces within 0.5 N
#define GUARD_ROUNDING            1e-6   // of the fade
#define LUGRE_TOLERANCE_N         1e-6   // of a step
#define LUGRE_BRISTLE_N           1e-7
#define HOLD_REST                 1e-6 // N, of an error in the deadband
#define LEARNING_TRAVEL_MAX_N     5e-3 // in a tick
#define LEARNING_TOLERANCE_SD     2e-3 // of what is learned, in prior standard deviations
#define LEARNING_TOLERANCE        1e-5 // of the relative variance
#define LEARNING_TOLERANCE_N      5e-6 // of L

// --- cascade of sections -------------------------------------------------------------------------------------------

typedef struct
{
    tribo_biquad_f32_params_t  params;
    tribo_biquad_f32_state_t   state;
    tribo_biquad_f32_outputs_t nodes; // between the halves of a step
} cascade_t;

static inline tribo_status_t cascade_init(cascade_t *x, const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    tribo_biquad_f32_reset(&x->state);
    return tribo_biquad_f32_init(&x->params, sections, count);
}

/// The first half of a step, for an input within +-1; y is not limited.
static inline double cascade_output(cascade_t *x, double input)
{
    return (double)biquad_f32_output(&x->params, &x->state, (float)input, &x->nodes);
}

/// The second half, as if the input had been larger by `correction`.
static inline void cascade_advance(cascade_t *x, double input, double correction)
{
    biquad_f32_advance(&x->params, &x->state, (float)input, &x->nodes, (float)correction);
}

/// Takes `x` over to the params of `to`.
static inline void cascade_change(cascade_t *x, const cascade_t *to, double input, double offset)
{
    tribo_biquad_f32_change(&x->params, &to->params, &x->state, (float)input, (float)offset);
    x->params = to->params;
}

static inline double cascade_w1(const cascade_t *x, uint32_t i)
{
    return (double)x->state.section[i].w1;
}

// --- play -----------------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_play_f32_state_t state;
} play_t;

static inline void play_reset(play_t *x, double position)
{
    play_f32_reset(&x->state, (float)position);
}

static inline double play_step(play_t *x, double input, double below, double above)
{
    return (double)play_f32_step(&x->state, (float)input, (float)below, (float)above);
}

static inline double play_position(const play_t *x)
{
    return (double)x->state.position_n;
}

// --- reference model ------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_reference_model_f32_params_t params;
    tribo_reference_model_f32_state_t  state;
} reference_model_t;

static inline tribo_status_t reference_model_init(reference_model_t                        *x,
                                                  const tribo_reference_model_f32_config_t *config,
                                                  double                                    h)
{
    if (x != NULL)
    {
        tribo_reference_model_f32_reset(&x->state);
    }
    return tribo_reference_model_f32_init(x != NULL ? &x->params : NULL, config, (float)h);
}

static inline double reference_model_step(reference_model_t *x, double moved, double ahead)
{
    return (double)reference_model_f32_step(&x->params, &x->state, (float)moved, (float)ahead);
}

// --- friction observer ----------------------------------------------------------------------------------------------

typedef struct
{
    tribo_friction_observer_f32_params_t params;
    tribo_friction_observer_f32_state_t  state;
} observer_t;

static inline void observer_reset(observer_t *x, double force)
{
    tribo_friction_observer_f32_reset(&x->state, (float)force);
}

static inline tribo_status_t observer_init(observer_t                               *x,
                                           const tribo_reference_model_f32_config_t *config,
                                           double                                    filter_time,
                                           double                                    h)
{
    return tribo_friction_observer_f32_init(x != NULL ? &x->params : NULL, config, (float)filter_time, (float)h);
}

static inline observer_seen_t observer_step(observer_t *x, double u, double y)
{
    tribo_friction_observer_f32_signals_t seen;
    friction_observer_f32_step(&x->params, &x->state, (float)u, (float)y, &seen);
    return (observer_seen_t){.friction = (double)seen.friction_n,
                             .force    = (double)seen.force_n,
                             .change   = (double)seen.change_n};
}

// --- hold -----------------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_hold_f32_params_t params;
    tribo_hold_f32_state_t  state;
} hold_t;

static inline tribo_status_t hold_init(hold_t *x, const tribo_hold_f32_config_t *config, double h)
{
    if (x != NULL)
    {
        hold_f32_reset(&x->state);
    }
    return tribo_hold_f32_init(x != NULL ? &x->params : NULL, config, (float)h);
}

static inline bool hold_stands(hold_t *x, double reference, double half, bool step)
{
    return hold_f32_stands(&x->params, &x->state, (float)reference, (float)half, step);
}

static inline void hold_enter(hold_t *x, double u, double f, int32_t sign, double y)
{
    hold_f32_enter(&x->state, (float)u, (float)f, sign, (float)y);
}

static inline double hold_step(hold_t *x, double u, double positive, double negative)
{
    return (double)hold_f32_step(&x->params, &x->state, (float)u, (float)positive, (float)negative);
}

static inline double hold_deadband(hold_t *x, double e, double y)
{
    return (double)hold_f32_deadband(&x->params, &x->state, (float)e, (float)y);
}

static inline void hold_learned(hold_t *x, double travel)
{
    hold_f32_learned(&x->params, &x->state, (float)travel);
}

static inline double hold_position(const hold_t *x)
{
    return (double)x->state.play.position_n;
}

static inline double hold_extra_margin(const hold_t *x)
{
    return (double)x->state.extra_margin;
}

// --- breakaway learning ---------------------------------------------------------------------------------------------

typedef struct
{
    tribo_breakaway_learning_f32_params_t params;
    tribo_breakaway_learning_f32_state_t  state;
    double                                scale_sd, offset_sd;
} learning_t;

typedef tribo_breakaway_across_f32_t learning_side_t;

static inline void learning_reset(learning_t *x)
{
    tribo_breakaway_learning_f32_reset(&x->params, &x->state);
}

static inline tribo_status_t learning_init(learning_t *x, const tribo_breakaway_learning_f32_config_t *config)
{
    const tribo_status_t status = tribo_breakaway_learning_f32_init(x != NULL ? &x->params : NULL, config);
    if (status == TRIBO_OK)
    {
        x->scale_sd  = (double)config->scale_sd;
        x->offset_sd = (double)config->offset_sd_n;
        learning_reset(x);
    }
    return status;
}

static inline learning_seen_t learning_at(const learning_t *x, uint32_t direction, double prior)
{
    const tribo_breakaway_learning_f32_signals_t at =
        tribo_breakaway_learning_f32_at(&x->params, &x->state, direction, (float)prior);
    return (learning_seen_t){.L        = (double)at.L_n,
                             .variance = (double)at.relative_variance,
                             .weighted = (double)at.weighted_n};
}

static inline bool learning_is_at_bound(const learning_t *x, uint32_t direction, double prior)
{
    return tribo_breakaway_learning_f32_is_at_bound(&x->params, &x->state, direction, (float)prior);
}

/// As the feed-forward does it.
static inline void learning_step(learning_t *x, uint32_t direction, double travel, double prior, double measured)
{
    breakaway_learning_f32_step(&x->params, &x->state, direction, (float)travel, (float)prior, (float)measured);
    x->state.slid |= travel > 0.0;
}

/// `travel` as a step can take it.
static inline double learning_travel_of(double travel)
{
    return (double)(float)travel;
}

static inline void learning_slide_ends(learning_t *x, uint32_t direction, double prior)
{
    tribo_breakaway_learning_f32_slide_ends(&x->params, &x->state, direction, (float)prior);
}

static inline void learning_change_side(learning_t *x)
{
    tribo_breakaway_learning_f32_change_side(&x->params, &x->state);
}

static inline void learning_restore(learning_t *x)
{
    tribo_breakaway_learning_f32_restore(&x->state);
}

static inline double learning_travel(const learning_t *x, uint32_t direction)
{
    return (double)x->state.travel_n[direction];
}

static inline void learning_forget_travel(learning_t *x, uint32_t direction)
{
    x->state.travel_n[direction] = 0.0f;
}

/// Scale and offset of `direction`, in prior standard deviations.
static inline double learning_scale(const learning_t *x, uint32_t direction)
{
    return (double)x->state.of[direction].scale / x->scale_sd;
}

static inline double learning_offset(const learning_t *x, uint32_t direction)
{
    return (double)x->state.of[direction].offset_n / x->offset_sd;
}

static inline void learning_set(learning_t *x, uint32_t direction, double scale, double offset)
{
    x->state.of[direction].scale    = (float)(scale * x->scale_sd);
    x->state.of[direction].offset_n = (float)(offset * x->offset_sd);
}

/// Adds `by`, in prior standard deviations, to the scale of `direction`.
static inline void learning_add_scale(learning_t *x, uint32_t direction, double by)
{
    x->state.of[direction].scale += (float)(by * x->scale_sd);
}

/// The largest offset below its bound, as learning_set takes it.
static inline double learning_last_offset(void)
{
    return 2.99;
}

/// What the variance of a scale is on a side of F = 0 that is taken over, `ss` on the other.
static inline float learning_apart(const learning_t *x, float ss)
{
    return ss + 0.25f * x->params.scale_variance;
}

/// What is known on a side of F = 0, each number its own; the scales are of one `sign`, their variances `variance` prior ones.
static inline learning_side_t learning_numbers(const learning_t *x, int32_t sign, double variance)
{
    const float     s    = (float)sign;
    const float     ss   = (float)variance * x->params.scale_variance;
    learning_side_t side = {.travel_n = {0.0f}};
    for (uint32_t d = 0; d < 2u; d++)
    {
        const float i = 0.01f * (float)d;
        side.of[d]    = (tribo_breakaway_learned_f32_t){s + i, 0.2f * s + i, ss + 0.1f * i, 0.5f * s + i, 0.6f + s + i};
        side.shared[d]      = 0.3f * s + i;
        side.shared[2u + d] = 0.4f * s + i;
        side.travel_n[d]    = 6.0f + s + i;
    }
    return side;
}

/// The side of F = 0 that learning is on.
static inline learning_side_t learning_side(const learning_t *x)
{
    learning_side_t side = {.travel_n = {0.0f}};
    for (uint32_t d = 0; d < 2u; d++)
    {
        side.of[d]          = x->state.of[d];
        side.shared[d]      = x->state.shared[d];
        side.shared[2u + d] = x->state.shared[2u + d];
        side.travel_n[d]    = x->state.travel_n[d];
    }
    return side;
}

static inline void learning_set_side(learning_t *x, const learning_side_t *side)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        x->state.of[d]          = side->of[d];
        x->state.shared[d]      = side->shared[d];
        x->state.shared[2u + d] = side->shared[2u + d];
        x->state.travel_n[d]    = side->travel_n[d];
    }
}

// --- guard ---------------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_guard_f32_params_t params;
    tribo_guard_f32_state_t  state;
} guard_t;

static inline tribo_status_t guard_init(guard_t *x, const tribo_guard_f32_config_t *config, double h)
{
    if (x != NULL)
    {
        tribo_guard_f32_reset(&x->state);
    }
    return tribo_guard_f32_init(x != NULL ? &x->params : NULL, config, (float)h);
}

/// Returns the fade of friction, 1 to 0.
static inline double guard_step(guard_t *x, double r, double y, double f)
{
    return (double)tribo_guard_f32_step(&x->params, &x->state, (float)r, (float)y, (float)f, true);
}

static inline void guard_restore(guard_t *x)
{
    tribo_guard_f32_restore(&x->state);
}

// --- LuGre friction ------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_lugre_f32_params_t     params;
    tribo_friction_f32_params_t  friction;
    tribo_lugre_f32_state_t      state;
    tribo_friction_f32_signals_t seen;
} lugre_t;

static inline void lugre_reset(lugre_t *x)
{
    tribo_lugre_f32_reset(&x->state);
}

static inline tribo_status_t lugre_init(lugre_t                           *x,
                                        const tribo_lugre_f32_config_t    *config,
                                        const tribo_arm_f32_config_t      *arm,
                                        const tribo_friction_f32_config_t *law,
                                        double                             h)
{
    lugre_reset(x);
    const tribo_status_t status = tribo_lugre_f32_init(&x->params, config, arm, (float)h);
    return status != TRIBO_OK ? status : tribo_friction_f32_init(&x->friction, law, (float)h);
}

/// Returns f.
static inline double lugre_step(lugre_t *x, double u, double F)
{
    return (double)tribo_lugre_f32_step(&x->params, &x->friction, &x->state, (float)u, (float)F, &x->seen);
}

static inline double lugre_n(const lugre_t *x)
{
    return (double)x->seen.n_n;
}

static inline double lugre_L(const lugre_t *x)
{
    return (double)x->seen.L_n;
}

/// Force of the bristles, and the drive that the arm had last.
static inline double lugre_bristle(const lugre_t *x)
{
    return (double)x->state.bristle_n;
}

static inline double lugre_drive(const lugre_t *x)
{
    return (double)x->state.drive_n;
}

static inline void lugre_set(lugre_t *x, double bristle, double drive)
{
    x->state.bristle_n = (float)bristle;
    x->state.drive_n   = (float)drive;
}

#endif
