#include "tribo/breakaway_learning_f32.h"

#include "random.h"
#include "runs.h"
#include "same.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define POSITIVE TRIBO_BREAKAWAY_POSITIVE
#define NEGATIVE TRIBO_BREAKAWAY_NEGATIVE

static tribo_breakaway_learning_f32_config_t config;
static tribo_breakaway_learning_f32_params_t params;
static tribo_breakaway_learning_f32_state_t  learning;

void setUp(void)
{
    config = tribo_breakaway_learning_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_breakaway_learning_f32_init(&params, &config));
    tribo_breakaway_learning_f32_reset(&params, &learning);
}

void tearDown(void)
{
}

/// The filter as a textbook has it, in double, with four states in prior spreads: L+'s scale and offset, L-'s.
typedef struct
{
    double t[4], P[4][4];
} exact_t;

static exact_t exact_start(void)
{
    exact_t e = {.P = {{0.0}}};
    for (int i = 0; i < 4; i++)
    {
        e.P[i][i]           = 1.0;
        e.P[i][(i + 2) % 4] = (double)config.correlation;
    }
    return e;
}

static void exact_step(exact_t *e, uint32_t direction, double travel, double prior, double measured)
{
    double a[4]          = {0.0};
    double q[4]          = {0.0};
    double variance      = 0.0;
    double error         = measured - prior;
    a[2 * direction]     = (double)config.spread_scale * prior;
    a[2 * direction + 1] = (double)config.spread_offset_n;
    for (int i = 0; i < 4; i++)
    {
        for (int j = 0; j < 4; j++)
        {
            q[i] += e->P[i][j] * a[j];
        }
        variance += a[i] * q[i];
        error -= a[i] * e->t[i];
    }
    const double gain = travel / ((double)config.weight_n * prior * prior + travel * variance);
    const double fade = fmin(1.0, (double)config.forgetting_per_n * travel);
    for (int i = 0; i < 4; i++)
    {
        e->t[i] = fmin(3.0, fmax(-3.0, e->t[i] + gain * q[i] * error));
        for (int j = 0; j < 4; j++)
        {
            const double at_first = i == j ? 1.0 : ((i + 2) % 4 == j ? (double)config.correlation_faded : 0.0);
            const double left     = e->P[i][j] - gain * q[i] * q[j];
            e->P[i][j]            = left + fade * (at_first - left);
        }
    }
}

static double exact_doubt(const exact_t *e, uint32_t direction, double prior)
{
    const uint32_t i  = 2 * direction;
    const double   a0 = (double)config.spread_scale * prior;
    const double   a1 = (double)config.spread_offset_n;
    return (a0 * a0 * e->P[i][i] + 2.0 * a0 * a1 * e->P[i][i + 1] + a1 * a1 * e->P[i + 1][i + 1]) / (a0 * a0 + a1 * a1);
}

static void test_learning_is_the_filter_of_the_textbook(void)
{
    random_t r           = {11};
    exact_t  exact       = exact_start();
    double   worst_t     = 0.0;
    double   worst_doubt = 0.0;
    double   worst_L     = 0.0;
    for (int k = 0; k < RUNS(50000, 10000); k++)
    {
        const uint32_t direction = (uint32_t)(k / 4000) % 2u;
        const float    prior     = (float)random_between(&r, 0.02, 0.2);
        const double   truth     = direction == POSITIVE ? 1.3 * (double)prior : 0.8 * (double)prior + 0.005;
        const float    measured  = (float)(truth + random_between(&r, -0.01, 0.01));
        const float    travel    = (float)random_between(&r, 0.0, k % 100 == 0 ? 5e-3 : 1e-4);
        exact_step(&exact, direction, (double)travel, (double)prior, (double)measured);
        tribo_breakaway_learning_f32_step(&params, &learning, direction, travel, prior, measured);
        for (uint32_t d = 0; d < 2u; d++)
        {
            const tribo_breakaway_learning_f32_signals_t at =
                tribo_breakaway_learning_f32_at(&params, &learning, d, prior);
            const double L = (double)prior * (1.0 + (double)config.spread_scale * exact.t[2 * d]) +
                             (double)config.spread_offset_n * exact.t[2 * d + 1];
            const double scale  = (double)learning.of[d].scale / (double)config.spread_scale;
            const double offset = (double)learning.of[d].offset_n / (double)config.spread_offset_n;
            worst_t             = fmax(worst_t, fmax(fabs(scale - exact.t[2 * d]), fabs(offset - exact.t[2 * d + 1])));
            worst_doubt         = fmax(worst_doubt, fabs((double)at.doubt - exact_doubt(&exact, d, (double)prior)));
            worst_L             = fmax(worst_L, fabs((double)at.L_n - L));
            TEST_ASSERT_DOUBLE_WITHIN(1e-7, (1.0 - 0.5 * (double)at.doubt) * (double)at.L_n, (double)at.weighted_n);
        }
    }
    printf("states within %.1e spreads, doubt within %.1e, L within %.1e N\n", worst_t, worst_doubt, worst_L);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0, worst_t);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, worst_doubt);
    TEST_ASSERT_DOUBLE_WITHIN(5e-6, 0.0, worst_L);
}

