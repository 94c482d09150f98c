// The Q31 parts as the contract suite sees them: physical units in double, at a full scale of 2 N.

#ifndef TESTS_CONTRACT_PARTS_Q31_H
#define TESTS_CONTRACT_PARTS_Q31_H

#include "arm_q31.h"
#include "cascade_q31.h"
#include "feedforward/breakaway_learning_q31.h"
#include "feedforward/friction_observer_q31.h"
#include "feedforward/hold_f32.h"
#include "feedforward/hold_q31.h"
#include "feedforward/play_q31.h"
#include "feedforward/reference_model_f32.h"
#include "feedforward/reference_model_q31.h"
#include "guard/guard_q31.h"
#include "paper/lugre_f32.h"
#include "paper/lugre_q31.h"
#include "parts_seen.h"
#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/friction_q31.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#define PARTS_FULL_SCALE_N        2.0
#define PARTS_UNIT_N              (PARTS_FULL_SCALE_N / 536870912.0)
#define CASCADE_ROUNDING          1e-6                  // of a node
#define REFERENCE_MODEL_TOLERANCE 2e-7                  // N, of steps of up to 0.5 N
#define REFERENCE_MODEL_REST      (40.0 * PARTS_UNIT_N) // less than 1/part for each low pass
#define OBSERVER_REST             2e-7                  // N, of friction that stands
#define OBSERVER_TOLERANCE        4e-7                  // N, of forces within 0.5 N
#define GUARD_ROUNDING            1e-6                  // of the fade
#define LUGRE_TOLERANCE_N         2e-7                  // of a step
#define LUGRE_BRISTLE_N           2e-7
#define HOLD_REST                 1.2e-6 // N, of an error in the deadband: less than 1/part units
#define LEARNING_TRAVEL_MAX_N     2e-4   // in a tick: from 4e-4 on the gain is limited
#define LEARNING_TOLERANCE_SD     2e-4   // of what is learned, in prior standard deviations
#define LEARNING_TOLERANCE        1e-4   // of the relative variance
#define LEARNING_TOLERANCE_N      2e-5   // of L

static inline int32_t parts_units(double force_n)
{
    return (int32_t)lround(force_n / PARTS_UNIT_N);
}

static inline double parts_force(int64_t units)
{
    return (double)units * PARTS_UNIT_N;
}

// --- cascade of sections -------------------------------------------------------------------------------------------

typedef struct
{
    tribo_biquad_q31_params_t  params;
    tribo_biquad_q31_state_t   state;
    tribo_biquad_q31_outputs_t nodes; // between the halves of a step
} cascade_t;

static inline tribo_status_t cascade_init(cascade_t *x, const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    tribo_biquad_q31_reset(&x->state);
    return cascade_q31_init(&x->params, sections, count, NULL);
}

static inline int32_t cascade_q31(double x)
{
    return (int32_t)fmin(2147483647.0, fmax(-2147483647.0, round(x * 2147483648.0)));
}

/// The first half of a step, for an input within +-1; y is not limited.
static inline double cascade_output(cascade_t *x, double input)
{
    return (double)cascade_q31_output(&x->params, &x->state, cascade_q31(input), &x->nodes) / 2147483648.0;
}

/// The second half, as if the input had been larger by `correction`.
static inline void cascade_advance(cascade_t *x, double input, double correction)
{
    (void)input;
    biquad_q31_advance(&x->params, &x->state, &x->nodes, cascade_q31(ldexp(correction, -x->params.input_scale)));
}

/// Takes `x` over to the params of `to`.
static inline void cascade_change(cascade_t *x, const cascade_t *to, double input, double offset)
{
    tribo_biquad_q31_change(&x->params, &to->params, &x->state, cascade_q31(input), cascade_q31(offset));
    x->params = to->params;
}

static inline double cascade_w1(const cascade_t *x, uint32_t i)
{
    return ldexp((double)x->state.section[i].w1, x->params.section[i].scale - 59);
}

/// To Q31, for the parts that take forces so; beyond full scale it shows as full scale.
static inline int32_t parts_q31(double force_n)
{
    return (int32_t)fmin(2147483647.0, fmax(-2147483647.0, round(force_n / PARTS_FULL_SCALE_N * 2147483648.0)));
}

