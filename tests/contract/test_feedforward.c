// What the feed-forward promises whatever the signals: symmetry, scale, rest, bounds, no bump. It runs open loop, with made-up
// v and y, or around a plant that is a play: an arm without mass that sticks within its breakaway. On an emulated processor the
// runs are shorter: it computes the host's bits (tests/identity, tests/lock_step), so the long ones would find the same there.

#define FULL_SCALE_N 4.0 // of Q31, so that an input beyond input_max shows as such
#include "feedforward.h"
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define SEED      RUNS(0xfeedu, 0xfeed3u) // whose first ticks have all of it
#define H         1e-3
#define INPUT_MAX 2.0
#define L0        0.007 // the paper's breakaway
#define L1        0.3
#define STOP      RUNS(15000, 13000) // where a reference stops, or is no more followed

static random_t                       r;
static tribo_feedforward_f32_config_t config;
static tribo_compensator_f32_config_t model;
static feedforward_t                  x;
static feedforward_t                  other;

void setUp(void)
{
    r.state = SEED;
    config  = tribo_feedforward_f32_default();
    model   = tribo_force_loop_f32_paper().compensator;
}

static void init(feedforward_t *f)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, feedforward_init_scaled(f, &config, &model, INPUT_MAX, H, 1.0));
}

/// An arm without mass that sticks within its breakaway, actuator and sensor as in the paper, and an integrating controller.
typedef struct
{
    double positive, negative; // breakaway over the paper's
    double noise;
    double u, actuator, F, y;
    double v;
} plant_t;

static double normal(void)
{
    double sum = 0.0;
    for (int i = 0; i < 12; i++)
    {
        sum += random_between(&r, -0.5, 0.5);
    }
    return sum;
}

static double measure(const plant_t *p)
{
    return p->y + p->noise * normal();
}

static void move(plant_t *p, double u)
{
    p->u = u;
    p->actuator += 0.18 * (u - p->actuator);
    const double L = L0 + L1 * fabs(p->F);
    p->F           = fmax(p->actuator - p->positive * L, fmin(p->actuator + p->negative * L, p->F));
    p->y += 0.0535 * (p->F - p->y);
}

static double control(plant_t *p, double e)
{
    p->v += 0.02 * e;
    return p->v + 0.5 * e;
}

/// A tick of the feed-forward around the plant. Returns u.
static double tick(feedforward_t *f, plant_t *p, double reference)
{
    const double y = measure(p);
    const double v = control(p, feedforward_before(f, reference, y));
    const double u = v + feedforward_added(f, v);
    feedforward_after(f, v, u, false);
    move(p, u);
    return u;
}

static double triangle(int k)
{
    const double phase = fmod(k * H, 20.0);
    return 0.2 + 0.04 * (phase < 10.0 ? phase : 20.0 - phase);
}

/// The triangle until its reference stops.
static void run_to_stop(plant_t *p)
{
    for (int k = 0; k < STOP; k++)
    {
        (void)tick(&x, p, triangle(k));
    }
}

/// A tick with an imposed reading and a controller that does nothing. Returns u.
static double tick_alone(double reference, double y)
{
    (void)feedforward_before(&x, reference, y);
    const double u = feedforward_added(&x, 0.0);
    feedforward_after(&x, 0.0, u, false);
    return u;
}

/// A reference with everything in it: creeps, ramps, jumps, stands, swings, within +-0.9 N.
typedef struct
{
    double at, slope;
    int    left;
} wanderer_t;

static double wander(wanderer_t *w)
{
    if (w->left == 0)
    {
        const double kind = random_between(&r, 0.0, 1.0);
        w->left           = 1 + (int)random_between(&r, 0.0, kind < 0.2 ? 3000.0 : 800.0);
        w->slope = kind < 0.2 ? 0.0 : random_between(&r, -1.0, 1.0) * pow(10.0, random_between(&r, -6.0, -3.0));
        w->at    = kind > 0.9 ? random_between(&r, -0.9, 0.9) : w->at;
    }
    w->left--;
    w->at = fmin(0.9, fmax(-0.9, w->at + w->slope));
    return w->at;
}

/// Rounds to a multiple of 2^-22 N, which is the same number in each arithmetic.
static double on_grid(double force)
{
    return round(force * 4194304.0) / 4194304.0;
}

static void test_feedforward_is_a_mirror_image_to_the_last_bit(void)
{
    plant_t    plant   = {.positive = 1.2, .negative = 0.8, .noise = 2e-4};
    wanderer_t w       = {0.0, 0.0, 0};
    double     travel  = 0.0;
    int        learned = 0;
    int        held    = 0;
    int        turns   = 0;
    init(&x);
    init(&other);
    for (int k = 0; k < RUNS(60000, 10000); k++)
    {
        if (k % 5000 == 0) // this plant's friction does harm: fed back, forward again
        {
            TRIBO(feedforward, restore)(&x.memory.state);
            TRIBO(feedforward, restore)(&other.memory.state);
        }
        const double reference = on_grid(wander(&w));
        const double y         = on_grid(measure(&plant));
        const double e         = feedforward_before(&x, reference, y);
        TEST_ASSERT_TRUE(feedforward_before(&other, -reference, -y) == -e);
        const double v     = on_grid(control(&plant, e));
        const double added = feedforward_added(&x, v);
        TEST_ASSERT_TRUE(feedforward_added(&other, -v) == -added);
        const double wanted = on_grid(v + added);
        const double u      = fmin(0.875, fmax(-0.875, wanted));
        plant.v += u - wanted; // anti-windup
        feedforward_after(&x, v, u, u != wanted);
        feedforward_after(&other, -v, -u, u != wanted);
        const feedforward_seen_t a = feedforward_seen(&x);
        const feedforward_seen_t b = feedforward_seen(&other);
        TEST_ASSERT_TRUE(a.f == -b.f && a.b == -b.b && a.z == -b.z && a.sigma == -b.sigma && a.travel == b.travel);
        TEST_ASSERT_TRUE(feedforward_is_same(a.weight, b.weight, sizeof a.weight) && a.constant == -b.constant &&
                         a.scale == b.scale);
        TEST_ASSERT_TRUE(feedforward_is_same(a.use, b.use, sizeof a.use) && a.doubt == b.doubt);
        learned += a.travel > travel;
        travel = a.travel;
        held += feedforward_holds(&x);
        turns += a.sigma != 0.0 && fabs(a.sigma) < 1.0;
        move(&plant, u);
    }
    printf("%d ticks learned, %d held, %d turned\n", learned, held, turns);
    TEST_ASSERT_TRUE(learned > RUNS(900, 100) && held > RUNS(1000, 100) &&
                     turns > RUNS(100, 10)); // all of it was there
}

/// All forces of the model times 2; those of the config are derived.
static void double_forces(void)
{
    model.friction.positive.offset_n *= 2.0f;
    model.friction.negative.offset_n *= 2.0f;
    model.arm.inertia *= 2.0f;
    model.arm.damping *= 2.0f;
    model.arm.stiffness *= 2.0f;
}

/// To the last bit, but for what is too small for all of a float's.
static bool is_twice(double twice, double force)
{
    return twice == 2.0 * force || fabs(twice) < 1e-36;
}

static void test_feedforward_of_forces_twice_as_large_gives_forces_twice_as_large(void)
{
    plant_t    plant   = {.positive = 1.3, .negative = 0.7, .noise = 2e-4};
    wanderer_t w       = {0.0, 0.0, 0};
    double     travel  = 0.0;
    int        learned = 0;
    init(&x);
    double_forces();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, feedforward_init_scaled(&other, &config, &model, 2.0 * INPUT_MAX, H, 2.0));
    for (int k = 0; k < RUNS(80000, 8000); k++)
    {
        const double reference = on_grid(wander(&w));
        const double y         = on_grid(measure(&plant));
        const double e         = feedforward_before(&x, reference, y);
        TEST_ASSERT_TRUE(is_twice(feedforward_before(&other, 2.0 * reference, 2.0 * y), e));
        const double v     = on_grid(control(&plant, e));
        const double added = feedforward_added(&x, v);
        TEST_ASSERT_TRUE(is_twice(feedforward_added(&other, 2.0 * v), added));
        const double u = on_grid(v + added);
        feedforward_after(&x, v, u, false);
        feedforward_after(&other, 2.0 * v, 2.0 * u, false);
        learned += feedforward_seen(&x).travel > travel;
        travel = feedforward_seen(&x).travel;
        TEST_ASSERT_TRUE(is_twice(feedforward_seen(&other).z, feedforward_seen(&x).z));
        move(&plant, u);
    }
    printf("%d ticks learned\n", learned);
    TEST_ASSERT_TRUE(learned > RUNS(500, 50));
}

static void test_nothing_is_learned_and_no_friction_moves_while_r_and_y_stand(void)
{
    plant_t plant       = {.positive = 1.0, .negative = 1.0};
    config.still_time_s = 0.0f;
    init(&x);
    for (int k = 0; k < 13000; k++)
    {
        (void)tick(&x, &plant, triangle(k));
    }
    const double y = plant.y;
    for (int k = 0; k < 1000; k++)
    {
        (void)feedforward_before(&x, triangle(13000), y);
        (void)feedforward_added(&x, 0.1);
        feedforward_after(&x, 0.1, 0.5, false);
    }
    feedforward_copy(&other, &x);
    const feedforward_seen_t seen = feedforward_seen(&x);
    TEST_ASSERT_TRUE(fabs(seen.f) > 0.05);
    for (int k = 0; k < RUNS(20000, 1000); k++)
    {
        (void)feedforward_before(&x, triangle(13000), y);
        (void)feedforward_added(&x, 0.1);
        feedforward_after(&x, 0.1, 0.5, false);
        const feedforward_seen_t now = feedforward_seen(&x);
        TEST_ASSERT_TRUE(now.f == seen.f && now.sigma == seen.sigma && now.lead == 0.0);
    }
    TEST_ASSERT_TRUE(feedforward_knows_the_same(&x, &other));
}

