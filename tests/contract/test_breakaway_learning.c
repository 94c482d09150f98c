#include PARTS_HEADER
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define POSITIVE TRIBO_BREAKAWAY_POSITIVE
#define NEGATIVE TRIBO_BREAKAWAY_NEGATIVE

static tribo_breakaway_learning_f32_config_t config;
static learning_t                            learning;

void setUp(void)
{
    config = tribo_breakaway_learning_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, learning_init(&learning, &config));
}

void tearDown(void)
{
}

/// The filter as a textbook has it, in double, with four states in prior standard deviations: L+'s scale and offset, L-'s.
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
    a[2 * direction]     = (double)config.scale_sd * prior;
    a[2 * direction + 1] = (double)config.offset_sd_n;
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

static double exact_variance(const exact_t *e, uint32_t direction, double prior)
{
    const uint32_t i  = 2 * direction;
    const double   a0 = (double)config.scale_sd * prior;
    const double   a1 = (double)config.offset_sd_n;
    return (a0 * a0 * e->P[i][i] + 2.0 * a0 * a1 * e->P[i][i + 1] + a1 * a1 * e->P[i + 1][i + 1]) / (a0 * a0 + a1 * a1);
}

static void test_learning_is_the_filter_of_the_textbook(void)
{
    random_t r              = {11};
    exact_t  exact          = exact_start();
    double   worst_t        = 0.0;
    double   worst_variance = 0.0;
    double   worst_L        = 0.0;
    for (int k = 0; k < RUNS(50000, 10000); k++)
    {
        const uint32_t direction = (uint32_t)(k / 4000) % 2u;
        const double   prior     = (double)(float)random_between(&r, 0.02, 0.2);
        const double   truth     = direction == POSITIVE ? 1.3 * prior : 0.8 * prior + 0.005;
        const double   measured  = (double)(float)(truth + random_between(&r, -0.01, 0.01));
        const double travel = learning_travel_of(random_between(&r, 0.0, k % 100 == 0 ? LEARNING_TRAVEL_MAX_N : 1e-4));
        exact_step(&exact, direction, travel, prior, measured);
        learning_step(&learning, direction, travel, prior, measured);
        for (uint32_t d = 0; d < 2u; d++)
        {
            const learning_seen_t at     = learning_at(&learning, d, prior);
            const double          scale  = exact.t[2 * d];
            const double          offset = exact.t[2 * d + 1];
            const double L      = prior * (1.0 + (double)config.scale_sd * scale) + (double)config.offset_sd_n * offset;
            const double weight = 1.0 - 0.5 * exact_variance(&exact, d, prior);
            worst_t             = fmax(worst_t, fabs(learning_scale(&learning, d) - scale));
            worst_t             = fmax(worst_t, fabs(learning_offset(&learning, d) - offset));
            worst_variance      = fmax(worst_variance, fabs(at.variance - exact_variance(&exact, d, prior)));
            worst_L             = fmax(worst_L, fmax(fabs(at.L - L), fabs(at.weighted - weight * L)));
            TEST_ASSERT_DOUBLE_WITHIN(1e-7, (1.0 - 0.5 * at.variance) * at.L, at.weighted);
        }
    }
    printf("states within %.1e sd, variance within %.1e, L within %.1e N\n", worst_t, worst_variance, worst_L);
    TEST_ASSERT_DOUBLE_WITHIN(LEARNING_TOLERANCE_SD, 0.0, worst_t);
    TEST_ASSERT_DOUBLE_WITHIN(LEARNING_TOLERANCE, 0.0, worst_variance);
    TEST_ASSERT_DOUBLE_WITHIN(LEARNING_TOLERANCE_N, 0.0, worst_L);
}

static void test_nothing_is_known_at_first(void)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        const learning_seen_t at = learning_at(&learning, d, 0.1);
        TEST_ASSERT_DOUBLE_WITHIN(8e-9, 0.1, at.L);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, at.variance);
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.05, at.weighted);
        TEST_ASSERT_FALSE(learning_is_at_bound(&learning, d, 0.1));
    }
}

