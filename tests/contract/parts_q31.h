// The Q31 parts as the contract suite sees them: physical units in double, at a full scale of 2 N.

#ifndef TESTS_CONTRACT_PARTS_Q31_H
#define TESTS_CONTRACT_PARTS_Q31_H

#include "arm_q31.h"
#include "cascade_q31.h"
#include "loop/guard_q31.h"
#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/friction_q31.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#define PARTS_FULL_SCALE_N 2.0
#define PARTS_UNIT_N       (PARTS_FULL_SCALE_N / 536870912.0)
#define CASCADE_ROUNDING   1e-6 // of a node
#define GUARD_ROUNDING     1e-6 // of the fade

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

// --- play ----------------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_play_q31_state_t state;
} play_t;

static inline void play_reset(play_t *x, double position)
{
    guard_play_reset(&x->state, parts_units(position));
}

static inline void play_step(play_t *x, double input, double half)
{
    guard_play_step(&x->state, parts_units(input), parts_units(half));
}

static inline double play_position(const play_t *x)
{
    return parts_force(x->state.position);
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

#endif
