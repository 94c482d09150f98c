#include "tribo/controller_q31.h"

#include "random.h"
#include "tribo/paper_controller.h"
#include "tribo/quantize_q31.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define FULL_SCALE 2.0f

static const tribo_biquad_f32_section_t paper[] = TRIBO_PAPER_CONTROLLER_F32;
static const tribo_biquad_f32_section_t pi[]    = {TRIBO_BIQUAD_F32(2.0, -1.9, 0.0, -1.0, 0.0)};

static tribo_controller_f32_config_t  config;
static tribo_controller_q31_params_t  params;
static tribo_controller_q31_state_t   state;
static tribo_controller_q31_signals_t seen;
static tribo_headroom_q31_t           headroom;

static void init(const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    config = (tribo_controller_f32_config_t){.sections      = sections,
                                             .section_count = count,
                                             .u_min_n       = -0.5f,
                                             .u_max_n       = 1.0f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_q31_init(&params, &config, FULL_SCALE, &headroom));
    tribo_controller_q31_reset(&state);
}

void setUp(void)
{
    init(paper, 2);
}

void tearDown(void)
{
}

static int32_t q31(double force_n)
{
    return (int32_t)round(force_n / (double)FULL_SCALE * 2147483648.0);
}

static int32_t step(double e, double feedforward)
{
    return tribo_controller_q31_step(&params, &state, q31(e), q31(feedforward), &seen);
}

typedef struct
{
    double b0, b1, b2, a1, a2, w1, w2;
} double_section_t;

/// A tick of the paper's controller in double, limited to -0.5 to 1 N.
static double double_step(double_section_t s[2], double e, double anti_windup)
{
    const double y   = s[0].b0 * e + s[0].w1;
    const double v   = s[1].b0 * y + s[1].w1;
    const double u   = fmin(fmax(v, -0.5), 1.0);
    const double c   = (u - v) * anti_windup;
    const double x[] = {e + c, y + s[0].b0 * c, v + s[1].b0 * s[0].b0 * c};
    for (int i = 0; i < 2; i++)
    {
        s[i].w1 += s[i].b1 * x[i] - s[i].a1 * x[i + 1] + s[i].w2;
        s[i].w2 += s[i].b2 * x[i] - s[i].a2 * x[i + 1];
    }
    return u;
}

// What anti-windup takes back is rounded, and the slow pole remembers it.
static void test_controller_is_that_of_double_after_a_limit(void)
{
    const double anti_windup =
        ldexp(params.anti_windup,
              params.anti_windup_shift - 32 + params.cascade.input_scale - params.cascade.section[1].scale);
    double_section_t s[2];
    double           worst = 0.0;
    for (int i = 0; i < 2; i++)
    {
        s[i] = (double_section_t){.b0 = (double)paper[i].b0,
                                  .b1 = (double)paper[i].b1,
                                  .b2 = (double)paper[i].b2,
                                  .a1 = (double)paper[i].a1,
                                  .a2 = (double)paper[i].a2};
    }
    for (int k = 0; k < 4000; k++)
    {
        const double e = k < 2000 ? 0.25 : 0.0;
        const double u = double_step(s, e, anti_windup);
        worst          = fmax(worst, fabs(step(e, 0.0) / 0x1p31 - u / (double)FULL_SCALE));
    }
    printf("u after a limit: within %.2g of full scale of double's\n", worst);
    TEST_ASSERT_TRUE(state.limited_ticks > 1500u && state.limited_ticks < 2500u);
    TEST_ASSERT_TRUE(worst < 9e-8);
}

static tribo_biquad_f32_section_t random_section(random_t *r)
{
    const double p     = random_between(r, 0.0, 0.98);
    const double angle = random_between(r, 0.0, 3.1);
    const double q     = random_between(r, 0.0, 1.3);
    const double turn  = random_between(r, 0.0, 3.1);
    const double b0    = random_between(r, 0.1, 3.0);
    return (tribo_biquad_f32_section_t)
        TRIBO_BIQUAD_F32(b0, b0 * -2.0 * q * cos(turn), b0 * q * q, -2.0 * p * cos(angle), p * p);
}