static void test_nothing_is_learned_in_a_hold(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0, .noise = 1e-3};
    init(&x);
    run_to_stop(&plant);
    for (int k = 0; k < 2000; k++)
    {
        (void)tick(&x, &plant, triangle(STOP));
    }
    TEST_ASSERT_TRUE(feedforward_holds(&x));
    feedforward_copy(&other, &x);
    for (int k = 0; k < RUNS(10000, 1000); k++)
    {
        (void)tick(&x, &plant, triangle(STOP));
        TEST_ASSERT_TRUE(feedforward_holds(&x));
    }
    TEST_ASSERT_TRUE(feedforward_knows_the_same(&x, &other));
}

/// A sample of the triangle's slide is about to be exchanged: the next tick does.
static void run_to_exchange(plant_t *p)
{
    init(&x);
    for (int k = 0; k < STOP || feedforward_seen(&x).phase != 9u; k++)
    {
        (void)tick(&x, p, triangle(k));
    }
}

/// A twin keeps the values from before it learned: u is the same in the next tick, except for the motion of r.
static void test_learning_does_not_move_u(void)
{
    plant_t plant   = {.positive = 1.5, .negative = 0.5, .noise = 2e-4};
    double  worst   = 0.0;
    double  at_once = 0.0;
    int     learned = 0;
    init(&x);
    for (int k = 0; k < RUNS(15000, 4000); k++)
    {
        const double y = measure(&plant);
        const double v = control(&plant, feedforward_before(&x, triangle(k), y));
        const double u = v + feedforward_added(&x, v);
        feedforward_copy(&other, &x);
        other.memory.state.exchange.owner = TRIBO_FEEDFORWARD_OWNER_LEARNER; // still at work
        feedforward_after(&x, v, u, false);
        feedforward_after_alone(&other, v, u, false);
        if (feedforward_seen(&x).phase == 0u)
        {
            const double sum = feedforward_sum(&x);
            at_once          = fmax(at_once, fabs(sum - feedforward_sum(&other)));
            static feedforward_t next; // the tick after it, as it will be
            feedforward_copy(&next, &x);
            (void)feedforward_before(&next, triangle(k + 1), y);
            (void)feedforward_before(&other, triangle(k + 1), y);
            // A ramp goes on with what was learned: neither is in one.
            if (fabs(feedforward_seen(&next).sigma) == 1.0 && feedforward_seen(&next).lead == 0.0)
            {
                worst = fmax(worst, fabs(feedforward_added(&next, v) - feedforward_added(&other, v)));
                learned += feedforward_seen(&next).sliding != feedforward_seen(&other).sliding;
            }
        }
        move(&plant, u);
    }
    printf("u moves by up to %.1e N as something is learned, %.1e N in the next tick, %d times\n",
           at_once,
           worst,
           learned);
    TEST_ASSERT_TRUE(learned > RUNS(1000, 250));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, at_once);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.0, worst); // L and the stops move on with r, by a 143rd of the narrow one's width
}

/// The learner comes a tick, or nine, after the sample: the result is taken in the tenth all the same, to the last bit.
static void test_a_result_is_taken_10_ticks_after_its_sample(void)
{
    for (int late = 1; late < 10; late++)
    {
        plant_t plant = {.positive = 1.3, .negative = 0.8, .noise = 2e-4};
        init(&x);
        init(&other);
        for (int k = 0; k < RUNS(12000, 4000); k++)
        {
            const double y = measure(&plant);
            const double e = feedforward_before(&x, triangle(k), y);
            const double v = control(&plant, e);
            TEST_ASSERT_TRUE(feedforward_before(&other, triangle(k), y) == e);
            const double u = v + feedforward_added(&x, v);
            TEST_ASSERT_TRUE(v + feedforward_added(&other, v) == u);
            const double before = feedforward_seen(&x).sliding;
            feedforward_after(&x, v, u, false);
            feedforward_after_alone(&other, v, u, false);
            TEST_ASSERT_TRUE(feedforward_seen(&x).phase == 0u || feedforward_seen(&x).sliding == before);
            if (feedforward_seen(&other).phase == (unsigned)late)
            {
                (void)feedforward_learn(&other);
            }
            move(&plant, u);
        }
        TEST_ASSERT_TRUE(feedforward_seen(&x).sliding != 1.0 &&
                         feedforward_seen(&x).sliding == feedforward_seen(&other).sliding);
        TEST_ASSERT_EQUAL_UINT32(0, feedforward_seen(&other).late);
    }
}

/// A background that comes round every 35 ticks, and one that never does.
static void test_late_learning_is_counted_and_harmless(void)
{
    for (int every = 0; every <= 35; every += 35)
    {
        plant_t plant = {.positive = 1.0, .negative = 1.0};
        double  worst = 0.0;
        init(&x);
        for (int k = 0; k < RUNS(40000, 24000); k++)
        {
            const double v = control(&plant, feedforward_before(&x, triangle(k), measure(&plant)));
            const double u = v + feedforward_added(&x, v);
            feedforward_after_alone(&x, v, u, false);
            if (every > 0 && k % every == 0)
            {
                TEST_ASSERT_TRUE(feedforward_learn(&x) || k == 0);
                TEST_ASSERT_FALSE(feedforward_learn(&x)); // nothing left
            }
            move(&plant, u);
            worst = k > RUNS(25000, 12000) ? fmax(worst, fabs(plant.F - triangle(k))) : worst;
        }
        const feedforward_seen_t seen = feedforward_seen(&x);
        printf("learned every %d ticks: %u late, V_0 %.3f, error up to %.2f mN\n",
               every,
               (unsigned)seen.late,
               seen.sliding,
               1e3 * worst);
        TEST_ASSERT_EQUAL_UINT32(seen.late, feedforward_learned(&x, 0, 0.3).late);
        if (every == 0)
        {
            TEST_ASSERT_UINT32_WITHIN(2, RUNS(4000, 2400), seen.late);
            TEST_ASSERT_TRUE(seen.sliding == 1.0 && seen.trust < 0.51); // the prior, half of it
        }
        else
        {
            TEST_ASSERT_TRUE(seen.late > RUNS(2000, 1200) && seen.late < RUNS(3200, 1900));
            TEST_ASSERT_DOUBLE_WITHIN(0.05, 1.0, seen.sliding);
        }
        TEST_ASSERT_TRUE(worst < 0.03);
    }
}

static void test_only_a_loop_with_the_feedforward_learns(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    run_to_exchange(&plant);
    const double v = control(&plant, feedforward_before(&x, triangle(STOP), measure(&plant)));
    feedforward_after_alone(&x, v, v + feedforward_added(&x, v), false);
    TEST_ASSERT_TRUE(TRIBO(feedforward, is_learning)(&x.memory.state));
    const TRIBO(force_loop, params_t) paper = {.method = NULL};
    TEST_ASSERT_FALSE(TRIBO(feedforward, learn)(&paper, &x.memory));
    TEST_ASSERT_TRUE(feedforward_learn(&x));
    TEST_ASSERT_FALSE(TRIBO(feedforward, is_learning)(&x.memory.state));
}

static void test_a_bad_reading_gives_no_error_and_teaches_nothing(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    run_to_exchange(&plant);
    feedforward_copy(&other, &x);
    for (int i = 0; i < 2; i++)
    {
        feedforward_t *const f = i == 0 ? &x : &other;
        const double         e = feedforward_before(f, triangle(STOP), i == 0 ? (double)NAN : plant.y);
        TEST_ASSERT_TRUE(i == 1 || e == 0.0);
        (void)feedforward_added(f, plant.v);
        feedforward_after(f, plant.v, plant.u, false);
    }
    TEST_ASSERT_TRUE(feedforward_seen(&other).travel > feedforward_seen(&x).travel);
    // A bad reference counts as the last one.
    (void)feedforward_before(&other, 3.0, plant.y);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, triangle(STOP), feedforward_seen(&other).reached);
}

/// Compares with a state that got the learned values and nothing else.
static void test_a_restart_leaves_nothing_behind_but_what_was_learned(void)
{
    for (int enters = 0; enters < 2; enters++)
    {
        plant_t plant = {.positive = 1.4, .negative = 0.6, .noise = 1e-3};
        init(&x);
        for (int k = 0; k < STOP + 4000 + 250 * enters; k++) // in a hold, or while r moves
        {
            const double noise = random_between(&r, -2e-4, 2e-4);
            (void)tick(&x, &plant, k < STOP || enters ? triangle(k) + noise : triangle(STOP));
        }
        init(&other);
        TRIBO(feedforward, state_t) *const fresh = &other.memory.state;
        fresh->learner                           = x.memory.state.learner;
        fresh->weights                           = x.memory.state.weights;
        fresh->exchange                          = x.memory.state.exchange;
        x.memory.state.limited                   = triangle(3000) > plant.y ? 1 : -1; // what the run may not have left
        x.memory.state.error                     = FORCE(0.1);
        x.memory.state.still                     = 3;
        x.memory.state.quick                     = 3;
        feedforward_restart(&x);
        if (enters)
        {
            feedforward_enter(&x, 0.0625, true);
            feedforward_enter(&other, 0.0625, true);
        }
        plant_t twin = plant;
        for (int k = 0; k < 9000; k++)
        {
            const double   reference = triangle(k < 6000 ? k + 3000 : 9000);
            const random_t seed      = r;
            (void)tick(&x, &plant, reference);
            r = seed;
            (void)tick(&other, &twin, reference);
            const feedforward_seen_t a = feedforward_seen(&x);
            const feedforward_seen_t b = feedforward_seen(&other);
            TEST_ASSERT_TRUE(a.e == b.e && a.f == b.f && a.lead == b.lead && a.term == b.term && a.mode == b.mode);
            TEST_ASSERT_TRUE(a.z == b.z && a.travel == b.travel && a.b == b.b);
            TEST_ASSERT_TRUE(x.memory.state.error == fresh->error);
        }
        TEST_ASSERT_TRUE(feedforward_knows_the_same(&x, &other));
    }
}