static void test_one_direction_teaches_the_other_something(void)
{
    for (int k = 0; k < 1000; k++)
    {
        learning_step(&learning, POSITIVE, 1e-4, 0.1, 0.13);
    }
    const learning_seen_t own   = learning_at(&learning, POSITIVE, 0.1);
    const learning_seen_t other = learning_at(&learning, NEGATIVE, 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(5e-4, 0.13, own.L);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.121, other.L); // by the correlation of 0.7
    TEST_ASSERT_TRUE(own.variance < 0.02 && other.variance > 0.4 && other.variance < 0.6);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.1, learning_travel(&learning, POSITIVE));
    TEST_ASSERT_TRUE(learning_travel(&learning, NEGATIVE) == 0.0);
}

static void test_what_was_learned_stays_within_its_bounds_and_says_so(void)
{
    for (int k = 0; k < 100000; k++)
    {
        learning_step(&learning, NEGATIVE, 1e-3, 0.1, 1.9);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 3.0, learning_scale(&learning, NEGATIVE));
    TEST_ASSERT_TRUE(learning_is_at_bound(&learning, NEGATIVE, 0.1));
    TEST_ASSERT_TRUE(learning_at(&learning, NEGATIVE, 0.1).L <= 0.3 + 1e-8);
    // Each bound by itself.
    learning_reset(&learning);
    learning_set(&learning, POSITIVE, 0.0, 3.0);
    TEST_ASSERT_TRUE(learning_is_at_bound(&learning, POSITIVE, 0.1));
    learning_set(&learning, POSITIVE, 0.0, learning_last_offset());
    TEST_ASSERT_FALSE(learning_is_at_bound(&learning, POSITIVE, 0.1));
    learning_set(&learning, POSITIVE, 2.0, learning_last_offset());
    TEST_ASSERT_TRUE(learning_is_at_bound(&learning, POSITIVE, 0.01)); // L over 3 times
    TEST_ASSERT_DOUBLE_WITHIN(8e-9, 0.03, learning_at(&learning, POSITIVE, 0.01).L);
    learning_set(&learning, POSITIVE, -2.0, -1.0);
    TEST_ASSERT_TRUE(learning_is_at_bound(&learning, POSITIVE, 0.02)); // below a fifth
    TEST_ASSERT_DOUBLE_WITHIN(8e-9, 0.2 * 0.02, learning_at(&learning, POSITIVE, 0.02).L);
    learning_set(&learning, POSITIVE, 0.0, -2.0);
    TEST_ASSERT_TRUE(learning_is_at_bound(&learning, POSITIVE, 0.02)); // by the offset alone
    TEST_ASSERT_DOUBLE_WITHIN(8e-9, 0.2 * 0.02, learning_at(&learning, POSITIVE, 0.02).L);
    learning_set(&learning, POSITIVE, -3.0, 0.0);
    TEST_ASSERT_TRUE(learning_is_at_bound(&learning, POSITIVE, 0.1));
}

/// One slide in direction d, in which friction is `measured`.
static void slide(uint32_t d, double measured)
{
    for (int k = 0; k < 1000; k++)
    {
        learning_step(&learning, d, 1e-3, 0.1, measured);
    }
    learning_slide_ends(&learning, d, 0.1);
}

static void test_four_slides_that_end_at_a_bound_are_latched(void)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        learning_reset(&learning);
        for (uint8_t k = 1; k <= 5u; k++)
        {
            slide(d, 1.9);
            TEST_ASSERT_EQUAL_UINT8(k, learning.state.bound_slides[d]);
            TEST_ASSERT_EQUAL_UINT8(k >= 4u, learning.state.stays_at_bound[d]);
            learning_slide_ends(&learning, d, 0.1); // nothing was learned since
            TEST_ASSERT_EQUAL_UINT8(k, learning.state.bound_slides[d]);
        }
        TEST_ASSERT_EQUAL_UINT8(0, learning.state.stays_at_bound[1u - d] + learning.state.bound_slides[1u - d]);
        for (int k = 0; k < 300; k++) // the count stops at its end
        {
            learning_step(&learning, d, 1e-3, 0.1, 1.9);
            learning_slide_ends(&learning, d, 0.1);
        }
        TEST_ASSERT_EQUAL_UINT8(UINT8_MAX, learning.state.bound_slides[d]);

        // Back within the bounds it stays latched, until it is told.
        slide(d, 0.1);
        TEST_ASSERT_EQUAL_UINT8(0, learning.state.bound_slides[d]);
        TEST_ASSERT_EQUAL_UINT8(1, learning.state.stays_at_bound[d]);
        slide(d, 1.9);
        const learning_t before = learning;
        learning_restore(&learning);
        TEST_ASSERT_EQUAL_UINT8(0, learning.state.stays_at_bound[d] + learning.state.bound_slides[d]);
        TEST_ASSERT_EQUAL_MEMORY(before.state.of, learning.state.of, sizeof learning.state.of);
        slide(d, 1.9);
        TEST_ASSERT_EQUAL_UINT8(0, learning.state.stays_at_bound[d]); // counted from anew
    }
    slide(POSITIVE, 1.9);
    learning_reset(&learning);
    TEST_ASSERT_EQUAL_UINT8(0, learning.state.bound_slides[POSITIVE]);
}

