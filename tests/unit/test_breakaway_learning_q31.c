#include "tribo/breakaway_learning_q31.h"

#include "random.h"
#include "runs.h"
#include "tribo/quantize_feedforward_q31.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define POSITIVE TRIBO_BREAKAWAY_POSITIVE
#define NEGATIVE TRIBO_BREAKAWAY_NEGATIVE
#define FS       2.0
#define UNIT     (FS / 536870912.0) // N

static tribo_breakaway_learning_f32_config_t config;
static tribo_breakaway_learning_q31_params_t params;
static tribo_breakaway_learning_q31_state_t  learning;

void setUp(void)
{
    config = tribo_breakaway_learning_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_breakaway_learning_q31_init(&params, &config, (float)FS));
    tribo_breakaway_learning_q31_reset(&params, &learning);
}

void tearDown(void)
{
}

static uint32_t units(double force_n)
{
    return (uint32_t)lround(force_n / UNIT);
}

static tribo_breakaway_learning_q31_signals_t at(uint32_t direction, double prior)
{
    return tribo_breakaway_learning_q31_at(&params, &learning, direction, units(prior));
}

static void teach(uint32_t direction, double travel, double prior, double measured)
{
    tribo_breakaway_learning_q31_step(&params,
                                      &learning,
                                      direction,
                                      units(travel),
                                      units(prior),
                                      (int32_t)lround(measured / UNIT));
}

static void test_learning_follows_its_twin(void)
{
    tribo_breakaway_learning_f32_params_t twin_params;
    tribo_breakaway_learning_f32_state_t  twin;
    random_t                              r           = {11};
    double                                worst_L     = 0.0;
    double                                worst_doubt = 0.0;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_breakaway_learning_f32_init(&twin_params, &config));
    tribo_breakaway_learning_f32_reset(&twin_params, &twin);
    for (int k = 0; k < RUNS(50000, 10000); k++)
    {
        const uint32_t direction = (uint32_t)(k / 4000) % 2u;
        const double   prior     = random_between(&r, 0.02, 0.2);
        const double   truth     = direction == POSITIVE ? 1.3 * prior : 0.8 * prior + 0.005;
        const double   measured  = truth + random_between(&r, -0.01, 0.01);
        const double   travel    = random_between(&r, 0.0, 1e-4);
        teach(direction, travel, prior, measured);
        tribo_breakaway_learning_f32_step(&twin_params, &twin, direction, (float)travel, (float)prior, (float)measured);
        for (uint32_t d = 0; d < 2u; d++)
        {
            const tribo_breakaway_learning_q31_signals_t a = at(d, prior);
            const tribo_breakaway_learning_f32_signals_t b =
                tribo_breakaway_learning_f32_at(&twin_params, &twin, d, (float)prior);
            worst_L     = fmax(worst_L, fabs(a.L * UNIT - (double)b.L_n));
            worst_L     = fmax(worst_L, fabs(a.weighted * UNIT - (double)b.weighted_n));
            worst_doubt = fmax(worst_doubt, fabs(a.doubt / 2147483648.0 - (double)b.doubt));
        }
    }
    printf("L within %.1e N, doubt within %.1e\n", worst_L, worst_doubt);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.0, worst_L);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, worst_doubt);
}

static void test_nothing_is_known_at_first(void)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        TEST_ASSERT_UINT32_WITHIN(2, units(0.1), at(d, 0.1).L);
        TEST_ASSERT_UINT32_WITHIN(128, UINT32_C(1) << 31, at(d, 0.1).doubt);
        TEST_ASSERT_UINT32_WITHIN(4, units(0.05), at(d, 0.1).weighted);
        TEST_ASSERT_FALSE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, d, units(0.1)));
    }
}