/// Any bit of the learned values flips: they are forgotten with the next sample, that is counted, and u goes on.
static void test_a_flipped_bit_of_what_is_learned_is_forgotten_and_u_goes_on(void)
{
    static feedforward_t sound;
    plant_t              plant = {.positive = 1.3, .negative = 1.3};
    run_to_exchange(&plant);
    feedforward_copy(&sound, &x);
    tribo_feedforward_learner_t *const learner = &x.memory.state.learner;
    for (uint32_t i = 0; i < 24u; i++)
    {
        for (unsigned bit = 0; bit < 32u; bit += RUNS(3u, 7u))
        {
            plant_t arm = plant;
            feedforward_copy(&x, &sound);
            float *const number = i < 5u     ? &learner->a[i]
                                  : i < 20u  ? &learner->P[i - 5u]
                                  : i == 20u ? &learner->doubt
                                  : i == 21u ? &learner->travel_n
                                             : &learner->breakaway_n;
            feedforward_flip_bit(i < 23u ? (void *)number : &learner->rig, bit);
            double last = arm.u;
            for (int n = 0; n < 30; n++)
            {
                const double u = tick(&x, &arm, triangle(STOP + n));
                TEST_ASSERT_DOUBLE_WITHIN(2e-3, last, u);
                last = u;
            }
            TEST_ASSERT_EQUAL_UINT32(1, feedforward_seen(&x).forgotten);
            TEST_ASSERT_TRUE(feedforward_seen(&x).travel < 0.01 && feedforward_learned(&x, 0, 0.3).forgotten == 1u);
        }
    }
}

/// A tick around the plant, of a command within +-2 N. Returns u.
static double tick_limited(feedforward_t *f, plant_t *p, double reference)
{
    const double v      = control(p, feedforward_before(f, reference, measure(p)));
    const double wanted = v + feedforward_added(f, v);
    const double u      = fmin(INPUT_MAX, fmax(-INPUT_MAX, wanted));
    feedforward_after(f, v, u, u != wanted);
    move(p, u);
    return u;
}

/// A bit of the tick's copy of them flips: u moves with it for at most 10 ticks, and the learned values come back.
static void test_a_flipped_bit_of_what_the_tick_uses_lasts_10_ticks(void)
{
    static feedforward_t sound;
    plant_t              plant = {.positive = 1.3, .negative = 1.3};
    run_to_exchange(&plant);
    feedforward_copy(&sound, &x);
    const uint32_t words = sizeof(TRIBO(feedforward, weights_t)) / 4u;
    for (uint32_t i = 0; i < words; i++)
    {
        for (unsigned bit = 0; bit < 32u; bit += RUNS(3u, 7u))
        {
            plant_t arm = plant;
            feedforward_copy(&x, &sound);
            uint32_t *const word = (uint32_t *)(void *)&x.memory.state.weights + i;
            feedforward_flip_bit(word, bit);
            x.memory.state.exchange.owner = TRIBO_FEEDFORWARD_OWNER_TICK; // there is no result that would heal it
            for (int n = 0; n < 25; n++)
            {
                TEST_ASSERT_TRUE(isfinite(tick_limited(&x, &arm, triangle(STOP + n))));
            }
            TEST_ASSERT_TRUE(feedforward_seen(&x).forgotten >= 1u);
            TEST_ASSERT_DOUBLE_WITHIN(0.02, feedforward_seen(&sound).sliding, feedforward_seen(&x).sliding);
        }
    }
}

/// A bit of a sample or of a result flips on its way: the sum stays a sum of forces, and learned values stay within a step.
static void test_a_flipped_bit_between_tick_and_learner_is_harmless(void)
{
    static feedforward_t sound;
    plant_t              plant = {.positive = 1.0, .negative = 1.0};
    run_to_exchange(&plant);
    (void)tick(&x, &plant, triangle(STOP));
    feedforward_copy(&sound, &x);
    const uint32_t words = sizeof(TRIBO(feedforward, exchange_t)) / 4u;
    for (uint32_t i = 0; i < words; i++)
    {
        for (unsigned bit = 0; bit < 32u; bit += RUNS(3u, 7u))
        {
            for (int owner = 0; owner < 3; owner++)
            {
                plant_t arm = plant;
                feedforward_copy(&x, &sound);
                x.memory.state.exchange.owner = (uint32_t)owner;
                uint32_t *const word          = (uint32_t *)(void *)&x.memory.state.exchange + i;
                feedforward_flip_bit(word, bit);
                for (int n = 0; n < 40; n++)
                {
                    TEST_ASSERT_TRUE(fabs(tick(&x, &arm, triangle(STOP + n))) < 1.0);
                }
                TEST_ASSERT_TRUE(fabs(plant.F - triangle(STOP)) < 0.02);
            }
        }
    }
}

/// A noise with a flipped sign comes back. It made W negative, and in Q31 it stayed.
static void test_a_flipped_sign_of_the_noise_comes_back(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    for (int k = 0; k < 30000; k++)
    {
        (void)tick(&x, &plant, triangle(k));
        if (k == 1000)
        {
            feedforward_flip_bit(&x.memory.state.r_noise, 31);
            feedforward_flip_bit(&x.memory.state.y_noise, 31);
        }
    }
    TEST_ASSERT_TRUE(x.memory.state.r_noise >= 0 && x.memory.state.y_noise >= 0);
}

/// b keeps nothing that v can hold: it fades within a minute.
static void test_the_offset_comes_back(void)
{
    init(&x);
    for (int k = 0; k < 3000; k++)
    {
        (void)tick_alone(0.3 + 1e-5 * k, 0.3);
    }
    feedforward_set_offset(&x, 0.5);
    for (int k = 0; k < RUNS(60000, 12500); k++)
    {
        (void)tick_alone(0.33 + 1e-7 * k, 0.3);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.02, RUNS(0.004, 0.184), feedforward_seen(&x).b); // of 12.5 s
}

static double any_force(void)
{
    static const double odd[] = {(double)NAN,
                                 (double)INFINITY,
                                 -(double)INFINITY,
                                 (double)FLT_MAX,
                                 -(double)FLT_MAX,
                                 1e-45,
                                 2.0,
                                 -2.0,
                                 2.000001,
                                 0.0,
                                 -0.0,
                                 3.9,
                                 -3.9,
                                 1e9};
    const double        kind  = random_between(&r, 0.0, 1.0);
    return kind < 0.3 ? odd[random_bits(&r) % (sizeof odd / sizeof odd[0])] : random_between(&r, -2.0, 2.0);
}

static void test_error_friction_and_offset_are_bounded_for_any_input(void)
{
    wanderer_t w = {0.0, 0.0, 0};
    for (int set = 0; set < 2; set++)
    {
        config.trust = (float)set; // 0: friction may be weighted by nothing
        init(&x);
        for (int k = 0; k < RUNS(30000, 6000); k++)
        {
            const bool   calm = (k / RUNS(5000, 1000)) % 2 == 1;
            const double e   = feedforward_before(&x, calm ? wander(&w) : any_force(), calm ? wander(&w) : any_force());
            const double v = random_between(&r, calm ? -0.1 : -1.9, calm ? 0.1 : 1.9);
            const double add = feedforward_added(&x, v);
            feedforward_after(&x, v, random_between(&r, -2.0, 2.0), k % 3 == 0);
            const feedforward_seen_t s = feedforward_seen(&x);
            TEST_ASSERT_TRUE(fabs(e) <= 3.0 * INPUT_MAX);
            TEST_ASSERT_TRUE(fabs(s.f) <= 4.0 * (L0 + L1 * INPUT_MAX) && fabs(s.sigma) <= 1.0);
            TEST_ASSERT_TRUE(fabs(s.b) <= 4.0 * INPUT_MAX);
            TEST_ASSERT_TRUE(fabs(add) <= 20.0 * INPUT_MAX);
            TEST_ASSERT_TRUE(isfinite(s.z));
            TEST_ASSERT_TRUE(s.mode < TRIBO_FEEDFORWARD_START ||
                             (s.sliding >= 0.02 - ROUNDING && s.sliding <= 3.0 + ROUNDING));
            TEST_ASSERT_TRUE(fabs(s.constant) <= 8.0 * 0.3 * (L0 + L1 * 0.5) + ROUNDING &&
                             fabs(s.scale) <= 0.8 + ROUNDING);
            TEST_ASSERT_TRUE(s.doubt >= 0.0 && s.doubt <= 1.0);
            TEST_ASSERT_EQUAL_UINT32(0, s.forgotten);
            TEST_ASSERT_TRUE(fabs(s.weight[1]) <= 4.4 + ROUNDING && fabs(s.weight[2]) <= 4.4 + ROUNDING);
        }
    }
}