static inline double parts_from_q31(int32_t x)
{
    return x / 2147483648.0 * PARTS_FULL_SCALE_N;
}

// --- play ----------------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_play_q31_state_t state;
} play_t;

static inline void play_reset(play_t *x, double position)
{
    play_q31_reset(&x->state, parts_units(position));
}

static inline double play_step(play_t *x, double input, double below, double above)
{
    return parts_force(play_q31_step(&x->state, parts_units(input), parts_units(below), parts_units(above)));
}

static inline double play_position(const play_t *x)
{
    return parts_force(x->state.position);
}

// --- reference model -----------------------------------------------------------------------------------------------

typedef struct
{
    tribo_reference_model_q31_params_t params;
    tribo_reference_model_q31_state_t  state;
} reference_model_t;

static inline tribo_status_t reference_model_init(reference_model_t                        *x,
                                                  const tribo_reference_model_f32_config_t *config,
                                                  double                                    h)
{
    if (x != NULL)
    {
        tribo_reference_model_q31_reset(&x->state);
    }
    return tribo_reference_model_q31_init(x != NULL ? &x->params : NULL, config, (float)h);
}

static inline double reference_model_step(reference_model_t *x, double moved, double ahead)
{
    return parts_force(reference_model_q31_step(&x->params, &x->state, parts_units(moved), parts_units(ahead)));
}

// --- friction observer ---------------------------------------------------------------------------------------------

typedef struct
{
    tribo_friction_observer_q31_params_t params;
    tribo_friction_observer_q31_state_t  state;
} observer_t;

static inline void observer_reset(observer_t *x, double force)
{
    tribo_friction_observer_q31_reset(&x->state, parts_units(force));
}

static inline tribo_status_t observer_init(observer_t                               *x,
                                           const tribo_reference_model_f32_config_t *config,
                                           double                                    filter_time,
                                           double                                    h)
{
    return tribo_friction_observer_q31_init(x != NULL ? &x->params : NULL, config, (float)filter_time, (float)h);
}

static inline observer_seen_t observer_step(observer_t *x, double u, double y)
{
    tribo_friction_observer_q31_signals_t seen;
    friction_observer_q31_step(&x->params, &x->state, parts_units(u), parts_units(y), &seen);
    return (observer_seen_t){.friction = parts_force(seen.friction),
                             .force    = parts_force(seen.force),
                             .change   = parts_force(seen.change)};
}

// --- hold ----------------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_hold_q31_params_t params;
    tribo_hold_q31_state_t  state;
} hold_t;

static inline tribo_status_t hold_init(hold_t *x, const tribo_hold_f32_config_t *config, double h)
{
    if (x != NULL)
    {
        hold_q31_reset(&x->state);
    }
    return tribo_hold_q31_init(x != NULL ? &x->params : NULL, config, (float)h, (float)PARTS_FULL_SCALE_N);
}

static inline bool hold_stands(hold_t *x, double reference, double half, bool step)
{
    return hold_q31_stands(&x->params, &x->state, parts_units(reference), (uint32_t)parts_units(half), step);
}

static inline void hold_enter(hold_t *x, double u, double f, int32_t sign, double y)
{
    hold_q31_enter(&x->state, parts_units(u), parts_units(f), sign, parts_units(y));
}

static inline double hold_step(hold_t *x, double u, double positive, double negative)
{
    return parts_force(hold_q31_step(&x->params,
                                     &x->state,
                                     parts_units(u),
                                     (uint32_t)parts_units(positive),
                                     (uint32_t)parts_units(negative)));
}

static inline double hold_deadband(hold_t *x, double e, double y)
{
    return parts_force(hold_q31_deadband(&x->params, &x->state, parts_units(e), parts_units(y)));
}

static inline void hold_learned(hold_t *x, double travel)
{
    hold_q31_learned(&x->params, &x->state, (uint32_t)parts_units(travel));
}

static inline double hold_position(const hold_t *x)
{
    return parts_force(x->state.play.position);
}

static inline double hold_extra_margin(const hold_t *x)
{
    return x->state.extra_margin / 4294967296.0;
}

// --- breakaway learning --------------------------------------------------------------------------------------------