/// All that was learned changes places where neither side is taken over, each number of its own.
static void test_a_side_that_is_not_taken_over_is_exchanged_whole(void)
{
    const learning_side_t left   = learning_numbers(&learning, 1, 0.9);
    const learning_side_t across = learning_numbers(&learning, -1, 0.01);
    learning_set_side(&learning, &left);
    learning.state.across = across;
    learning_change_side(&learning);
    const learning_side_t now = learning_side(&learning);
    TEST_ASSERT_EQUAL_MEMORY(&across, &now, sizeof now);
    TEST_ASSERT_EQUAL_MEMORY(&left, &learning.state.across, sizeof left);
}

/// What there is in `x` once r has come to it from where `other` was learned.
static void take_over(learning_t *x, const learning_t *other)
{
    learning_t crossing   = *other;
    crossing.state.across = learning_side(x);
    learning_change_side(&crossing);

    const learning_side_t left = learning_side(other);
    TEST_ASSERT_EQUAL_MEMORY(&left, &crossing.state.across, sizeof left);
    TEST_ASSERT_EQUAL_UINT8(other->state.slid, crossing.state.slid);
    TEST_ASSERT_EQUAL_MEMORY(other->state.bound_slides,
                             crossing.state.bound_slides,
                             sizeof crossing.state.bound_slides);
    crossing.state.across = x->state.across;
    *x                    = crossing;
}

static void test_what_is_better_known_elsewhere_is_taken_over_with_more_variance(void)
{
    learning_t here = learning;
    slide(POSITIVE, 0.14);
    slide(NEGATIVE, 0.08);
    slide(POSITIVE, 0.14);
    const learning_t taught = learning;

    // Nothing is known here, not even whether it was learned from.
    take_over(&here, &taught);
    for (uint32_t d = 0; d < 2u; d++)
    {
        TEST_ASSERT_TRUE(learning_scale(&here, d) == learning_scale(&taught, d));
        TEST_ASSERT_TRUE(learning_offset(&here, d) == learning_offset(&taught, d));
        TEST_ASSERT_TRUE(here.state.of[d].ss == learning_apart(&taught, taught.state.of[d].ss));
        TEST_ASSERT_TRUE(here.state.of[d].so == taught.state.of[d].so);
        TEST_ASSERT_TRUE(here.state.of[d].oo == taught.state.of[d].oo);
        TEST_ASSERT_TRUE(learning_travel(&here, d) == 0.0);
    }
    TEST_ASSERT_EQUAL_MEMORY(taught.state.shared, here.state.shared, sizeof here.state.shared);

    // What is better known here stays where the two differ in both directions,
    for (int sign = -1; sign <= 1; sign += 2)
    {
        for (uint32_t d = 0; d < 2u; d++)
        {
            learning = taught;
            learning_add_scale(&learning, d, sign * 0.1025);
            learning_add_scale(&learning, 1u - d, sign * -0.1025);
            learning_t before = learning;
            take_over(&learning, &taught);
            TEST_ASSERT_EQUAL_MEMORY(&before.state, &learning.state, sizeof learning.state);
            // or as long as the other side has slid in one direction only;
            learning.state.of[d].scale = taught.state.of[d].scale;
            learning_add_scale(&learning, d, sign * 0.0975);
            before           = learning;
            learning_t other = taught;
            learning_forget_travel(&other, d);
            take_over(&learning, &other);
            TEST_ASSERT_EQUAL_MEMORY(&before.state, &learning.state, sizeof learning.state);
            // where they agree in one, both are of one kind, and the other is newer.
            take_over(&learning, &taught);
            TEST_ASSERT_EQUAL_MEMORY(taught.state.of, learning.state.of, sizeof learning.state.of);
        }
    }
}