/// What the most that a limit may take does at each node, as the controller computes it: it fits, and no less would do.
static void check_taken_max(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        const int64_t taken = sign * (int64_t)params.taken_max;
        int64_t       c     = (taken * params.anti_windup >> 32) * (INT64_C(1) << params.anti_windup_shift);
        int64_t       most  = llabs(c) > llabs(taken) ? llabs(c) : llabs(taken);
        for (uint32_t i = 0; i < params.cascade.count; i++)
        {
            TEST_ASSERT_TRUE(c >= INT32_MIN && c <= INT32_MAX);
            c    = i == 0u ? (c * params.cascade.section[i].b0 >> 32) * 16 : c * params.cascade.section[i].b0 >> 28;
            most = llabs(c) > most ? llabs(c) : most;
        }
        TEST_ASSERT_TRUE(c >= INT32_MIN && c <= INT32_MAX);
        TEST_ASSERT_TRUE((double)most > (0.9999 - 10.0 / params.taken_max) * 0x1p31);
    }
}

// A slow lag before its lead leaves a small node after a large gain.
static void test_controller_bounds_what_a_limit_takes_at_any_gain(void)
{
    const tribo_biquad_f32_section_t lag_and_lead[] = {
        {-0.00693013705f, -0.00796202105f, -0.00228688191f, 0.0014880657f, 5.41637121e-07f},
        {0.278461784f, 0.000387235748f, 1.33695153e-07f, 1.41458213f, 0.4972938f}};
    config = (tribo_controller_f32_config_t){lag_and_lead, 2, -1.0f, 1.0f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_q31_init(&params, &config, 1.0f, NULL));
    TEST_ASSERT_TRUE(params.taken_max < 10000);
    check_taken_max();
}

// Whatever the limits take away and the feedforward adds, no node of the cascade saturates.
static void test_controller_headroom_holds_for_full_scale_inputs_at_its_limits(void)
{
    random_t r    = {77};
    int      runs = 0;
    for (int i = 0; i < 100; i++)
    {
        tribo_biquad_f32_section_t sections[TRIBO_BIQUAD_SECTIONS_MAX];
        const uint32_t             count = 1u + (uint32_t)i % TRIBO_BIQUAD_SECTIONS_MAX;
        for (uint32_t j = 0; j < count; j++)
        {
            sections[j] = random_section(&r);
        }
        sections[0]                 = i % 3 == 0 ? pi[0] : sections[0];
        config                      = (tribo_controller_f32_config_t){sections, count, -0.5f, 1.0f};
        const tribo_status_t status = tribo_controller_q31_init(&params, &config, FULL_SCALE, &headroom);
        if (status != TRIBO_OK)
        {
            continue;
        }
        runs++;
        check_taken_max();
        tribo_controller_q31_reset(&state);
        int32_t e = INT32_MAX;
        int32_t f = INT32_MAX;
        for (int k = 0; k < 3000; k++)
        {
            const uint64_t bits = random_bits(&r);
            e                   = bits % 8u == 0u ? -e : e;
            f                   = bits / 8u % 64u == 0u ? -f : f;
            const int32_t u     = tribo_controller_q31_step(&params, &state, e, f, &seen);
            TEST_ASSERT_TRUE(u >= params.u_min && u <= params.u_max);
        }
        TEST_ASSERT_EQUAL_UINT32(0, state.cascade.saturated);
        TEST_ASSERT_TRUE((double)headroom.input < ldexp(1.0, params.cascade.input_scale));
    }
    TEST_ASSERT_TRUE(runs > 60);
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_controller_takes_whatever_an_input_can_be(void)
{
    const int32_t inputs[] = {INT32_MIN, -INT32_MAX, -1, 0, 1, INT32_MAX};
    random_t      r        = {1};
    for (int k = 0; k < 20000; k++)
    {
        const int32_t e = inputs[random_bits(&r) % 6u];
        const int32_t f = inputs[random_bits(&r) % 6u];
        const int32_t u = tribo_controller_q31_step(&params, &state, e, f, &seen);
        TEST_ASSERT_TRUE(u >= params.u_min && u <= params.u_max);
    }
}

// What is taken from v is 2^31 then, which does not fit: as signed numbers it would change its sign.
static void test_controller_corrects_towards_a_limit_of_0_from_the_very_end(void)
{
    params                       = (tribo_controller_q31_params_t){.u_min             = 0,
                                                                   .u_max             = INT32_MAX,
                                                                   .anti_windup       = 3 << 29, // 3/4
                                                                   .anti_windup_shift = 1,
                                                                   .taken_max         = INT32_MAX};
    params.cascade.count         = 2;
    params.cascade.input_scale   = 2;
    params.cascade.section[0].b0 = 1 << 28; // and no more: w1 is then the corrected output
    state.cascade.section[1].w1  = -(INT64_C(1) << 59);
    TEST_ASSERT_EQUAL_INT32(0, tribo_controller_q31_step(&params, &state, 0, 0, &seen));
    TEST_ASSERT_TRUE(seen.limited);
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, seen.v);
    TEST_ASSERT_EQUAL_UINT32(1, state.cascade.saturated);
    TEST_ASSERT_INT32_WITHIN(16, INT32_MAX / 4 * 3, (int32_t)(state.cascade.section[0].w1 >> 28));
}

