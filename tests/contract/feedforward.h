// The feed-forward as the contract suite sees it, in the arithmetic of arith_f32.h or arith_q31.h: physical units in double.

#ifndef TESTS_CONTRACT_FEEDFORWARD_H
#define TESTS_CONTRACT_FEEDFORWARD_H

#include ARITH_HEADER

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if TRIBO_IS_Q31
#define FEEDFORWARD_ONE 536870912.0  // of numbers without unit
#define FEEDFORWARD_ALL 4294967296.0 // of fractions
typedef uint32_t feedforward_fraction_t;
#else
#define FEEDFORWARD_ONE 1.0
#define FEEDFORWARD_ALL 1.0
typedef float feedforward_fraction_t;
#endif

typedef struct
{
    TRIBO(force_loop, params_t) loop;
    TRIBO(feedforward, params_t) params;
    TRIBO(feedforward, memory_t) memory;
    tribo_point_t table[TRIBO_BREAKAWAY_POINTS_MAX];
    double        full_scale_n;
} feedforward_t;

/// Signals and state of a tick, in N.
typedef struct
{
    double   e, lin, f, lead, b, term, sigma, z, reached;
    double   weight[TRIBO_FEEDFORWARD_WEIGHTS], constant, scale, doubt, travel; // learned
    double   sliding, use[TRIBO_FEEDFORWARD_WEIGHTS], trust;                    // used
    unsigned mode, phase;
    uint32_t late, forgotten;
} feedforward_seen_t;

static inline double feedforward_force(const feedforward_t *x, tribo_force_t force) // of its inside
{
    return inner_n(force, x->full_scale_n);
}

static inline tribo_force_t feedforward_of(const feedforward_t *x, double force)
{
    return tribo_force_of_n(force, x->full_scale_n);
}

static inline void feedforward_reset(feedforward_t *x)
{
    TRIBO(feedforward, reset)(&x->memory.state);
}

static inline void feedforward_restart(feedforward_t *x)
{
    x->memory.state.mode = TRIBO_FEEDFORWARD_RESTART;
}

#define FORCE(value)    TRIBO_EITHER((float)(value), (int32_t)round(ldexp((value) / FULL_SCALE_N, 29)))
#define OF_FORCE(value) inner_n(value, FULL_SCALE_N)

/// A controller that none of these tests runs, for any sample time: the paper's is refused at another than its own.
static const tribo_biquad_f32_section_t feedforward_beside[] = {TRIBO_BIQUAD_F32(1.0, -0.9, 0.0, -0.95, 0.0)};

/// With a full scale `scale` times as large.
static inline tribo_status_t feedforward_init_scaled(feedforward_t                        *x,
                                                     const tribo_feedforward_f32_config_t *config,
                                                     const tribo_compensator_f32_config_t *model,
                                                     double                                input_max,
                                                     double                                h,
                                                     double                                scale)
{
    tribo_force_loop_f32_config_t loop = tribo_force_loop_f32_paper();
    loop.compensator                   = *model;
    loop.input_max_n                   = (float)input_max;
    loop.usual_force_n                 = 0.25f * (float)input_max;
    loop.sample_time_s                 = (float)h;
    loop.controller.sections           = feedforward_beside;
    loop.controller.section_count      = 1;
    *x                                 = (feedforward_t){.full_scale_n = FULL_SCALE_N * scale};
    const tribo_status_t status =
        tribo_init_feedforward(&x->loop, x->table, &x->params, &loop, config, (float)x->full_scale_n);
    feedforward_reset(x);
    return status;
}

/// Copies `from`, whose params must not be copied alone: the loop's point to them.
static inline void feedforward_copy(feedforward_t *to, const feedforward_t *from)
{
    *to             = *from;
    to->loop.method = &to->params.method;
}

static inline TRIBO(force_loop, functions_t) feedforward_functions(void)
{
    TRIBO(force_loop, functions_t) functions;
    TRIBO(feedforward, method)(&functions);
    return functions;
}

static inline double feedforward_before_shared(feedforward_t *x, double r, double y, double share)
{
    const feedforward_fraction_t fade = share >= 1.0 ? TRIBO_ALL : (feedforward_fraction_t)(share * FEEDFORWARD_ALL);
    const tribo_force_t          e =
        feedforward_functions().error(&x->loop, &x->memory, feedforward_of(x, r), feedforward_of(x, y), fade);
    return tribo_force_n(e, x->full_scale_n);
}

static inline double feedforward_before(feedforward_t *x, double r, double y)
{
    return feedforward_before_shared(x, r, y, 1.0);
}

static inline double feedforward_added(feedforward_t *x, double v)
{
    return tribo_force_n(feedforward_functions().term(&x->loop, &x->memory, feedforward_of(x, v)), x->full_scale_n);
}

/// The end of a tick whose sample nobody has learned from yet.
static inline void feedforward_after_alone(feedforward_t *x, double v, double u, bool limited)
{
    TRIBO(force_loop, signals_t) signals = {.controller = {.limited = limited}};
    feedforward_functions().after(&x->loop, &x->memory, feedforward_of(x, v), feedforward_of(x, u), &signals);
}