static void test_no_travel_teaches_nothing(void)
{
    for (int k = 0; k < 100; k++)
    {
        learning_step(&learning, POSITIVE, 1e-4, 0.1, 0.13);
    }
    const learning_t before = learning;
    learning_step(&learning, POSITIVE, 0.0, 0.1, 0.2);
    learning_step(&learning, NEGATIVE, 0.0, 0.05, -0.2);
    TEST_ASSERT_EQUAL_MEMORY(&before.state, &learning.state, sizeof learning.state);
    TEST_ASSERT_DOUBLE_WITHIN(4e-7, 0.01, learning_travel(&learning, POSITIVE));
}

static void test_forgetting_brings_the_priors_variance_back_and_not_more(void)
{
    for (int k = 0; k < 1000; k++)
    {
        learning_step(&learning, POSITIVE, 1e-4, 0.1, 0.13);
    }
    const double left = learning_at(&learning, POSITIVE, 0.1).variance;
    // Learning in the other direction alone.
    for (int k = 0; k < 20000; k++)
    {
        learning_step(&learning, NEGATIVE, 1e-3, 0.1, 0.1);
    }
    const double back = learning_at(&learning, POSITIVE, 0.1).variance;
    printf("relative variance %g after learning, %g after 20 N\n", left, back);
    TEST_ASSERT_TRUE(left < 0.02 && back > 0.8 && back <= 1.00001);
}

static void check(float *field, float value, tribo_status_t status)
{
    const learning_t before = learning;
    const float      kept   = *field;
    *field                  = value;
    TEST_ASSERT_EQUAL_INT(status, learning_init(&learning, &config));
    TEST_ASSERT_EQUAL_MEMORY(&before.params, &learning.params, sizeof learning.params);
    *field = kept;
}

static void test_learning_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, learning_init(NULL, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, learning_init(&learning, NULL));
    check(&config.scale_sd, 0.0f, TRIBO_ERR_LEARNING_SCALE_SD);
    check(&config.offset_sd_n, NAN, TRIBO_ERR_LEARNING_OFFSET_SD);
    check(&config.correlation, 1.0f, TRIBO_ERR_LEARNING_CORRELATION);
    check(&config.correlation_faded, -0.1f, TRIBO_ERR_LEARNING_CORRELATION_FADED);
    check(&config.trust, 1.1f, TRIBO_ERR_LEARNING_TRUST);
    check(&config.trust, -0.1f, TRIBO_ERR_LEARNING_TRUST);
    check(&config.relative_variance, 0.0f, TRIBO_ERR_LEARNING_RELATIVE_VARIANCE);
    check(&config.weight_n, 0.0f, TRIBO_ERR_LEARNING_WEIGHT);
    check(&config.forgetting_per_n, -1.0f, TRIBO_ERR_LEARNING_FORGETTING);
    check(&config.scale_min, 1.1f, TRIBO_ERR_LEARNING_SCALE_MIN);
    check(&config.scale_max, 0.9f, TRIBO_ERR_LEARNING_SCALE_MAX);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_learning_is_the_filter_of_the_textbook);
    RUN_TEST(test_nothing_is_known_at_first);
    RUN_TEST(test_one_direction_teaches_the_other_something);
    RUN_TEST(test_what_was_learned_stays_within_its_bounds_and_says_so);
    RUN_TEST(test_four_slides_that_end_at_a_bound_are_latched);
    RUN_TEST(test_a_side_that_is_not_taken_over_is_exchanged_whole);
    RUN_TEST(test_what_is_better_known_elsewhere_is_taken_over_with_more_variance);
    RUN_TEST(test_no_travel_teaches_nothing);
    RUN_TEST(test_forgetting_brings_the_priors_variance_back_and_not_more);
    RUN_TEST(test_learning_init_names_the_field);
    return UNITY_END();
}