// c/D = 3/2, or 3/4 before a gain of 2: beyond full scale, where it must not change its sign.
static void test_controller_bounds_a_correction_and_counts(void)
{
    for (int i = 0; i < 4; i++)
    {
        const int32_t sign           = i % 2 == 0 ? 1 : -1;
        const bool    by_gain        = i / 2 == 1;
        params                       = (tribo_controller_q31_params_t){.anti_windup       = 3 << 29,
                                                                       .anti_windup_shift = by_gain ? 1 : 2,
                                                                       .taken_max         = INT32_MAX / 3 * 2};
        params.cascade.count         = 2;
        params.cascade.input_scale   = 2;
        params.cascade.section[0].b0 = by_gain ? 1 << 29 : 1 << 28; // and no more: w1 is then the corrected output
        tribo_controller_q31_reset(&state);
        TEST_ASSERT_EQUAL_INT32(0, tribo_controller_q31_step(&params, &state, 0, -sign * INT32_MAX, &seen));
        TEST_ASSERT_TRUE(seen.limited);
        TEST_ASSERT_INT32_WITHIN(32, sign * INT32_MAX, (int32_t)(state.cascade.section[0].w1 >> 28));
        TEST_ASSERT_EQUAL_UINT32(1, state.cascade.saturated);
    }
}

static void test_controller_takes_the_very_most_without_counting(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        params                     = (tribo_controller_q31_params_t){.taken_max = 1000, .anti_windup_shift = 1};
        params.cascade.count       = 2;
        params.cascade.input_scale = 2;
        (void)tribo_controller_q31_step(&params, &state, 0, sign * 1000, &seen);
        TEST_ASSERT_TRUE(seen.limited);
        TEST_ASSERT_EQUAL_UINT32(sign < 0 ? 0 : 1, state.cascade.saturated);
        (void)tribo_controller_q31_step(&params, &state, 0, sign * 1001, &seen);
        TEST_ASSERT_EQUAL_UINT32(sign < 0 ? 1 : 2, state.cascade.saturated);
    }
}

static void test_controller_limits_what_a_lost_state_gives(void)
{
    config.u_min_n = -FULL_SCALE;
    config.u_max_n = FULL_SCALE;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_q31_init(&params, &config, FULL_SCALE, NULL));
    TEST_ASSERT_TRUE(ldexp(params.anti_windup, params.anti_windup_shift - 32) > 1.0); // larger than its cause
    for (int sign = -1; sign <= 1; sign += 2)
    {
        tribo_controller_q31_reset(&state);
        for (int i = 0; i < 2; i++)
        {
            state.cascade.section[i].w1 = sign * (INT64_C(1) << 60);
        }
        TEST_ASSERT_EQUAL_INT32(sign < 0 ? params.u_min : params.u_max, step(0.0, 0.0));
        TEST_ASSERT_TRUE(seen.limited);
        TEST_ASSERT_EQUAL_UINT32(1, state.limited_ticks);
        TEST_ASSERT_TRUE(state.cascade.saturated > 1u);
    }
}