typedef struct
{
    tribo_breakaway_learning_q31_params_t params;
    tribo_breakaway_learning_q31_state_t  state;
} learning_t;

typedef tribo_breakaway_across_q31_t learning_side_t;

static inline void learning_reset(learning_t *x)
{
    tribo_breakaway_learning_q31_reset(&x->params, &x->state);
}

static inline tribo_status_t learning_init(learning_t *x, const tribo_breakaway_learning_f32_config_t *config)
{
    const tribo_status_t status =
        tribo_breakaway_learning_q31_init(x != NULL ? &x->params : NULL, config, (float)PARTS_FULL_SCALE_N);
    if (status == TRIBO_OK)
    {
        learning_reset(x);
    }
    return status;
}

static inline learning_seen_t learning_at(const learning_t *x, uint32_t direction, double prior)
{
    const tribo_breakaway_learning_q31_signals_t at =
        tribo_breakaway_learning_q31_at(&x->params, &x->state, direction, (uint32_t)parts_units(prior));
    return (learning_seen_t){.L        = parts_force(at.L),
                             .variance = at.relative_variance / 2147483648.0,
                             .weighted = parts_force(at.weighted)};
}

static inline bool learning_is_at_bound(const learning_t *x, uint32_t direction, double prior)
{
    return tribo_breakaway_learning_q31_is_at_bound(&x->params, &x->state, direction, (uint32_t)parts_units(prior));
}

/// As the feed-forward does it: travel up to 2^20 units.
static inline void learning_step(learning_t *x, uint32_t direction, double travel, double prior, double measured)
{
    const uint32_t units = (uint32_t)parts_units(travel);
    const uint32_t most  = BREAKAWAY_LEARNING_Q31_TRAVEL_MAX;
    breakaway_learning_q31_step(&x->params,
                                &x->state,
                                direction,
                                units < most ? units : most,
                                (uint32_t)parts_units(prior),
                                parts_units(measured));
    x->state.slid |= (uint8_t)(units > 0u);
}

/// `travel` as a step can take it.
static inline double learning_travel_of(double travel)
{
    return parts_force(parts_units(travel));
}

static inline void learning_slide_ends(learning_t *x, uint32_t direction, double prior)
{
    tribo_breakaway_learning_q31_slide_ends(&x->params, &x->state, direction, (uint32_t)parts_units(prior));
}

static inline void learning_change_side(learning_t *x)
{
    tribo_breakaway_learning_q31_change_side(&x->state);
}

static inline void learning_restore(learning_t *x)
{
    tribo_breakaway_learning_q31_restore(&x->state);
}

static inline double learning_travel(const learning_t *x, uint32_t direction)
{
    return parts_force((int64_t)x->state.travel[direction]);
}

static inline void learning_forget_travel(learning_t *x, uint32_t direction)
{
    x->state.travel[direction] = 0;
}

/// Scale and offset of `direction`, in prior standard deviations.
static inline double learning_scale(const learning_t *x, uint32_t direction)
{
    return x->state.of[direction].scale / 268435456.0;
}

static inline double learning_offset(const learning_t *x, uint32_t direction)
{
    return x->state.of[direction].offset / 268435456.0;
}

static inline void learning_set(learning_t *x, uint32_t direction, double scale, double offset)
{
    x->state.of[direction].scale  = (int32_t)lround(scale * 268435456.0);
    x->state.of[direction].offset = (int32_t)lround(offset * 268435456.0);
}

/// Adds `by`, in prior standard deviations, to the scale of `direction`.
static inline void learning_add_scale(learning_t *x, uint32_t direction, double by)
{
    x->state.of[direction].scale += (int32_t)lround(by * 268435456.0);
}

/// The largest offset below its bound, as learning_set takes it.
static inline double learning_last_offset(void)
{
    return 3.0 - 1.0 / 268435456.0;
}

/// What the variance of a scale is on a side of F = 0 that is taken over, `ss` on the other.
static inline int32_t learning_apart(const learning_t *x, int32_t ss)
{
    (void)x;
    return ss + BREAKAWAY_LEARNING_Q31_ONE / 4;
}