static void test_feedforward_recovers_from_any_input(void)
{
    init(&x);
    for (int k = 0; k < RUNS(10000, 2000); k++)
    {
        const double v = random_between(&r, -1.9, 1.9);
        (void)feedforward_before(&x, any_force(), any_force());
        (void)feedforward_added(&x, v);
        feedforward_after(&x, v, random_between(&r, -2.0, 2.0), k % 2 == 0);
    }
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    double  worst = 0.0;
    for (int k = 0; k < RUNS(50000, 36000); k++)
    {
        (void)tick(&x, &plant, triangle(k));
        worst = k > RUNS(40000, 30000) ? fmax(worst, fabs(plant.F - triangle(k))) : worst;
    }
    TEST_ASSERT_TRUE(worst < 0.01);
}

static void test_feedforward_after_a_reset_runs_the_same_bit_for_bit(void)
{
    static double first[5000];
    init(&x);
    for (int run = 0; run < 2; run++)
    {
        plant_t plant = {.positive = 1.2, .negative = 0.9, .noise = 1e-3};
        r.state       = SEED;
        feedforward_reset(&x);
        for (int k = 0; k < 5000; k++)
        {
            const double u = tick(&x, &plant, triangle(k));
            TEST_ASSERT_TRUE(run == 0 || u == first[k]);
            first[k] = u;
        }
    }
}

static void test_a_restart_keeps_what_was_learned_and_a_reset_forgets_it(void)
{
    plant_t plant = {.positive = 1.4, .negative = 0.6};
    init(&x);
    feedforward_copy(&other, &x);
    run_to_stop(&plant);
    static feedforward_t learned;
    feedforward_copy(&learned, &x);
    feedforward_restart(&x);
    (void)feedforward_before(&x, 0.3, 0.3);
    TEST_ASSERT_TRUE(feedforward_knows_the_same(&x, &learned));
    TEST_ASSERT_TRUE(feedforward_seen(&x).sigma == 0.0 && feedforward_seen(&x).f == 0.0);
    feedforward_reset(&x);
    TEST_ASSERT_TRUE(feedforward_knows_the_same(&x, &other));
}

/// A hold before a restart was where r creeps now: a first motion is one all the same.
static void test_a_first_motion_is_not_held_where_the_last_hold_was(void)
{
    init(&x);
    x.memory.state.still = 1000;
    feedforward_restart(&x);
    for (int k = 0; k < 400; k++)
    {
        (void)feedforward_before(&x, 0.3 + 1e-6 * k, 0.3);
        (void)feedforward_added(&x, 0.0);
        feedforward_after(&x, 0.0, 0.3, false);
        TEST_ASSERT_FALSE(feedforward_holds(&x));
    }
    TEST_ASSERT_EQUAL_UINT(TRIBO_FEEDFORWARD_MOVING, feedforward_seen(&x).mode);
}

static void test_a_hold_begins_with_nothing_counted(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    for (int k = 0; !feedforward_holds(&x); k++)
    {
        TEST_ASSERT_TRUE(k < 9000);
        x.memory.state.quick = 3;
        x.memory.state.since = 7;
        x.memory.state.side  = -1; // r rises before it stands
        x.memory.state.rests = true;
        x.memory.state.error = FORCE(1e-4);
        (void)tick(&x, &plant, triangle(k < 7000 ? k : 7000));
    }
    TEST_ASSERT_TRUE(x.memory.state.quick == 0 && x.memory.state.since <= 1u);
    TEST_ASSERT_TRUE(x.memory.state.side == 1 && !x.memory.state.rests);
}

static void test_entering_adds_what_was_added_before(void)
{
    init(&x);
    feedforward_enter(&x, 0.0625, true);
    (void)feedforward_before(&x, 0.4, 0.39);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0625, feedforward_added(&x, 0.3));
    feedforward_after(&x, 0.3, 0.3625, false);
    // And goes on from there.
    (void)feedforward_before(&x, 0.4, 0.39);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0625, feedforward_added(&x, 0.3));
}

static void test_u_does_not_jump_where_a_hold_begins_or_ends(void)
{
    plant_t plant   = {.positive = 1.1, .negative = 0.9};
    double  last    = 0.0;
    double  entry   = 0.0;
    double  leaving = 0.0;
    int     changes = 0;
    bool    before  = false;
    bool    leads   = false;
    init(&x);
    for (int k = 0; k < RUNS(50000, 18000); k++)
    {
        if (k % 8000 == 0) // this plant's friction does harm
        {
            TRIBO(feedforward, restore)(&x.memory.state);
        }
        // Ramps of 3 s, each followed by 5 s at rest; every other one goes back.
        const int    leg       = k / 8000;
        const double part      = fmin(1.0, (k % 8000) / 3000.0);
        const double from      = 0.3 + 0.15 * (leg % 3);
        const double to        = 0.3 + 0.15 * ((leg + 1) % 3);
        const double reference = from + (to - from) * part;
        const double u         = tick(&x, &plant, reference);
        const bool   holds     = feedforward_holds(&x);
        if (holds && !before && !leads) // a jump that ends early takes its lead along
        {
            entry = fmax(entry, fabs(u - last));
            changes++;
        }
        if (!holds && before)
        {
            leaving = fmax(leaving, fabs(u - last));
            changes++;
        }
        before = holds;
        leads  = feedforward_seen(&x).lead != 0.0;
        last   = u;
    }
    printf("u moves by up to %.1e N as a hold begins, %.1e N as it ends, %d changes\n", entry, leaving, changes);
    TEST_ASSERT_TRUE(changes >= RUNS(10, 3));
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, 0.0, entry);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, leaving);
}

/// Where a guard leaves no friction to choose from, a hold ends on the side to which r goes.
static void test_a_hold_that_ends_without_friction_ends_on_the_side_of_the_reference(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    int     k     = 0;
    init(&x);
    for (; !feedforward_holds(&x); k++)
    {
        TEST_ASSERT_TRUE(k < 9000);
        (void)tick(&x, &plant, triangle(k < 7000 ? k : 7000));
    }
    TEST_ASSERT_TRUE(x.memory.state.side == 1);
    for (k = 0; feedforward_holds(&x); k++)
    {
        const double reference = triangle(7000) - 1e-3 * k;
        TEST_ASSERT_TRUE(k < 100);
        feedforward_copy(&other, &x);
        (void)feedforward_before_shared(&other, reference, plant.y, 0.0);
        (void)tick(&x, &plant, reference);
    }
    TEST_ASSERT_FALSE(feedforward_holds(&other));
    TEST_ASSERT_TRUE(feedforward_seen(&other).sigma == -1.0 && feedforward_seen(&other).f == 0.0);
}

static void test_a_step_in_a_hold_is_fed_back(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    for (int k = 0; k < STOP + 5000; k++)
    {
        (void)tick(&x, &plant, triangle(k < STOP ? k : STOP));
    }
    TEST_ASSERT_TRUE(feedforward_holds(&x));
    for (int k = 0; k < 3000; k++)
    {
        (void)tick(&x, &plant, triangle(STOP) - 0.05);
        TEST_ASSERT_TRUE(feedforward_holds(&x));
    }
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, triangle(STOP) - 0.05, plant.F);
}

/// A hold does not feed back the part of a lasting error that is below the noise: u would creep until the arm slips.
static void test_of_a_lasting_error_in_a_hold_what_is_below_the_noise_is_left(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    run_to_stop(&plant);
    const double error = 0.8e-3;
    double       sum   = 0.0;
    for (int k = 0; k < 6000; k++)
    {
        const double noise = k % 2 == 0 ? 1e-3 : -1e-3; // a mean second difference of 4 mN
        (void)tick_alone(triangle(STOP), triangle(STOP) - error + noise);
        TEST_ASSERT_TRUE(k < 3000 || feedforward_holds(&x));
        sum += k < 4000 ? 0.0 : feedforward_seen(&x).e / 2000.0;
    }
    printf("of an error of %.2f mN, %.3f mN is fed back\n", 1e3 * error, 1e3 * sum);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, error - 0.04 * 4e-3, sum);
}

/// u does not move at all while the error is within the noise, even if the controller's output moves.
static void test_in_a_hold_u_rests_while_the_error_is_within_the_noise(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    run_to_stop(&plant);
    double u    = plant.actuator;
    int    rest = 0;
    for (int k = 0; k < 9000; k++)
    {
        const double noise =
            k % 2 == 0 ? 1e-3 : -1e-3; // a mean second difference of 4 mN: deadband 0.16 mN, 0.56 mN while u rests
        const double error = k < 3000 ? 0.1e-3 : k < 6000 ? 0.5e-3 : 0.8e-3;
        const double y     = k % 500 == 7 ? (double)NAN : triangle(STOP) - error + noise;
        const double v     = 1e-3 * sin(0.01 * k);
        (void)feedforward_before(&x, triangle(STOP), y);
        const double now = v + feedforward_added(&x, v);
        feedforward_after(&x, v, now, false);
        const bool rests = feedforward_holds(&x) && x.memory.state.rests;
        if (rests)
        {
            TEST_ASSERT_DOUBLE_WITHIN(1e-7, u, now);
        }
        rest += rests;
        TEST_ASSERT_TRUE(rests || k < 3000 || k >= 6000);
        TEST_ASSERT_TRUE(!rests || k < 7500);
        u = now;
    }
    printf("u rests in %d of 9000 ticks\n", rest);
    TEST_ASSERT_TRUE(rest > 5000 && rest < 7500);
}

/// The noisy reading of an arm that sticks where the reference has stopped.
static double stuck(int k)
{
    return triangle(STOP) + (k % 2 == 0 ? 1e-3 : -1e-3);
}