static void test_controller_sums_what_is_beyond_full_scale_alone(void)
{
    const double D = (double)paper[0].b0 * (double)paper[1].b0;
    const double u = step(1.9, -1.9) / 2147483648.0 * (double)FULL_SCALE;
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, seen.v); // 1.9 D
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 1.9 * D - 1.9, u);
    TEST_ASSERT_FALSE(seen.limited);
}

// Against 64 bits: v of all sizes, at the limits to the bit and where only v, not v + feedforward, is beyond full scale.
static void test_controller_limits_exactly_the_sum(void)
{
    const int32_t ends[] = {INT32_MIN, -INT32_MAX, -1, 0, 1, INT32_MAX};
    random_t      r      = {4};
    for (uint32_t scale = 0; scale <= 24u; scale++)
    {
        params                          = (tribo_controller_q31_params_t){.anti_windup_shift = 1};
        params.cascade.count            = 2;
        params.cascade.input_scale      = 2; // an e of whole fours comes through to the bit
        params.cascade.section[0].b0    = INT32_C(1) << 28;
        params.cascade.section[1].b0    = INT32_C(1) << (scale == 0u ? 29 : 28);
        params.cascade.section[1].scale = (uint8_t)scale;
        for (int k = 0; k < 2000; k++)
        {
            const bool widest   = random_bits(&r) % 4u == 0u;
            params.u_min        = widest ? -INT32_MAX : -(int32_t)(random_bits(&r) % 2147483647u);
            params.u_max        = widest ? INT32_MAX : (int32_t)(random_bits(&r) % 2147483647u);
            const int32_t limit = random_bits(&r) % 2u == 0u ? params.u_min : params.u_max;
            const int32_t node  = (int32_t)(uint32_t)random_bits(&r) >> (random_bits(&r) % 2u == 0u ? scale : 0u) >> 2;
            const int32_t e     = node * 4;
            const int64_t v     = (int64_t)(scale == 0u ? node * 2 : node) * (INT32_C(1) << scale);
            const int64_t to_meet = limit - v + (int64_t)(random_bits(&r) % 3u) - 1;
            const bool    meets   = to_meet >= INT32_MIN && to_meet <= INT32_MAX;
            const int32_t added   = meets ? (int32_t)to_meet : ends[random_bits(&r) % 6u];
            const int64_t sum     = v + added;
            const int64_t u       = sum < params.u_min ? params.u_min : (sum > params.u_max ? params.u_max : sum);
            tribo_controller_q31_reset(&state);
            TEST_ASSERT_EQUAL_INT64(u, tribo_controller_q31_step(&params, &state, e, added, &seen));
            TEST_ASSERT_EQUAL_INT(u != sum, seen.limited);
            TEST_ASSERT_EQUAL_UINT32(u != sum, state.limited_ticks);
            TEST_ASSERT_EQUAL_INT64(v > INT32_MAX ? INT32_MAX : (v < INT32_MIN ? INT32_MIN : v), seen.v);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_controller_is_that_of_double_after_a_limit);
    RUN_TEST(test_controller_bounds_what_a_limit_takes_at_any_gain);
    RUN_TEST(test_controller_headroom_holds_for_full_scale_inputs_at_its_limits);
    RUN_TEST(test_controller_takes_whatever_an_input_can_be);
    RUN_TEST(test_controller_corrects_towards_a_limit_of_0_from_the_very_end);
    RUN_TEST(test_controller_bounds_a_correction_and_counts);
    RUN_TEST(test_controller_takes_the_very_most_without_counting);
    RUN_TEST(test_controller_limits_what_a_lost_state_gives);
    RUN_TEST(test_controller_sums_what_is_beyond_full_scale_alone);
    RUN_TEST(test_controller_limits_exactly_the_sum);
    return UNITY_END();
}