static void test_nothing_is_known_at_first(void)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        const tribo_breakaway_learning_f32_signals_t at = tribo_breakaway_learning_f32_at(&params, &learning, d, 0.1f);
        TEST_ASSERT_SAME_FLOAT(0.1f, at.L_n);
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f, at.doubt);
        TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.05f, at.weighted_n);
        TEST_ASSERT_FALSE(tribo_breakaway_learning_f32_is_at_bound(&params, &learning, d, 0.1f));
    }
}

static void test_one_direction_teaches_the_other_something(void)
{
    for (int k = 0; k < 1000; k++)
    {
        tribo_breakaway_learning_f32_step(&params, &learning, POSITIVE, 1e-4f, 0.1f, 0.13f);
    }
    const tribo_breakaway_learning_f32_signals_t own =
        tribo_breakaway_learning_f32_at(&params, &learning, POSITIVE, 0.1f);
    const tribo_breakaway_learning_f32_signals_t other =
        tribo_breakaway_learning_f32_at(&params, &learning, NEGATIVE, 0.1f);
    TEST_ASSERT_FLOAT_WITHIN(5e-4f, 0.13f, own.L_n);
    TEST_ASSERT_FLOAT_WITHIN(2e-3f, 0.121f, other.L_n); // by the correlation of 0.7
    TEST_ASSERT_TRUE(own.doubt < 0.02f && other.doubt > 0.4f && other.doubt < 0.6f);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 0.1f, learning.travel_n[POSITIVE]);
    TEST_ASSERT_SAME_FLOAT(0.0f, learning.travel_n[NEGATIVE]);
}

static void test_what_was_learned_stays_within_its_bounds_and_says_so(void)
{
    for (int k = 0; k < 100000; k++)
    {
        tribo_breakaway_learning_f32_step(&params, &learning, NEGATIVE, 1e-3f, 0.1f, 10.0f);
    }
    TEST_ASSERT_SAME_FLOAT(3.0f * 0.4f, learning.of[NEGATIVE].scale);
    TEST_ASSERT_TRUE(tribo_breakaway_learning_f32_is_at_bound(&params, &learning, NEGATIVE, 0.1f));
    TEST_ASSERT_TRUE(tribo_breakaway_learning_f32_at(&params, &learning, NEGATIVE, 0.1f).L_n <= 0.3f);
    // Each bound by itself.
    tribo_breakaway_learning_f32_reset(&params, &learning);
    learning.of[POSITIVE].offset_n = 0.03f;
    TEST_ASSERT_TRUE(tribo_breakaway_learning_f32_is_at_bound(&params, &learning, POSITIVE, 0.1f));
    learning.of[POSITIVE].offset_n = 0.0299f;
    TEST_ASSERT_FALSE(tribo_breakaway_learning_f32_is_at_bound(&params, &learning, POSITIVE, 0.1f));
    TEST_ASSERT_TRUE(tribo_breakaway_learning_f32_is_at_bound(&params, &learning, POSITIVE, 0.01f)); // L over 3 times
    TEST_ASSERT_SAME_FLOAT(0.03f, tribo_breakaway_learning_f32_at(&params, &learning, POSITIVE, 0.01f).L_n);
    learning.of[POSITIVE].offset_n = -0.02f;
    TEST_ASSERT_TRUE(tribo_breakaway_learning_f32_is_at_bound(&params, &learning, POSITIVE, 0.02f)); // below a fifth
    TEST_ASSERT_SAME_FLOAT(0.2f * 0.02f, tribo_breakaway_learning_f32_at(&params, &learning, POSITIVE, 0.02f).L_n);
}