/// Returns the u that rests.
static double come_to_rest(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    double  u     = 0.0;
    init(&x);
    run_to_stop(&plant);
    for (int k = 0; k < 3000; k++)
    {
        u = tick_alone(triangle(STOP), stuck(k));
    }
    TEST_ASSERT_TRUE(feedforward_holds(&x) && x.memory.state.rests);
    return u;
}

/// The lead of lin before rs, without the load, which these ticks without a controller learn.
static double lead_now(void)
{
    return feedforward_seen(&x).lin - feedforward_seen(&x).reached - OF_FORCE(x.memory.state.load);
}

/// A ramp leads by tau times its rate however fast it is. Its first tick is taken for a step, and so is a step.
static void test_a_fast_ramp_is_not_a_step(void)
{
    const double tau  = 1.0 / 200.0 + 0.0075;
    const double rate = 40.0 * (L0 + L1 * 0.5); // a tick's move is three times what counts as a step
    init(&x);
    (void)tick_alone(0.2, 0.2);
    double at = 0.2;
    for (int k = 0; k < 100; k++)
    {
        at += rate * H;
        (void)tick_alone(at, at);
        TEST_ASSERT_TRUE(k > 0 || fabs(lead_now()) < 1e-6);
        TEST_ASSERT_TRUE(k < 80 || fabs(lead_now() - tau * rate) < 0.02 * tau * rate);
    }
    const double before = lead_now();
    (void)tick_alone(at - 0.5, at);
    TEST_ASSERT_TRUE(lead_now() < before && lead_now() > 0.8 * before);
}

/// A step of r ends a rest in its tick, also where y is bad, and u takes it.
static void test_a_step_of_the_reference_ends_a_rest_at_once(void)
{
    for (int i = 0; i < 4; i++)
    {
        const double step = i % 2 == 0 ? 0.02 : -0.02;
        const double u    = come_to_rest();
        const double now  = tick_alone(triangle(STOP) + step, i < 2 ? stuck(0) : (double)NAN);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 + L1 * 0.02, step, now - u); // and breakaway changes
        for (int k = 1; k < 200; k++)
        {
            (void)tick_alone(triangle(STOP) + step, stuck(k));
            TEST_ASSERT_TRUE(feedforward_holds(&x) && !x.memory.state.rests);
        }
    }
}

/// A step back does not end in a rest at what the first has left in u.
static void test_after_a_pulse_of_the_reference_u_comes_back_before_it_rests(void)
{
    static const int    ticks[] = {1, 2, 10};
    static const double steps[] = {0.02, -0.02, 0.08, -0.08};
    for (int i = 0; i < 12; i++)
    {
        const double u    = come_to_rest();
        double       left = 0.0;
        for (int k = 0; k < 4000; k++)
        {
            left = tick_alone(triangle(STOP) + (k < ticks[i % 3] ? steps[i / 3] : 0.0), stuck(k)) - u;
        }
        TEST_ASSERT_TRUE(feedforward_holds(&x) && x.memory.state.rests);
        TEST_ASSERT_DOUBLE_WITHIN(4e-3, 0.0, left); // of a step of 20 or 80
    }
}

static void test_the_first_motion_is_the_controllers_alone(void)
{
    init(&x);
    double before = 0.3;
    for (int k = 0; k < 100; k++)
    {
        const double reference = 0.3 + 1e-5 * k; // turns after 0.25 mN, far from a step
        (void)feedforward_before(&x, reference, 0.3);
        const double added = feedforward_added(&x, 0.0);
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, before, added); // no jump, though f jumps
        feedforward_after(&x, 0.0, 0.3, false);
        before = added;
    }
    const feedforward_seen_t seen = feedforward_seen(&x);
    TEST_ASSERT_TRUE(seen.sigma == 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.5 * (L0 + L1 * 0.3), seen.f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, seen.f, seen.b);
}

static void test_nothing_is_learned_while_u_is_limited(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    double travel  = 0.0;
    int    learned = 0;
    for (int k = 0; k < RUNS(10000, 4000); k++)
    {
        const double v = control(&plant, feedforward_before(&x, triangle(k), measure(&plant)));
        const double u = v + feedforward_added(&x, v);
        // Told to be limited, and so that the reference is not held back by it: on the side it does not go to.
        feedforward_after(&x, v, k > RUNS(8000, 3000) ? u + 1e-3 : u, k > RUNS(8000, 3000));
        const double now = feedforward_seen(&x).travel;
        TEST_ASSERT_TRUE(k <= RUNS(8000, 3000) + 10 || now == travel);
        learned += now > travel;
        travel = now;
        move(&plant, u);
    }
    TEST_ASSERT_TRUE(learned > RUNS(500, 200)); // of a sample in ten ticks
}

/// The first good ticks, of a sum that is r alone: no number has a bit that nothing put there.
static void test_at_rest_all_is_0_to_the_last_bit(void)
{
    const TRIBO(feedforward, state_t) *const s = &x.memory.state;
    for (int enters = 0; enters < 2; enters++)
    {
        init(&x);
        if (enters)
        {
            feedforward_enter(&x, 0.25, true);
        }
        for (int k = 0; k < 50; k++)
        {
            TEST_ASSERT_TRUE(feedforward_before(&x, 0.25, 0.25) == 0.0);
            TEST_ASSERT_TRUE(feedforward_added(&x, 0.0) == 0.25);
            feedforward_after(&x, 0.0, 0.25, false);
            const feedforward_seen_t seen = feedforward_seen(&x);
            TEST_ASSERT_TRUE(seen.f == 0.0 && seen.lead == 0.0 && seen.b == 0.0 && seen.sigma == 0.0);
            TEST_ASSERT_TRUE(seen.lin == 0.25 && seen.reached == 0.25 && seen.z == 0.0 && seen.travel == 0.0);
            TEST_ASSERT_TRUE(s->r_noise == 0 && s->y_noise == 0 && s->error == 0);
            TEST_ASSERT_TRUE(s->behind[0] == 0 && s->behind[1] == 0 && s->stop[0] == 0 && s->stop[1] == 0);
            TEST_ASSERT_TRUE(s->force == s->reached && s->sign == 0 && s->limited == 0 && s->learner.stop[0] == 0.0f);
        }
    }
}

static void test_a_reference_that_has_never_moved_is_not_held(void)
{
    init(&x);
    for (int k = 0; k < 5000; k++)
    {
        const double e = feedforward_before(&x, 0.3, 0.3);
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.0, e);
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.3, feedforward_added(&x, 0.0)); // nobody knows which way friction acts
        feedforward_after(&x, 0.0, 0.3, false);
        TEST_ASSERT_FALSE(feedforward_holds(&x));
    }
}

static void test_breakaway_30_percent_off_is_learned_to_5_percent_within_4_reversals(void)
{
    static const double scale[][2] = {{1.3, 0.7}, {0.7, 0.7}};
    for (int i = 0; i < RUNS(2, 1); i++)
    {
        plant_t plant = {.positive = scale[i][0], .negative = scale[i][1], .noise = 1e-3};
        init(&x);
        for (int k = 0; k < RUNS(45000, 15000); k++) // reversals at 10, 20, 30, 40 s
        {
            (void)tick(&x, &plant, triangle(k));
        }
        // At 0.4 N, in the middle of the triangle.
        const double L = L0 + L1 * 0.4;
        for (uint32_t d = 0; d < 2u; d++)
        {
            const tribo_feedforward_learned_t at = feedforward_learned(&x, d, 0.4);
            TEST_ASSERT_DOUBLE_WITHIN(0.05 * scale[i][d] * L, scale[i][d] * L, (double)at.L_n);
            TEST_ASSERT_TRUE(at.relative_variance < 0.2f);
        }
    }
}

static void test_a_table_serves_as_a_prior_as_a_law_does(void)
{
    static const tribo_breakaway_point_f32_t table[] = {{0.0f, 0.007f, 0.014f},
                                                        {0.5f, 0.157f, 0.264f},
                                                        {1.0f, 0.307f, 0.514f}};

    plant_t plant                    = {.positive = 1.0, .negative = 1.5};
    model.friction.negative.offset_n = 0.014f;
    model.friction.negative.slope    = 0.5f;
    init(&x);
    model.friction.table        = table;
    model.friction.table_length = 3;
    init(&other);
    for (int k = 0; k < RUNS(25000, 13000); k++)
    {
        const double reference = k % 20000 < 10000 ? triangle(k) : triangle(k) - 0.4; // through 0 as well
        const double y         = measure(&plant);
        const double e         = feedforward_before(&x, reference, y);
        const double v         = control(&plant, e);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, e, feedforward_before(&other, reference, y));
        const double added = feedforward_added(&x, v);
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, added, feedforward_added(&other, v));
        feedforward_after(&x, v, v + added, false);
        feedforward_after(&other, v, v + added, false);
        move(&plant, v + added);
    }
    TEST_ASSERT_TRUE(feedforward_seen(&x).travel > RUNS(0.3, 0.15));
}