static void test_learning_takes_extremes_without_leaving_its_ranges(void)
{
    random_t       r        = {12};
    const uint32_t prior[]  = {0, 1, 2, 1000, 1u << 20, (1u << 29) - 1u, 1u << 29, UINT32_MAX};
    const int32_t  z[]      = {INT32_MIN, INT32_MAX, 0, 1, -1, 1 << 30, 1 << 20};
    const uint32_t travel[] = {0, 1, 1000, 1u << 20, UINT32_MAX};
    for (int k = 0; k < RUNS(200000, 20000); k++)
    {
        const uint32_t p = prior[random_bits(&r) % 8u];
        tribo_breakaway_learning_q31_step(&params,
                                          &learning,
                                          (uint32_t)random_bits(&r) % 2u,
                                          travel[random_bits(&r) % 5u],
                                          p,
                                          z[random_bits(&r) % 7u]);
        for (uint32_t d = 0; d < 2u; d++)
        {
            const tribo_breakaway_learned_q31_t *of = &learning.of[d];
            TEST_ASSERT_TRUE(of->scale <= 3 << 28 && of->scale >= -(3 << 28));
            TEST_ASSERT_TRUE(of->offset <= 3 << 28 && of->offset >= -(3 << 28));
            TEST_ASSERT_TRUE(of->ss <= (1 << 30) + 64 && of->ss >= -64 && of->oo <= (1 << 30) + 64 && of->oo >= -64);
            const tribo_breakaway_learning_q31_signals_t s = tribo_breakaway_learning_q31_at(&params, &learning, d, p);
            TEST_ASSERT_TRUE(s.L <= 1u << 29 && s.weighted <= s.L && s.doubt < 1u << 31);
        }
    }
}

static void test_what_was_learned_stays_within_its_bounds_and_says_so(void)
{
    for (int k = 0; k < 100000; k++)
    {
        teach(NEGATIVE, 1e-3, 0.1, 1.9);
    }
    TEST_ASSERT_EQUAL_INT32(3 << 28, learning.of[NEGATIVE].scale);
    TEST_ASSERT_TRUE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, NEGATIVE, units(0.1)));
    TEST_ASSERT_TRUE(at(NEGATIVE, 0.1).L <= units(0.3));
    tribo_breakaway_learning_q31_reset(&params, &learning);
    learning.of[POSITIVE].offset = 3 << 28;
    TEST_ASSERT_TRUE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, POSITIVE, units(0.1)));
    learning.of[POSITIVE].offset = (3 << 28) - 1;
    TEST_ASSERT_FALSE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, POSITIVE, units(0.1)));
    learning.of[POSITIVE].scale = (3 << 28) - 1; // L over 3 times: 1 + 3 0.4 + 3 0.9
    TEST_ASSERT_TRUE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, POSITIVE, units(0.011)));
    TEST_ASSERT_UINT32_WITHIN(2, 3u * units(0.011), at(POSITIVE, 0.011).L);
    learning.of[POSITIVE].scale  = -(2 << 28);
    learning.of[POSITIVE].offset = -(1 << 28);
    TEST_ASSERT_TRUE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, POSITIVE, units(0.02)));
    TEST_ASSERT_UINT32_WITHIN(2, units(0.2 * 0.02), at(POSITIVE, 0.02).L);
    TEST_ASSERT_FALSE(tribo_breakaway_learning_q31_is_at_bound(&params, &learning, NEGATIVE, UINT32_MAX));
    TEST_ASSERT_EQUAL_UINT32(at(NEGATIVE, 1.99).L > 0u, 1);
    learning.of[NEGATIVE].scale = 3 << 27;
    TEST_ASSERT_EQUAL_UINT32(1u << 29, tribo_breakaway_learning_q31_at(&params, &learning, NEGATIVE, UINT32_MAX).L);
}

static void test_doubt_ends_at_1_whatever_the_covariance(void)
{
    for (int32_t ss = INT32_C(1) << 30; ss > 0; ss /= 2)
    {
        learning.of[POSITIVE].ss = INT32_MAX - ss + 1;
        learning.of[POSITIVE].oo = INT32_MAX;
        TEST_ASSERT_UINT32_WITHIN(256, INT32_MAX, at(POSITIVE, 0.1).doubt);
        TEST_ASSERT_UINT32_WITHIN(2, (uint32_t)(at(POSITIVE, 0.1).L * (1.0 - 0.5)), at(POSITIVE, 0.1).weighted);
    }
}

/// One slide in direction d, in which friction is `measured`.
static void slide(uint32_t d, double measured)
{
    for (int k = 0; k < 1000; k++)
    {
        teach(d, 1e-3, 0.1, measured);
    }
    tribo_breakaway_learning_q31_slide_ends(&params, &learning, d, units(0.1));
}