/// One slide in direction d, in which friction is `measured`.
static void slide(uint32_t d, double measured)
{
    for (int k = 0; k < 1000; k++)
    {
        tribo_breakaway_learning_f32_step(&params, &learning, d, 1e-3f, 0.1f, (float)measured);
    }
    tribo_breakaway_learning_f32_slide_ends(&params, &learning, d, 0.1f);
}

static void test_four_slides_that_end_at_a_bound_are_latched(void)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        tribo_breakaway_learning_f32_reset(&params, &learning);
        for (uint8_t k = 1; k <= 5u; k++)
        {
            slide(d, 1.9);
            TEST_ASSERT_EQUAL_UINT8(k, learning.bound_slides[d]);
            TEST_ASSERT_EQUAL_UINT8(k >= 4u, learning.stays_at_bound[d]);
            tribo_breakaway_learning_f32_slide_ends(&params, &learning, d, 0.1f); // nothing was learned since
            TEST_ASSERT_EQUAL_UINT8(k, learning.bound_slides[d]);
        }
        TEST_ASSERT_EQUAL_UINT8(0, learning.stays_at_bound[1u - d] + learning.bound_slides[1u - d]);
        learning.bound_slides[d] = UINT8_MAX;
        slide(d, 1.9);
        TEST_ASSERT_EQUAL_UINT8(UINT8_MAX, learning.bound_slides[d]);

        // Back within the bounds it stays latched, until it is told.
        slide(d, 0.1);
        TEST_ASSERT_EQUAL_UINT8(0, learning.bound_slides[d]);
        TEST_ASSERT_EQUAL_UINT8(1, learning.stays_at_bound[d]);
        slide(d, 1.9);
        const tribo_breakaway_learning_f32_state_t before = learning;
        tribo_breakaway_learning_f32_restore(&learning);
        TEST_ASSERT_EQUAL_UINT8(0, learning.stays_at_bound[d] + learning.bound_slides[d]);
        TEST_ASSERT_EQUAL_MEMORY(before.of, learning.of, sizeof learning.of);
        slide(d, 1.9);
        TEST_ASSERT_EQUAL_UINT8(0, learning.stays_at_bound[d]); // counted from anew
    }
    slide(POSITIVE, 1.9);
    tribo_breakaway_learning_f32_reset(&params, &learning);
    TEST_ASSERT_EQUAL_UINT8(0, learning.bound_slides[POSITIVE]);
}

/// As if learned on the side that is left.
static tribo_breakaway_across_f32_t side_of(const tribo_breakaway_learning_f32_state_t *state)
{
    tribo_breakaway_across_f32_t side;
    for (uint32_t d = 0; d < 2u; d++)
    {
        side.of[d]          = state->of[d];
        side.shared[d]      = state->shared[d];
        side.shared[2u + d] = state->shared[2u + d];
        side.travel_n[d]    = state->travel_n[d];
    }
    return side;
}

/// All that was learned changes places where neither side is taken over, each number of its own.
static void test_a_side_that_is_not_taken_over_is_exchanged_whole(void)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        const float of     = 0.01f * (float)d;
        learning.of[d]     = (tribo_breakaway_learned_f32_t){1.0f + of, 0.2f + of, 0.9f + of, 0.5f + of, 0.6f + of};
        learning.shared[d] = 0.3f + of;
        learning.shared[2u + d] = 0.4f + of;
        learning.travel_n[d]    = 5.0f + of;
        learning.across.of[d] =
            (tribo_breakaway_learned_f32_t){-1.0f + of, -0.2f + of, 0.01f + of, -0.5f + of, 0.7f + of};
        learning.across.shared[d]      = -0.3f + of;
        learning.across.shared[2u + d] = -0.4f + of;
        learning.across.travel_n[d]    = 7.0f + of;
    }
    const tribo_breakaway_across_f32_t left   = side_of(&learning);
    const tribo_breakaway_across_f32_t across = learning.across;
    tribo_breakaway_learning_f32_change_side(&params, &learning);
    const tribo_breakaway_across_f32_t now = side_of(&learning);
    TEST_ASSERT_EQUAL_MEMORY(&across, &now, sizeof now);
    TEST_ASSERT_EQUAL_MEMORY(&left, &learning.across, sizeof left);
}