static void test_before_anything_is_learned_breakaway_is_the_prior_of_its_direction(void)
{
    static const tribo_breakaway_point_f32_t table[] = {{0.0f, 0.01f, 0.02f}, {0.5f, 0.2f, 0.1f}, {1.0f, 0.25f, 0.4f}};
    static const double                      force[] = {0.0, 0.25, -0.25, 0.75, -0.75};
    static const double                      of_table[][2] = {{0.01, 0.02}, {0.105, 0.06}, {0.225, 0.25}};

    model.friction.negative.offset_n = 0.014f;
    model.friction.negative.slope    = 0.5f;
    model.friction.gravity_n         = 0.02f; // is no breakaway
    init(&x);
    model.friction.table        = table;
    model.friction.table_length = 3;
    init(&other);
    for (int i = 0; i < 5; i++)
    {
        const double of_law[] = {L0 + L1 * fabs(force[i]), 0.014 + 0.5 * fabs(force[i])};
        for (uint32_t d = 0; d < 2u; d++)
        {
            const tribo_feedforward_learned_t by_law   = feedforward_learned(&x, d, force[i]);
            const tribo_feedforward_learned_t by_table = feedforward_learned(&other, d, force[i]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-7, of_law[d], (double)by_law.L_n);
            TEST_ASSERT_DOUBLE_WITHIN(1e-7, of_table[(i + 1) / 2][d], (double)by_table.L_n);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, (double)by_law.relative_variance);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, (double)by_table.relative_variance);
            TEST_ASSERT_TRUE(by_law.travel_n == 0.0f && by_table.travel_n == 0.0f);
            TEST_ASSERT_FALSE(by_law.at_bound || by_table.at_bound);
        }
    }
}

/// A load beyond breakaway leaves a twentieth of it in its direction.
static void test_the_learned_breakaway_of_a_direction_is_never_nothing(void)
{
    init(&x);
    feedforward_set_sliding(&x, 0.8);
    x.memory.state.learner.a[3] = -0.15f / x.params.learning.deviation[3];
    const double L              = 0.8 * (L0 + L1 * 0.3);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.05 * L, (double)feedforward_learned(&x, TRIBO_BREAKAWAY_POSITIVE, 0.3).L_n);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, L + 0.15, (double)feedforward_learned(&x, TRIBO_BREAKAWAY_NEGATIVE, 0.3).L_n);
}

static void test_learned_breakaway_says_when_it_is_at_a_bound(void)
{
    static const struct
    {
        double weight;
        bool   at_bound;
    } cases[] = {{0.02, true}, {0.2, true}, {0.21, false}, {2.9, false}, {3.0, true}};
    init(&x);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
    {
        feedforward_set_sliding(&x, cases[i].weight);
        TEST_ASSERT_TRUE(feedforward_learned(&x, 0, 0.5).at_bound == cases[i].at_bound);
    }
}

/// Seven slides of a second each with the weight `V`, less than a tenth of a second before the end with 1.
static bool stays_at_bound_with(double V)
{
    bool   latched   = false;
    double reference = 0.3;
    init(&x);
    for (int k = 0; k < 7000; k++)
    {
        reference += (k / 1000) % 2 == 0 ? 1e-5 : -1e-5;
        feedforward_set_sliding(&x, k < 6900 ? V : 1.0);
        (void)feedforward_before(&x, reference, 0.3);
        (void)feedforward_added(&x, 0.0);
        feedforward_after(&x, 0.0, 0.3, false);
        const bool stays = feedforward_learned(&x, 0, 0.3).stays_at_bound;
        TEST_ASSERT_FALSE(latched && !stays);
        TEST_ASSERT_FALSE(stays && k < 3900);            // the fourth reversal
        TEST_ASSERT_FALSE(stays != latched && k > 4100); // that one alone
        latched = stays;
    }
    return latched;
}

static void test_a_weight_that_reversals_keep_finding_at_its_bound_is_latched(void)
{
    TEST_ASSERT_FALSE(stays_at_bound_with(2.9));
    TEST_ASSERT_FALSE(stays_at_bound_with(0.21));
    TEST_ASSERT_TRUE(stays_at_bound_with(3.0));
    TEST_ASSERT_TRUE(stays_at_bound_with(0.2));
    TEST_ASSERT_TRUE(stays_at_bound_with(0.19));
    feedforward_restart(&x);
    TEST_ASSERT_TRUE(feedforward_learned(&x, 0, 0.3).stays_at_bound);
    TRIBO(feedforward, restore)(&x.memory.state);
    TEST_ASSERT_FALSE(feedforward_learned(&x, 0, 0.3).stays_at_bound);
}

static void test_a_flipped_bit_of_the_offset_is_counted_and_u_goes_on(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    run_to_stop(&plant);
    const feedforward_seen_t before = feedforward_seen(&x);
    TEST_ASSERT_EQUAL_UINT32(0, before.forgotten);
    feedforward_flip_bit(&x.memory.state.b, 20);
    (void)tick(&x, &plant, triangle(STOP));
    const feedforward_seen_t after = feedforward_seen(&x);
    TEST_ASSERT_EQUAL_UINT32(1, after.forgotten);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, before.term, after.term);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, before.b, after.b);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, before.weight[0], after.weight[0]);
    (void)tick(&x, &plant, triangle(STOP + 1));
    TEST_ASSERT_EQUAL_UINT32(1, feedforward_seen(&x).forgotten);
}

/// V_0 and the learned constant load after a slide of an arm with `part` of the breakaway, and after a reversal of r.
static void reverse(double part, feedforward_seen_t seen[2])
{
    plant_t plant     = {.positive = part, .negative = part};
    double  reference = 0.0;
    init(&x);
    for (int k = 0; k < 3010; k++)
    {
        reference += k < 3000 ? 1e-4 : k % 2 == 0 ? -1e-3 : 1e-3; // turns in every tick: only the first counts
        (void)tick(&x, &plant, reference);
        seen[k < 3000 ? 0 : 1] = feedforward_seen(&x);
    }
}

static void test_a_first_reversal_takes_a_lack_for_less_friction_and_more_for_a_load(void)
{
    feedforward_seen_t seen[2];
    reverse(0.6, seen);
    TEST_ASSERT_TRUE(seen[0].weight[0] > 0.7 && seen[0].weight[0] < 0.9);
    TEST_ASSERT_TRUE(seen[0].constant < -1e-3);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 0.6, seen[1].weight[0]);
    TEST_ASSERT_TRUE(fabs(seen[1].constant) < 0.01 * fabs(seen[0].constant));
    TEST_ASSERT_TRUE(fabs(seen[1].scale) < 0.01 * fabs(seen[0].scale));
    reverse(1.4, seen);
    TEST_ASSERT_TRUE(seen[0].weight[0] > 1.1 && seen[0].constant > 1e-3);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, seen[0].weight[0], seen[1].weight[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, seen[0].constant, seen[1].constant);
}

/// A controller that takes back `part` of the friction; as b goes with it, a half leaves nothing. For `reversals` of them, one a
/// second.
static void take_back(double part, int reversals)
{
    double reference = 0.3;
    for (int k = 0; k < 1000 * reversals; k++)
    {
        const double side = (k / 1000) % 2 == 0 ? 1.0 : -1.0;
        const double v    = -part * feedforward_seen(&x).f;
        reference += side * 1e-5;
        (void)feedforward_before(&x, reference, 0.3);
        (void)feedforward_added(&x, v);
        feedforward_after(&x, v, 0.3 + 0.1 * side, false); // the arm sticks
    }
}

static void test_a_corrupt_low_pass_of_v_comes_back(void)
{
    static const double odd[] = {(double)NAN, (double)INFINITY, -3e38};
    for (int i = 0; i < 3; i++)
    {
        init(&x);
        take_back(0.1, 2);
        x.memory.state.v = TRIBO_EITHER((float)odd[i], odd[i] < 0.0 ? INT32_MIN : INT32_MAX);
        take_back(0.1, 2);
        TEST_ASSERT_TRUE(fabs((double)x.memory.state.v) < TRIBO_EITHER(1.0, 1e8));
        TEST_ASSERT_TRUE(fabs(feedforward_seen(&x).b) < 1.0);
    }
}

static void test_friction_that_costs_more_than_it_saves_is_fed_back_for_longer_each_time(void)
{
    const tribo_feedforward_learner_t *const feedback = &x.memory.state.learner;
    init(&x);
    take_back(0.1, 20);
    TEST_ASSERT_FALSE(feedforward_learned(&x, 0, 0.3).harms);
    TEST_ASSERT_TRUE(fabs(feedforward_seen(&x).f) > 0.0 && feedforward_seen(&x).mode == TRIBO_FEEDFORWARD_MOVING);
    init(&x);
    unsigned lengths[4] = {0};
    unsigned left       = 0;
    unsigned found      = 0;
    for (int k = 0; k < 400 && found < 4; k++)
    {
        take_back(0.5, 2);
        if (feedback->left > left)
        {
            lengths[found++] = feedback->length;
        }
        left = feedback->left;
        TEST_ASSERT_TRUE(left == 0 || feedforward_seen(&x).mode == TRIBO_FEEDFORWARD_HOLD);
    }
    TEST_ASSERT_TRUE(feedforward_learned(&x, 0, 0.3).harms && feedforward_learned(&x, 1, 0.3).harms);
    const unsigned expected[4] = {4, 8 * (4 - 3), 8 * (8 - 3), 128}; // three reversals forward end a trial here
    TEST_ASSERT_EQUAL_UINT32_ARRAY(expected, lengths, 4);
}

static void test_friction_fed_forward_on_trial_stays_so_and_the_past_is_forgiven(void)
{
    const tribo_feedforward_learner_t *const feedback = &x.memory.state.learner;
    init(&x);
    for (int k = 0; k < 40 && feedback->length <= 4u; k++)
    {
        take_back(0.5, 2);
    }
    TEST_ASSERT_TRUE(feedback->length > 4u && feedback->left > 0u);
    take_back(0.1, 2 + 2 * feedback->left);
    TEST_ASSERT_TRUE(feedforward_learned(&x, 0, 0.3).harms); // latched
    TEST_ASSERT_TRUE(feedback->left == 0u && feedback->length == 0u);
    TEST_ASSERT_EQUAL_INT(TRIBO_FEEDFORWARD_MOVING, feedforward_seen(&x).mode);
    for (int k = 0; k < 40 && feedback->left == 0u; k++)
    {
        take_back(0.5, 2);
    }
    TEST_ASSERT_EQUAL_UINT32(4, feedback->length);
}