static void test_four_slides_that_end_at_a_bound_are_latched(void)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        tribo_breakaway_learning_q31_reset(&params, &learning);
        for (uint8_t k = 1; k <= 5u; k++)
        {
            slide(d, 1.9);
            TEST_ASSERT_EQUAL_UINT8(k, learning.bound_slides[d]);
            TEST_ASSERT_EQUAL_UINT8(k >= 4u, learning.stays_at_bound[d]);
            tribo_breakaway_learning_q31_slide_ends(&params, &learning, d, units(0.1)); // nothing was learned since
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
        const tribo_breakaway_learning_q31_state_t before = learning;
        tribo_breakaway_learning_q31_restore(&learning);
        TEST_ASSERT_EQUAL_UINT8(0, learning.stays_at_bound[d] + learning.bound_slides[d]);
        TEST_ASSERT_EQUAL_MEMORY(before.of, learning.of, sizeof learning.of);
        slide(d, 1.9);
        TEST_ASSERT_EQUAL_UINT8(0, learning.stays_at_bound[d]); // counted from anew
    }
    slide(POSITIVE, 1.9);
    tribo_breakaway_learning_q31_reset(&params, &learning);
    TEST_ASSERT_EQUAL_UINT8(0, learning.bound_slides[POSITIVE]);
}

/// As if learned on the side that is left.
static tribo_breakaway_across_q31_t side_of(const tribo_breakaway_learning_q31_state_t *state)
{
    tribo_breakaway_across_q31_t side;
    for (uint32_t d = 0; d < 2u; d++)
    {
        side.of[d]          = state->of[d];
        side.shared[d]      = state->shared[d];
        side.shared[2u + d] = state->shared[2u + d];
        side.travel[d]      = state->travel[d];
    }
    return side;
}

/// All that was learned changes places where neither side is taken over, each number of its own.
static void test_a_side_that_is_not_taken_over_is_exchanged_whole(void)
{
    for (uint32_t d = 0; d < 2u; d++)
    {
        const int32_t of        = (int32_t)d;
        learning.of[d]          = (tribo_breakaway_learned_q31_t){1 << 28, 20 + of, 900000000 + of, 50 + of, 60 + of};
        learning.shared[d]      = 30 + of;
        learning.shared[2u + d] = 40 + of;
        learning.travel[d]      = 5u + d;
        learning.across.of[d] = (tribo_breakaway_learned_q31_t){-(1 << 28), -20 + of, 10000000 + of, -50 + of, 70 + of};
        learning.across.shared[d]      = -30 + of;
        learning.across.shared[2u + d] = -40 + of;
        learning.across.travel[d]      = 7u + d;
    }
    const tribo_breakaway_across_q31_t left   = side_of(&learning);
    const tribo_breakaway_across_q31_t across = learning.across;
    tribo_breakaway_learning_q31_change_side(&learning);
    const tribo_breakaway_across_q31_t now = side_of(&learning);
    TEST_ASSERT_EQUAL_MEMORY(&across, &now, sizeof now);
    TEST_ASSERT_EQUAL_MEMORY(&left, &learning.across, sizeof left);
}

/// What there is in `state` once r has come to it from where `other` was learned.
static void take_over(tribo_breakaway_learning_q31_state_t *state, const tribo_breakaway_learning_q31_state_t *other)
{
    tribo_breakaway_learning_q31_state_t crossing = *other;
    crossing.across                               = side_of(state);
    tribo_breakaway_learning_q31_change_side(&crossing);

    const tribo_breakaway_across_q31_t left = side_of(other);
    TEST_ASSERT_EQUAL_MEMORY(&left, &crossing.across, sizeof left);
    TEST_ASSERT_EQUAL_UINT8(other->slid, crossing.slid);
    TEST_ASSERT_EQUAL_MEMORY(other->bound_slides, crossing.bound_slides, sizeof crossing.bound_slides);
    crossing.across = state->across;
    *state          = crossing;
}