/// What there is in `state` once r has come to it from where `other` was learned.
static void take_over(tribo_breakaway_learning_f32_state_t *state, const tribo_breakaway_learning_f32_state_t *other)
{
    tribo_breakaway_learning_f32_state_t crossing = *other;
    crossing.across                               = side_of(state);
    tribo_breakaway_learning_f32_change_side(&params, &crossing);

    const tribo_breakaway_across_f32_t left = side_of(other);
    TEST_ASSERT_EQUAL_MEMORY(&left, &crossing.across, sizeof left);
    TEST_ASSERT_EQUAL_UINT8(other->slid, crossing.slid);
    TEST_ASSERT_EQUAL_MEMORY(other->bound_slides, crossing.bound_slides, sizeof crossing.bound_slides);
    crossing.across = state->across;
    *state          = crossing;
}

static void test_what_is_better_known_elsewhere_is_taken_over_with_more_doubt(void)
{
    tribo_breakaway_learning_f32_state_t here = learning;
    slide(POSITIVE, 0.14);
    slide(NEGATIVE, 0.08);
    slide(POSITIVE, 0.14);
    const tribo_breakaway_learning_f32_state_t taught = learning;

    // Nothing is known here, not even whether it was learned from.
    take_over(&here, &taught);
    for (uint32_t d = 0; d < 2u; d++)
    {
        TEST_ASSERT_SAME_FLOAT(taught.of[d].scale, here.of[d].scale);
        TEST_ASSERT_SAME_FLOAT(taught.of[d].offset_n, here.of[d].offset_n);
        TEST_ASSERT_SAME_FLOAT(taught.of[d].ss + (0.25f * params.scale_variance), here.of[d].ss);
        TEST_ASSERT_SAME_FLOAT(taught.of[d].so, here.of[d].so);
        TEST_ASSERT_SAME_FLOAT(taught.of[d].oo, here.of[d].oo);
        TEST_ASSERT_TRUE(here.travel_n[d] == 0);
    }
    TEST_ASSERT_EQUAL_MEMORY(taught.shared, here.shared, sizeof here.shared);

    // What is better known here stays where the two differ in both directions,
    for (int way = -1; way <= 1; way += 2)
    {
        for (uint32_t d = 0; d < 2u; d++)
        {
            learning = taught;
            learning.of[d].scale += (float)way * 0.041f;
            learning.of[1u - d].scale -= (float)way * 0.041f;
            tribo_breakaway_learning_f32_state_t before = learning;
            take_over(&learning, &taught);
            TEST_ASSERT_EQUAL_MEMORY(&before, &learning, sizeof learning);
            // or as long as the other side has slid one way only;
            learning.of[d].scale                       = taught.of[d].scale + (float)way * 0.039f;
            before                                     = learning;
            tribo_breakaway_learning_f32_state_t other = taught;
            other.travel_n[d]                          = 0;
            take_over(&learning, &other);
            TEST_ASSERT_EQUAL_MEMORY(&before, &learning, sizeof learning);
            // where they agree in one, both are of one kind, and the other is newer.
            take_over(&learning, &taught);
            TEST_ASSERT_EQUAL_MEMORY(taught.of, learning.of, sizeof learning.of);
        }
    }
}

static void test_no_travel_and_bad_inputs_teach_nothing(void)
{
    for (int k = 0; k < 100; k++)
    {
        tribo_breakaway_learning_f32_step(&params, &learning, POSITIVE, 1e-4f, 0.1f, 0.13f);
    }
    const tribo_breakaway_learning_f32_state_t before = learning;
    const float                                bad[]  = {NAN, INFINITY, -INFINITY, 1.1e6f};
    for (int i = 0; i < 4; i++)
    {
        tribo_breakaway_learning_f32_step(&params, &learning, POSITIVE, bad[i], 0.1f, 0.13f);
        tribo_breakaway_learning_f32_step(&params, &learning, POSITIVE, 1e-4f, i < 3 ? bad[i] : 2.1e7f, 0.13f);
        tribo_breakaway_learning_f32_step(&params, &learning, POSITIVE, 1e-4f, 0.1f, bad[i]);
    }
    tribo_breakaway_learning_f32_step(&params, &learning, POSITIVE, 0.0f, 0.1f, 0.2f);
    tribo_breakaway_learning_f32_step(&params, &learning, POSITIVE, -1e-4f, 0.1f, 0.2f);
    TEST_ASSERT_EQUAL_MEMORY(&before, &learning, sizeof learning);
    TEST_ASSERT_FLOAT_WITHIN(3.1e-6f, 0.0f, tribo_breakaway_learning_f32_at(&params, &learning, NEGATIVE, NAN).L_n);
}