static inline bool feedforward_learn(feedforward_t *x)
{
    return TRIBO(feedforward, learn)(&x->loop, &x->memory);
}

static inline void feedforward_after(feedforward_t *x, double v, double u, bool limited)
{
    feedforward_after_alone(x, v, u, limited);
    (void)feedforward_learn(x);
}

/// The next tick, of a controller that runs already, adds `term`.
static inline void feedforward_enter(feedforward_t *x, double term, bool anew)
{
    feedforward_functions().enter(&x->memory, feedforward_of(x, term), anew);
}

static inline bool feedforward_holds(const feedforward_t *x)
{
    return x->memory.state.mode == TRIBO_FEEDFORWARD_HOLD;
}

/// Bit by bit, also of floats.
static inline bool feedforward_is_same(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

/// What was learned is the same.
static inline bool feedforward_knows_the_same(const feedforward_t *a, const feedforward_t *b)
{
    const tribo_feedforward_learner_t *p = &a->memory.state.learner;
    const tribo_feedforward_learner_t *q = &b->memory.state.learner;
    return feedforward_is_same(p->a, q->a, sizeof p->a) && feedforward_is_same(p->P, q->P, sizeof p->P) &&
           p->seal == q->seal;
}

static inline feedforward_seen_t feedforward_seen(const feedforward_t *x)
{
    const TRIBO(feedforward, state_t) *state     = &x->memory.state;
    const tribo_feedforward_learner_t  *learner  = &state->learner;
    const tribo_feedforward_learning_t *learning = &x->params.learning;

    feedforward_seen_t seen = {.e         = feedforward_force(x, state->e),
                               .lin       = feedforward_force(x, state->lin),
                               .f         = feedforward_force(x, state->f),
                               .lead      = feedforward_force(x, state->lead),
                               .b         = feedforward_force(x, state->b),
                               .term      = tribo_force_n(state->tick.TRIBO_N(term), x->full_scale_n),
                               .sigma     = (double)state->sigma / FEEDFORWARD_ONE,
                               .z         = feedforward_force(x, state->friction),
                               .reached   = feedforward_force(x, state->reached),
                               .constant  = (double)(learning->deviation[3] * learner->a[3]),
                               .scale     = (double)(learning->deviation[4] * learner->a[4]),
                               .doubt     = (double)learner->doubt,
                               .travel    = (double)learner->travel_n,
                               .sliding   = (double)state->weights.sliding / FEEDFORWARD_ONE,
                               .trust     = (double)state->weights.trust / FEEDFORWARD_ALL,
                               .mode      = state->mode,
                               .phase     = state->phase,
                               .late      = state->late,
                               .forgotten = state->forgotten + learner->forgotten};
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_WEIGHTS; j++)
    {
        seen.weight[j] = (j == 0u ? 1.0 : 0.0) + (double)(learning->deviation[j] * learner->a[j]);
        seen.use[j]    = (double)state->weights.use[j] / FEEDFORWARD_ONE;
    }
    return seen;
}

/// What learning may not move: the sum, before b has faded.
static inline double feedforward_sum(const feedforward_t *x)
{
    const TRIBO(feedforward, state_t) *state = &x->memory.state;
    const double leak                        = (double)x->params.leak_part / FEEDFORWARD_ALL;
    return feedforward_force(x, state->f) + feedforward_force(x, state->own_load) -
           feedforward_force(x, state->b) / (1.0 - leak);
}

static inline tribo_feedforward_learned_t feedforward_learned(const feedforward_t *x, uint32_t direction, double force)
{
    return TRIBO(feedforward, learned)(&x->loop, &x->memory.state, direction, feedforward_of(x, force));
}

/// Sets V_0 as if it had been learned.
static inline void feedforward_set_sliding(feedforward_t *x, double V)
{
    tribo_feedforward_learner_t *const learner = &x->memory.state.learner;

    learner->a[0]        = (float)(V - 1.0) / x->params.learning.deviation[0];
    learner->breakaway_n = x->params.learning.breakaway_n;
    learner->rig         = x->params.learning.rig;
    uint32_t words[offsetof(tribo_feedforward_learner_t, seal) / sizeof(uint32_t)];
    memcpy(words, learner, sizeof words);
    learner->seal = UINT32_MAX;
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
    {
        learner->seal ^= words[i];
    }
}

static inline void feedforward_set_offset(feedforward_t *x, double b)
{
    x->memory.state.b = FORCE(b);
    memcpy(&x->memory.state.offset_seal, &x->memory.state.b, sizeof x->memory.state.offset_seal);
    x->memory.state.offset_seal = ~x->memory.state.offset_seal;
}

static inline void feedforward_flip_bit(void *number, unsigned bit)
{
    uint32_t bits;
    memcpy(&bits, number, sizeof bits);
    bits ^= 1u << bit;
    memcpy(number, &bits, sizeof bits);
}

#endif