/// What is known on a side of F = 0, each number its own; the scales are of one `sign`, their variances `variance` prior ones.
static inline learning_side_t learning_numbers(const learning_t *x, int32_t sign, double variance)
{
    (void)x;
    const int32_t   ss   = (int32_t)lround(variance * BREAKAWAY_LEARNING_Q31_ONE);
    learning_side_t side = {.travel = {0}};
    for (int32_t d = 0; d < 2; d++)
    {
        side.of[d]         = (tribo_breakaway_learned_q31_t){sign * (1 << 28) + d,
                                                             20 * sign + d,
                                                             ss + d,
                                                             50 * sign + d,
                                                             60 + sign + 2 * d};
        side.shared[d]     = 30 * sign + d;
        side.shared[2 + d] = 40 * sign + d;
        side.travel[d]     = sign > 0 ? 8u + (uint32_t)d : 4u + (uint32_t)d;
    }
    return side;
}

/// The side of F = 0 that learning is on.
static inline learning_side_t learning_side(const learning_t *x)
{
    learning_side_t side = {.travel = {0}};
    for (uint32_t d = 0; d < 2u; d++)
    {
        side.of[d]          = x->state.of[d];
        side.shared[d]      = x->state.shared[d];
        side.shared[2u + d] = x->state.shared[2u + d];
        side.travel[d]      = x->state.travel[d];
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
        x->state.travel[d]      = side->travel[d];
    }
}

// --- guard ---------------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_guard_q31_params_t params;
    tribo_guard_q31_state_t  state;
} guard_t;

static inline tribo_status_t guard_init(guard_t *x, const tribo_guard_f32_config_t *config, double h)
{
    if (x != NULL)
    {
        tribo_guard_q31_reset(&x->state);
    }
    return tribo_guard_q31_init(x != NULL ? &x->params : NULL, config, (float)h, (float)PARTS_FULL_SCALE_N);
}

/// Returns the fade of friction, 1 to 0.
static inline double guard_step(guard_t *x, double r, double y, double f)
{
    return tribo_guard_q31_step(&x->params, &x->state, parts_q31(r), parts_q31(y), parts_q31(f), true) / 4294967295.0;
}

static inline void guard_restore(guard_t *x)
{
    tribo_guard_q31_restore(&x->state);
}

// --- LuGre friction ------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_lugre_q31_params_t     params;
    tribo_friction_q31_params_t  friction;
    tribo_lugre_q31_state_t      state;
    tribo_friction_q31_signals_t seen;
    tribo_breakaway_point_q31_t  table[TRIBO_BREAKAWAY_POINTS_MAX];
} lugre_t;

static inline void lugre_reset(lugre_t *x)
{
    tribo_lugre_q31_reset(&x->state);
}

static inline tribo_status_t lugre_init(lugre_t                           *x,
                                        const tribo_lugre_f32_config_t    *config,
                                        const tribo_arm_f32_config_t      *arm,
                                        const tribo_friction_f32_config_t *law,
                                        double                             h)
{
    lugre_reset(x);
    const tribo_status_t status = tribo_lugre_q31_init(&x->params, config, arm, (float)h);
    return status != TRIBO_OK
               ? status
               : tribo_friction_q31_init(&x->friction, x->table, law, (float)h, (float)PARTS_FULL_SCALE_N);
}

/// Returns f.
static inline double lugre_step(lugre_t *x, double u, double F)
{
    return parts_from_q31(
        tribo_lugre_q31_step(&x->params, &x->friction, &x->state, parts_q31(u), parts_q31(F), &x->seen));
}

static inline double lugre_n(const lugre_t *x)
{
    return parts_from_q31(x->seen.n);
}

static inline double lugre_L(const lugre_t *x)
{
    return parts_from_q31(x->seen.L);
}

/// Force of the bristles, and the drive that the arm had last.
static inline double lugre_bristle(const lugre_t *x)
{
    return parts_from_q31(x->state.bristle);
}

static inline double lugre_drive(const lugre_t *x)
{
    return parts_from_q31(x->state.drive);
}

static inline void lugre_set(lugre_t *x, double bristle, double drive)
{
    x->state.bristle = parts_q31(bristle);
    x->state.drive   = parts_q31(drive);
}

#endif
