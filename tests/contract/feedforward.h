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
typedef int32_t  feedforward_number_t;
typedef uint32_t feedforward_fraction_t;
#else
#define FEEDFORWARD_ONE 1.0
#define FEEDFORWARD_ALL 1.0
typedef float feedforward_number_t;
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
    double   e, lin, f, lead, b, term, sigma, z, travel, reached;
    double   weight[1u + TRIBO_FEEDFORWARD_STOPS], constant, slope, doubt, margin;
    unsigned mode, stage;
    uint32_t forgotten;
} feedforward_seen_t;

static inline double feedforward_force(const feedforward_t *x, tribo_force_t force) // of its inside
{
    return TRIBO_LEARNED_N(double, force, x->full_scale_n);
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

// Numbers of lib, which in fixed point have a format of `q` bits behind the point.

static inline feedforward_number_t to(double value, int q)
{
    (void)q;
    return TRIBO_EITHER((float)value, (int32_t)fmin(2147483647.0, round(ldexp(value, q))));
}

static inline double from(double number, int q)
{
    (void)q;
    return TRIBO_EITHER(number, ldexp(number, -q));
}

#define FORCE(value)    to((value) / TRIBO_EITHER(1.0, FULL_SCALE_N), 29)
#define OF_FORCE(value) (from((double)(value), 29) * TRIBO_EITHER(1.0, FULL_SCALE_N))
#define PART(value, q)  TRIBO_EITHER((float)(value), (uint32_t)fmin(4294967295.0, round(ldexp(value, q))))
#define NOISE(value)    TRIBO_EITHER((float)(value), (uint32_t)round(ldexp((value) / FULL_SCALE_N, 37)))
#define OF_NOISE(value) (from((double)(value), 37) * TRIBO_EITHER(1.0, FULL_SCALE_N))

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

static inline void feedforward_after(feedforward_t *x, double v, double u, bool limited)
{
    TRIBO(force_loop, signals_t) signals = {.controller = {.limited = limited}};
    feedforward_functions().after(&x->loop, &x->memory, feedforward_of(x, v), feedforward_of(x, u), &signals);
}

/// The next tick, of a controller that runs already, adds `term`.
static inline void feedforward_enter(feedforward_t *x, double term, bool anew)
{
    feedforward_functions().enter(&x->memory, feedforward_of(x, term), anew);
}

/// Keeps this tick from being learned from.
static inline void feedforward_do_not_learn(feedforward_t *x)
{
    x->memory.signals.y_good                 = false;
    x->memory.state.learning.TRIBO_N(sample) = 0;
}

static inline bool feedforward_holds(const feedforward_t *x)
{
    return x->memory.state.mode == TRIBO_FEEDFORWARD_HOLD;
}

/// Also where one is 0 and the other -0.
static inline bool same_numbers(const feedforward_number_t *a, const feedforward_number_t *b, int count)
{
    bool same = true;
    for (int i = 0; i < count; i++)
    {
        same = same && a[i] == b[i];
    }
    return same;
}

/// What was learned is the same; of mirrored forces where `mirrored`.
static inline bool feedforward_knows_the_same(const feedforward_t *a, const feedforward_t *b, bool mirrored)
{
    const TRIBO(feedforward, state_t) *p = &a->memory.state;
    TRIBO(feedforward, state_t) q        = b->memory.state;
    if (mirrored)
    {
        q.learned.TRIBO_N(constant) = -q.learned.TRIBO_N(constant);
        q.learned.slope             = -q.learned.slope;
        static const int odd[]      = {1, 2, 6, 8};
        for (int i = 0; i < 4; i++)
        {
            q.learned.covariance[odd[i]] = -q.learned.covariance[odd[i]];
        }
    }
    return same_numbers(p->learned.weight, q.learned.weight, 1 + TRIBO_FEEDFORWARD_STOPS) &&
           p->learned.TRIBO_N(constant) == q.learned.TRIBO_N(constant) && p->learned.slope == q.learned.slope &&
           p->learned.scale == q.learned.scale && same_numbers(p->learned.covariance, q.learned.covariance, 10) &&
           same_numbers(p->learned.variance, q.learned.variance, TRIBO_FEEDFORWARD_STOPS) &&
           same_numbers(p->learned.use, q.learned.use, 1 + TRIBO_FEEDFORWARD_STOPS) &&
           p->learned.doubt == q.learned.doubt && p->learned.TRIBO_N(travel) == q.learned.TRIBO_N(travel);
}

static inline feedforward_seen_t feedforward_seen(const feedforward_t *x)
{
    const TRIBO(feedforward, signals_t) *s     = &x->memory.signals;
    const TRIBO(feedforward, state_t) *state   = &x->memory.state;
    const TRIBO(feedforward_weights, t) *known = &state->learned;
    feedforward_seen_t seen = {.e         = TRIBO_EITHER((double)s->TRIBO_N(e), feedforward_force(x, s->TRIBO_N(e))),
                               .lin       = feedforward_force(x, s->TRIBO_N(lin)),
                               .f         = feedforward_force(x, s->TRIBO_N(f)),
                               .lead      = feedforward_force(x, s->TRIBO_N(lead)),
                               .b         = feedforward_force(x, state->TRIBO_N(offset)),
                               .term      = tribo_force_n(s->TRIBO_N(term), x->full_scale_n),
                               .sigma     = (double)state->sigma / FEEDFORWARD_ONE,
                               .z         = feedforward_force(x, s->TRIBO_N(friction)),
                               .travel    = TRIBO_LEARNED_N(double, s->TRIBO_N(travel), x->full_scale_n),
                               .reached   = feedforward_force(x, s->TRIBO_N(reached)),
                               .constant  = feedforward_force(x, known->TRIBO_N(constant)),
                               .slope     = (double)known->slope / FEEDFORWARD_ONE,
                               .doubt     = (double)known->doubt / TRIBO_EITHER(1.0, 4294967295.0),
                               .margin    = (double)state->hold.extra_margin / FEEDFORWARD_ALL,
                               .mode      = state->mode,
                               .stage     = state->learning.stage,
                               .forgotten = state->forgotten};
    for (uint32_t j = 0; j <= TRIBO_FEEDFORWARD_STOPS; j++)
    {
        seen.weight[j] = (double)known->weight[j] / FEEDFORWARD_ONE;
    }
    return seen;
}

/// What was learned of one direction.
typedef struct
{
    double L, relative_variance, travel;
    bool   at_bound, stays_at_bound, harms;

    uint32_t forgotten;
} feedforward_learned_t;

static inline feedforward_learned_t feedforward_learned(const feedforward_t *x, uint32_t direction, double force)
{
    const TRIBO(feedforward, learned_t) at =
        TRIBO(feedforward,
              learned)(&x->loop.compensator.friction, &x->memory.state, direction, feedforward_of(x, force));
    return (feedforward_learned_t){.L                 = TRIBO_LEARNED_N(double, at.TRIBO_N(L), x->full_scale_n),
                                   .relative_variance = TRIBO_LEARNED_RELATIVE_VARIANCE(double, at.relative_variance),
                                   .travel            = TRIBO_LEARNED_N(double, at.TRIBO_N(travel), x->full_scale_n),
                                   .at_bound          = at.at_bound,
                                   .stays_at_bound    = at.stays_at_bound,
                                   .harms             = at.harms,
                                   .forgotten         = at.forgotten};
}

/// As if the weight of stop `j` had been learned.
static inline void feedforward_set_weight(feedforward_t *x, uint32_t j, double weight)
{
    TRIBO(feedforward_weights, t) *const learned = &x->memory.state.learned;

    uint32_t before;
    uint32_t after;
    memcpy(&before, &learned->weight[j], sizeof before);
    learned->weight[j] = (feedforward_number_t)(weight * FEEDFORWARD_ONE);
    memcpy(&after, &learned->weight[j], sizeof after);
    learned->seal ^= before ^ after;
}

/// As if a bit of its memory had flipped.
static inline void feedforward_break_weight(feedforward_t *x, uint32_t j)
{
    feedforward_set_weight(x, j, 0.5);
    x->memory.state.learned.seal ^= 1u;
}

static inline void feedforward_flip_bit(void *number, unsigned bit)
{
    uint32_t bits;
    memcpy(&bits, number, sizeof bits);
    bits ^= 1u << bit;
    memcpy(number, &bits, sizeof bits);
}

static inline void feedforward_flip(void *number)
{
    feedforward_flip_bit(number, 20);
}

static inline void feedforward_break_offset(feedforward_t *x)
{
    feedforward_flip(&x->memory.state.TRIBO_N(offset));
}

#define FEEDFORWARD_SCRATCH 12u ///< numbers of a sample that are sealed

/// As if this bit of a sample's number had flipped. Returns the stage from which on the number is sealed.
static inline unsigned feedforward_break_sample(feedforward_t *x, uint32_t number, unsigned bit)
{
    TRIBO(feedforward_learning, state_t) *const s = &x->memory.state.learning;

    static const unsigned from[4] = {1, 2, 2, 4};
    void *const           one[4]  = {&s->TRIBO_N(sample), &s->error, &s->TRIBO_N(weighing), &s->gain};
    feedforward_flip_bit(number < 4u ? one[number] : &s->gained[number - 4u], bit);
    return number < 4u ? from[number] : TRIBO_EITHER(3u, number < 8u ? 3u : 4u);
}

static inline void feedforward_set_margin(feedforward_t *x, double extra_margin)
{
    x->memory.state.hold.extra_margin = (feedforward_fraction_t)(extra_margin * FEEDFORWARD_ALL);
}

#endif