static void test_a_zeroed_memory_has_nothing_to_keep(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    TRIBO(force_loop, functions_t) functions;
    TRIBO(feedforward, method)(&functions);
    init(&x);
    memset(&x.memory, 0, sizeof x.memory);
    functions.start(&x.memory, true);
    TEST_ASSERT_TRUE(feedforward_learned(&x, 0, 0.3).relative_variance == 1.0f);
    for (int k = 0; k < 3000; k++)
    {
        (void)tick(&x, &plant, triangle(k));
    }
    TEST_ASSERT_EQUAL_UINT32(0, feedforward_learned(&x, 0, 0.3).forgotten);
    TEST_ASSERT_TRUE(feedforward_learned(&x, 0, 0.3).travel_n > 0.0f);
}

static void test_params_without_a_method_have_learned_nothing(void)
{
    init(&x);
    x.loop.method                             = NULL;
    const tribo_feedforward_learned_t learned = feedforward_learned(&x, 0, 0.3);
    TEST_ASSERT_TRUE(learned.L_n == 0.0f && learned.relative_variance == 0.0f && learned.travel_n == 0.0f);
}

static void test_friction_is_fed_back_over_restarts_until_restored(void)
{
    init(&x);
    take_back(0.5, 16);
    const unsigned left = x.memory.state.learner.left;
    TEST_ASSERT_TRUE(left > 2u);
    feedforward_restart(&x);
    take_back(0.1, 2);
    TEST_ASSERT_TRUE(feedforward_learned(&x, 0, 0.3).harms);
    TEST_ASSERT_EQUAL_UINT32(left - 2u, x.memory.state.learner.left);
    TEST_ASSERT_EQUAL_INT(TRIBO_FEEDFORWARD_HOLD, feedforward_seen(&x).mode);
    TRIBO(feedforward, restore)(&x.memory.state);
    TEST_ASSERT_FALSE(feedforward_learned(&x, 0, 0.3).harms);
    TEST_ASSERT_TRUE(x.memory.state.learner.left == 0 && x.memory.state.learner.length == 0);
    take_back(0.1, 20);
    TEST_ASSERT_FALSE(feedforward_learned(&x, 0, 0.3).harms);
    TEST_ASSERT_EQUAL_UINT32(0, x.memory.state.forgotten);
    TEST_ASSERT_EQUAL_INT(TRIBO_FEEDFORWARD_MOVING, feedforward_seen(&x).mode);
}

/// A controller that runs already holds a load. It has not travelled there since the method was taken over.
static void test_a_method_that_is_entered_again_and_again_is_not_said_to_do_harm(void)
{
    init(&x);
    for (int k = 0; k < 437 * 40; k++)
    {
        if (k % 437 == 0)
        {
            feedforward_enter(&x, 0.1, true);
        }
        const int phase = k % 200;
        (void)feedforward_before(&x, 0.3 + 1e-4 * (phase < 100 ? phase : 200 - phase), 0.3);
        (void)feedforward_added(&x, 0.3);
        feedforward_after(&x, 0.3, 0.3, false);
    }
    TEST_ASSERT_TRUE(fabs(feedforward_seen(&x).f) > 0.0);
    TEST_ASSERT_FALSE(feedforward_learned(&x, 0, 0.3).harms);
    TEST_ASSERT_TRUE(x.memory.state.learner.ratio == 0.0f);
}

static void test_a_bad_first_tick_waits(void)
{
    for (int enters = 0; enters < 2; enters++)
    {
        init(&x);
        if (enters)
        {
            feedforward_enter(&x, 0.0625, true);
        }
        for (int k = 0; k < 4; k++)
        {
            TEST_ASSERT_TRUE(feedforward_before(&x, k % 2 ? 3.0 : 0.4, k % 2 ? 0.4 : -3.0) == 0.0);
            TEST_ASSERT_TRUE(feedforward_added(&x, 0.3) == (enters ? 0.0625 : 0.0));
            feedforward_after(&x, 0.3, 0.3, false);
        }
        (void)feedforward_before(&x, 0.4, 0.4);
        TEST_ASSERT_EQUAL_UINT(TRIBO_FEEDFORWARD_START, feedforward_seen(&x).mode);
    }
}

/// Other params of the same method: the sum goes on, and so does all else.
static void test_new_params_take_the_sum_over(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    run_to_stop(&plant);
    const feedforward_seen_t before = feedforward_seen(&x);
    feedforward_enter(&x, before.term, false);
    x.params.reversal *= 2; // any change
    (void)feedforward_before(&x, triangle(STOP), plant.y);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, before.term, feedforward_added(&x, 0.1));
    TEST_ASSERT_EQUAL_UINT(TRIBO_FEEDFORWARD_MOVING, feedforward_seen(&x).mode);
    TEST_ASSERT_TRUE(feedforward_seen(&x).sigma == before.sigma);
}

/// A third of the breakaway is configured, so three times as much is learned. Where the true one is configured then, the
/// arm does not get three times that, and u goes on.
static void test_a_corrected_breakaway_forgets_what_was_learned_beside_the_old_one(void)
{
    plant_t      plant = {.positive = 1.0, .negative = 1.0};
    const double L     = L0 + L1 * 0.4;

    const tribo_friction_f32_config_t truth = model.friction;
    model.friction.positive.offset_n /= 3.0f;
    model.friction.positive.slope /= 3.0f;
    model.friction.negative = model.friction.positive;
    init(&x);
    run_to_stop(&plant);
    TEST_ASSERT_DOUBLE_WITHIN(0.15 * L, L, (double)feedforward_learned(&x, 0, 0.4).L_n);

    model.friction = truth;
    init(&other);
    other.memory = x.memory;
    feedforward_enter(&other, feedforward_seen(&x).term, false);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * L, L, (double)feedforward_learned(&other, 0, 0.4).L_n);
    TEST_ASSERT_TRUE(feedforward_learned(&other, 0, 0.4).travel_n == 0.0f);
    const double before = plant.u;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, before, tick(&other, &plant, triangle(STOP)));
    for (int k = STOP + 1; k < STOP + 15000; k++)
    {
        (void)tick(&other, &plant, triangle(k));
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.15 * L, L, (double)feedforward_learned(&other, 0, 0.4).L_n);
    TEST_ASSERT_FALSE(feedforward_learned(&other, 0, 0.4).harms);
    TEST_ASSERT_EQUAL_UINT32(0, feedforward_learned(&other, 0, 0.4).forgotten);
}

/// A drive whose params change before its first tick begins at rest all the same.
static void test_a_method_at_rest_takes_no_sum_over(void)
{
    init(&x);
    init(&other);
    feedforward_enter(&x, 0.25, false);
    for (int k = 0; k < 20; k++)
    {
        (void)feedforward_before(&x, 0.4, 0.4);
        (void)feedforward_before(&other, 0.4, 0.4);
        TEST_ASSERT_TRUE(feedforward_added(&x, 0.1) == feedforward_added(&other, 0.1));
        feedforward_after(&x, 0.1, 0.1, false);
        feedforward_after(&other, 0.1, 0.1, false);
    }
    TEST_ASSERT_EQUAL_UINT(TRIBO_FEEDFORWARD_START, feedforward_seen(&x).mode);
}

static void test_counters_stop_at_their_end(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    x.memory.state.late = UINT32_MAX - 1u;
    for (int k = 0; k < 50; k++)
    {
        x.memory.state.exchange.owner = TRIBO_FEEDFORWARD_OWNER_LEARNER;
        (void)tick_alone(0.4, plant.y);
    }
    TEST_ASSERT_TRUE(x.memory.state.late == UINT32_MAX);
    x.memory.state.forgotten         = UINT32_MAX;
    x.memory.state.learner.forgotten = 1;
    TEST_ASSERT_TRUE(feedforward_learned(&x, 0, 0.3).forgotten == UINT32_MAX);
}

/// What the monitor feeds back does not stand, and so u does not rest.
static void test_u_does_not_rest_where_the_monitor_alone_feeds_friction_back(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    for (int stands = 0; stands < 2; stands++)
    {
        config.still_time_s = stands ? 0.05f : 0.0f;
        init(&x);
        plant = (plant_t){.positive = 1.0, .negative = 1.0, .noise = 1e-3};
        run_to_stop(&plant);
        bool rested = false;
        for (int k = 0; k < 500; k++)
        {
            if (x.memory.state.weights.fed_back == 0u)
            {
                x.memory.state.weights.fed_back = 1u;
                x.memory.state.weights.seal ^= 1u;
            }
            (void)tick(&x, &plant, triangle(STOP));
            TEST_ASSERT_EQUAL_UINT(TRIBO_FEEDFORWARD_HOLD, feedforward_seen(&x).mode);
            rested = rested || x.memory.state.rests;
        }
        TEST_ASSERT_EQUAL(stands, rested);
    }
}