static void test_what_is_better_known_elsewhere_is_taken_over_with_more_doubt(void)
{
    tribo_breakaway_learning_q31_state_t here = learning;
    slide(POSITIVE, 0.14);
    slide(NEGATIVE, 0.08);
    slide(POSITIVE, 0.14);
    const tribo_breakaway_learning_q31_state_t taught = learning;

    // Nothing is known here, not even whether it was learned from.
    take_over(&here, &taught);
    for (uint32_t d = 0; d < 2u; d++)
    {
        TEST_ASSERT_EQUAL_INT32(taught.of[d].scale, here.of[d].scale);
        TEST_ASSERT_EQUAL_INT32(taught.of[d].offset, here.of[d].offset);
        TEST_ASSERT_EQUAL_INT32(taught.of[d].ss + (INT32_C(1) << 28), here.of[d].ss);
        TEST_ASSERT_EQUAL_INT32(taught.of[d].so, here.of[d].so);
        TEST_ASSERT_EQUAL_INT32(taught.of[d].oo, here.of[d].oo);
        TEST_ASSERT_TRUE(here.travel[d] == 0);
    }
    TEST_ASSERT_EQUAL_MEMORY(taught.shared, here.shared, sizeof here.shared);

    // What is better known here stays where the two differ in both directions,
    for (int way = -1; way <= 1; way += 2)
    {
        for (uint32_t d = 0; d < 2u; d++)
        {
            learning = taught;
            learning.of[d].scale += way * 27500000;
            learning.of[1u - d].scale -= way * 27500000;
            tribo_breakaway_learning_q31_state_t before = learning;
            take_over(&learning, &taught);
            TEST_ASSERT_EQUAL_MEMORY(&before, &learning, sizeof learning);
            // or as long as the other side has slid one way only;
            learning.of[d].scale                       = taught.of[d].scale + way * 26000000;
            before                                     = learning;
            tribo_breakaway_learning_q31_state_t other = taught;
            other.travel[d]                            = 0;
            take_over(&learning, &other);
            TEST_ASSERT_EQUAL_MEMORY(&before, &learning, sizeof learning);
            // where they agree in one, both are of one kind, and the other is newer.
            take_over(&learning, &taught);
            TEST_ASSERT_EQUAL_MEMORY(taught.of, learning.of, sizeof learning.of);
        }
    }
}

static void test_no_travel_teaches_nothing(void)
{
    for (int k = 0; k < 100; k++)
    {
        teach(POSITIVE, 1e-4, 0.1, 0.13);
    }
    const tribo_breakaway_learning_q31_state_t before = learning;
    teach(POSITIVE, 0.0, 0.1, 0.2);
    teach(NEGATIVE, 0.0, 0.05, -0.2);
    TEST_ASSERT_EQUAL_MEMORY(&before, &learning, sizeof learning);
    TEST_ASSERT_EQUAL_UINT64(100u * units(1e-4), learning.travel[POSITIVE]);
}

static void check(float *field, float value, tribo_status_t status)
{
    const tribo_breakaway_learning_q31_params_t before = params;
    const float                                 kept   = *field;
    *field                                             = value;
    TEST_ASSERT_EQUAL_INT(status, tribo_breakaway_learning_q31_init(&params, &config, (float)FS));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    *field = kept;
}

static void test_learning_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_breakaway_learning_q31_init(NULL, &config, (float)FS));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_breakaway_learning_q31_init(&params, NULL, (float)FS));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_FULL_SCALE, tribo_breakaway_learning_q31_init(&params, &config, 0.0f));
    check(&config.spread_scale, 1.1f, TRIBO_ERR_LEARNING_SPREAD);
    check(&config.spread_offset_n, 1e-6f, TRIBO_ERR_LEARNING_SPREAD);
    check(&config.spread_offset_n, 0.6f, TRIBO_ERR_LEARNING_SPREAD);
    check(&config.weight_n, 1e-6f, TRIBO_ERR_LEARNING_WEIGHT);
    check(&config.weight_n, 0.2f, TRIBO_ERR_LEARNING_WEIGHT);
    check(&config.forgetting_per_n, 17.0f, TRIBO_ERR_LEARNING_FORGETTING);
    check(&config.trust, -0.1f, TRIBO_ERR_LEARNING_TRUST);
    check(&config.doubt, 0.0f, TRIBO_ERR_LEARNING_TRUST);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_learning_follows_its_twin);
    RUN_TEST(test_nothing_is_known_at_first);
    RUN_TEST(test_learning_takes_extremes_without_leaving_its_ranges);
    RUN_TEST(test_what_was_learned_stays_within_its_bounds_and_says_so);
    RUN_TEST(test_doubt_ends_at_1_whatever_the_covariance);
    RUN_TEST(test_four_slides_that_end_at_a_bound_are_latched);
    RUN_TEST(test_what_is_better_known_elsewhere_is_taken_over_with_more_doubt);
    RUN_TEST(test_no_travel_teaches_nothing);
    RUN_TEST(test_learning_init_names_the_field);
    RUN_TEST(test_a_side_that_is_not_taken_over_is_exchanged_whole);
    return UNITY_END();
}