static void test_forgetting_brings_the_priors_doubt_back_and_not_more(void)
{
    for (int k = 0; k < 1000; k++)
    {
        tribo_breakaway_learning_f32_step(&params, &learning, POSITIVE, 1e-4f, 0.1f, 0.13f);
    }
    const float left = tribo_breakaway_learning_f32_at(&params, &learning, POSITIVE, 0.1f).doubt;
    // Learning in the other direction alone.
    for (int k = 0; k < 20000; k++)
    {
        tribo_breakaway_learning_f32_step(&params, &learning, NEGATIVE, 1e-3f, 0.1f, 0.1f);
    }
    const float back = tribo_breakaway_learning_f32_at(&params, &learning, POSITIVE, 0.1f).doubt;
    printf("doubt %g after learning, %g after 20 N\n", (double)left, (double)back);
    TEST_ASSERT_TRUE(left < 0.02f && back > 0.8f && back <= 1.00001f);
    // All at once.
    tribo_breakaway_learning_f32_step(&params, &learning, NEGATIVE, 1e3f, 0.1f, 0.1f);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 1.0f, tribo_breakaway_learning_f32_at(&params, &learning, POSITIVE, 0.1f).doubt);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 1.0f, tribo_breakaway_learning_f32_at(&params, &learning, NEGATIVE, 0.1f).doubt);
}

static void check(float *field, float value, tribo_status_t status)
{
    const tribo_breakaway_learning_f32_params_t before = params;
    const float                                 kept   = *field;
    *field                                             = value;
    TEST_ASSERT_EQUAL_INT(status, tribo_breakaway_learning_f32_init(&params, &config));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    *field = kept;
}

static void test_learning_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_breakaway_learning_f32_init(NULL, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_breakaway_learning_f32_init(&params, NULL));
    check(&config.spread_scale, 0.0f, TRIBO_ERR_LEARNING_SPREAD);
    check(&config.spread_offset_n, NAN, TRIBO_ERR_LEARNING_SPREAD);
    check(&config.correlation, 1.0f, TRIBO_ERR_LEARNING_CORRELATION);
    check(&config.correlation_faded, -0.1f, TRIBO_ERR_LEARNING_CORRELATION);
    check(&config.trust, 1.1f, TRIBO_ERR_LEARNING_TRUST);
    check(&config.doubt, 0.0f, TRIBO_ERR_LEARNING_TRUST);
    check(&config.weight_n, 0.0f, TRIBO_ERR_LEARNING_WEIGHT);
    check(&config.forgetting_per_n, -1.0f, TRIBO_ERR_LEARNING_FORGETTING);
    check(&config.scale_min, 1.1f, TRIBO_ERR_LEARNING_BOUNDS);
    check(&config.scale_max, 0.9f, TRIBO_ERR_LEARNING_BOUNDS);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_learning_is_the_filter_of_the_textbook);
    RUN_TEST(test_nothing_is_known_at_first);
    RUN_TEST(test_one_direction_teaches_the_other_something);
    RUN_TEST(test_what_was_learned_stays_within_its_bounds_and_says_so);
    RUN_TEST(test_four_slides_that_end_at_a_bound_are_latched);
    RUN_TEST(test_what_is_better_known_elsewhere_is_taken_over_with_more_doubt);
    RUN_TEST(test_no_travel_and_bad_inputs_teach_nothing);
    RUN_TEST(test_forgetting_brings_the_priors_doubt_back_and_not_more);
    RUN_TEST(test_learning_init_names_the_field);
    RUN_TEST(test_a_side_that_is_not_taken_over_is_exchanged_whole);
    return UNITY_END();
}