/// What another method goes on from.
static void test_a_hand_over_gets_error_reading_and_term_of_the_last_tick(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    for (int k = 0; k < 1000; k++)
    {
        (void)tick(&x, &plant, triangle(k));
    }
    const double y = plant.y;
    (void)tick(&x, &plant, triangle(1000));
    const TRIBO(force_loop, tick_t) last = x.memory.state.tick;
    const feedforward_seen_t seen        = feedforward_seen(&x);
    TEST_ASSERT_TRUE(last.has_e && last.has_y);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, seen.e, tribo_force_n(last.TRIBO_N(e), x.full_scale_n));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, y, tribo_force_n(last.TRIBO_N(y), x.full_scale_n));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, seen.term, tribo_force_n(last.TRIBO_N(term), x.full_scale_n));
}

static void test_friction_takes_the_share_of_a_guard(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    for (int k = 0; k < 12000; k++)
    {
        (void)tick(&x, &plant, triangle(k));
    }
    feedforward_copy(&other, &x);
    (void)feedforward_before(&x, triangle(12000), plant.y);
    (void)feedforward_before_shared(&other, triangle(12000), plant.y, 0.25);
    TEST_ASSERT_TRUE(feedforward_seen(&x).f < -0.05);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.25 * feedforward_seen(&x).f, feedforward_seen(&other).f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, feedforward_seen(&x).lin, feedforward_seen(&other).lin);
}

/// The sum of leads is a part alpha/(p_a h) of the jump, while it lasts.
static void test_a_jump_leads_the_actuator(void)
{
    init(&x);
    double reference = 0.3;
    double sum       = 0.0;
    double f[2]      = {0.0, 0.0};
    int    ticks     = 0;
    for (int k = 0; k < 1000; k++)
    {
        reference += k < 500 ? 1e-5 : -1e-5;
        (void)feedforward_before(&x, reference, 0.3);
        (void)feedforward_added(&x, 0.0);
        feedforward_after(&x, 0.0, 0.3, false);
        const feedforward_seen_t seen = feedforward_seen(&x);
        sum += seen.lead;
        ticks += seen.lead != 0.0;
        TEST_ASSERT_TRUE((seen.lead != 0.0) ==
                             (k > 500 && seen.sigma != 1.0 && (seen.sigma != -1.0 || seen.f != f[1])) ||
                         seen.sigma == -1.0);
        f[k >= 500] = seen.f;
    }
    TEST_ASSERT_INT_WITHIN(1, 26, ticks);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * fabs(sum), 0.7 / (200.0 * H) * (f[1] - f[0]), sum);
}

/// A force that keeps slipping from side to side in a hold is less than learned.
static void test_chatter_in_a_hold_lowers_friction(void)
{
    plant_t plant = {.positive = 1.0, .negative = 1.0};
    init(&x);
    for (int k = 0; k < 8000 + 700; k++)
    {
        (void)tick(&x, &plant, triangle(k < 8000 ? k : 8000));
    }
    TEST_ASSERT_TRUE(feedforward_holds(&x));
    const double V = feedforward_seen(&x).weight[0];
    for (int k = 0; k < 1000; k++) // u swings by far more than breakaway, each 100 ms
    {
        (void)feedforward_before(&x, triangle(8000), plant.y);
        (void)feedforward_added(&x, 0.0);
        feedforward_after(&x, 0.0, (k / 100) % 2 == 0 ? 1.5 : -1.5, false);
        TEST_ASSERT_TRUE(k > 300 || feedforward_seen(&x).weight[0] == V);
    }
    const double lowered = feedforward_seen(&x).sliding;
    TEST_ASSERT_DOUBLE_WITHIN(0.12 * V, V * pow(0.9, 5.0), lowered);
    x.memory.state.chatter ^= 0x80u; // a flipped bit is little chatter
    for (int k = 0; k < 30; k++)
    {
        (void)tick(&x, &plant, triangle(8000));
    }
    TEST_ASSERT_TRUE(feedforward_seen(&x).sliding > 0.6 * lowered);
}

static void test_friction_goes_over_within_the_jump_time_after_a_reversal(void)
{
    init(&x);
    config.jump_time_s = 1e-6f; // at once
    init(&other);
    double reference = 0.3;
    for (int k = 0; k < 1000; k++)
    {
        reference += k < 500 ? 1e-4 : -1e-4;
        for (int i = 0; i < 2; i++)
        {
            feedforward_t *f = i == 0 ? &x : &other;
            (void)feedforward_before(f, reference, reference);
            (void)feedforward_added(f, 0.0);
            feedforward_after(f, 0.0, reference, false);
        }
        // r has come back by the width 5 ticks after its peak, give or take a rounding, or two.
        if (k == 504)
        {
            TEST_ASSERT_TRUE(feedforward_seen(&x).sigma == 1.0 && feedforward_seen(&other).sigma == 1.0);
        }
        if (k == 506)
        {
            TEST_ASSERT_TRUE(feedforward_seen(&other).sigma == -1.0);
            TEST_ASSERT_TRUE(feedforward_seen(&x).sigma < 1.0 && feedforward_seen(&x).sigma > 0.6);
        }
        if (k == 516)
        {
            TEST_ASSERT_TRUE(fabs(feedforward_seen(&x).sigma) < 0.3);
        }
        if (k == 534)
        {
            TEST_ASSERT_TRUE(feedforward_seen(&x).sigma == -1.0);
        }
    }
}

static void test_the_reachable_reference_stops_where_u_is_limited(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        init(&x);
        for (int k = 0; k < 10; k++)
        {
            (void)feedforward_before(&x, sign * 0.5, 0.0);
            (void)feedforward_added(&x, 0.0);
            feedforward_after(&x, 0.0, sign * 0.125, true);
        }
        TEST_ASSERT_TRUE(feedforward_seen(&x).reached == sign * 0.5);
        (void)feedforward_before(&x, sign * 0.625, 0.0);
        TEST_ASSERT_TRUE(feedforward_seen(&x).reached == sign * 0.5); // not further
        (void)feedforward_before(&x, sign * 0.375, 0.0);
        TEST_ASSERT_TRUE(feedforward_seen(&x).reached == sign * 0.375); // but back
    }
}

static void test_without_a_still_time_r_never_stands_and_with_a_tick_it_does(void)
{
    for (int still = 0; still < 2; still++)
    {
        plant_t plant       = {.positive = 1.0, .negative = 1.0};
        config.still_time_s = (float)still * (float)H;
        init(&x);
        for (int k = 0; k < 5000; k++)
        {
            (void)tick(&x, &plant, triangle(k < 2000 ? k : 2000));
            TEST_ASSERT_TRUE(still == 1 || !feedforward_holds(&x));
        }
        TEST_ASSERT_EQUAL_UINT(still == 1 ? TRIBO_FEEDFORWARD_HOLD : TRIBO_FEEDFORWARD_MOVING,
                               feedforward_seen(&x).mode);
    }
}

/// A reading that changes in each tick, by 2 mN to and fro: its mean second difference is 4 mN, of which 0.04 are not fed back.
static void test_in_a_hold_the_deadband_of_noise_is_a_part_of_its_second_difference(void)
{
    init(&x);
    double sum = 0.0;
    for (int k = 0; k < 8000; k++)
    {
        const double reference = triangle(k < 3000 ? k : 3000);
        const double y         = reference - 1e-3 + (k % 2 == 0 ? 1e-3 : -1e-3);
        (void)feedforward_before(&x, reference, y);
        (void)feedforward_added(&x, 0.0);
        feedforward_after(&x, 0.0, reference, false);
        sum += k < 6000 ? 0.0 : feedforward_seen(&x).e / 2000.0;
    }
    TEST_ASSERT_TRUE(feedforward_holds(&x));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1e-3 - 0.04 * 4e-3, sum);
}

/// The noise of a hold before a restart is no noise of the next one.
static void test_a_hold_after_a_restart_has_no_deadband_of_the_last(void)
{
    init(&x);
    double e = 0.0;
    for (int k = 0; k < 14000; k++)
    {
        if (k == 7000)
        {
            feedforward_restart(&x);
        }
        const int    phase     = k % 7000;
        const double reference = triangle(phase < 3000 ? phase : 3000);
        const double y         = reference - 3e-4 + (k >= 7000 ? 0.0 : k % 2 == 0 ? 3e-3 : -3e-3);
        e                      = feedforward_before(&x, reference, y);
        (void)feedforward_added(&x, 0.0);
        feedforward_after(&x, 0.0, reference, false);
    }
    TEST_ASSERT_TRUE(feedforward_holds(&x));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 3e-4, e);
}

static void test_the_ramp_of_a_jump_ends_in_a_tick_at_the_fastest(void)
{
    config.jump_time_s = 1e-6f;
    init(&x);
    TEST_ASSERT_TRUE((double)x.params.jump == 2.0 * FEEDFORWARD_ONE);
    config.jump_time_s = 1.05e-3f;
    init(&x);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2.0 / 1.05, (double)x.params.jump / FEEDFORWARD_ONE);
}

static void test_noise_of_the_reference_widens_a_reversal(void)
{
    config.still_time_s = 0.0f;
    init(&x);
    double last  = 0.0;
    int    turns = 0;
    for (int k = 0; k < 20000; k++)
    {
        // A slow rise with a swing of 0.6 mN, wider than w.
        const double reference = 0.3 + 1e-6 * k + (k % 10 < 5 ? 6e-4 : 0.0);
        (void)feedforward_before(&x, reference, reference);
        (void)feedforward_added(&x, 0.0);
        feedforward_after(&x, 0.0, reference, false);
        turns += k > 10000 && feedforward_seen(&x).sigma != last;
        last = feedforward_seen(&x).sigma;
    }
    TEST_ASSERT_EQUAL_INT(0, turns);
}

#include "runners/test_feedforward.inc" // main
