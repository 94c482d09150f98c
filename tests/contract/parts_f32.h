// The f32 parts as the contract suite sees them: physical units in double.

#ifndef TESTS_CONTRACT_PARTS_F32_H
#define TESTS_CONTRACT_PARTS_F32_H

#include "arm_f32.h"
#include "cascade_f32.h"
#include "loop/guard_f32.h"
#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/friction_f32.h"

#include <stdbool.h>
#include <stddef.h>

#define CASCADE_ROUNDING 1e-6 // of a node
#define GUARD_ROUNDING   1e-6 // of the fade

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
    return tribo_biquad_f32_init(&x->params, sections, count, NULL);
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
    guard_play_reset(&x->state, (float)position);
}

static inline void play_step(play_t *x, double input, double half)
{
    guard_play_step(&x->state, (float)input, (float)half);
}

static inline double play_position(const play_t *x)
{
    return (double)x->state.position_n;
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

#endif
