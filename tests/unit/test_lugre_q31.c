// What only the Q31 arithmetic has. What both promise: tests/contract/test_lugre.c.

#include "friction/arm_f32.h"
#include "friction/lugre_f32.h"
#include "friction/lugre_q31.h"
#include "tribo/force_loop_f32.h"
#include "tribo/friction_q31.h"

#include "lugre_paper.h"
#include "random.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define H          1.0e-3f
#define FULL_SCALE 2.0f

static tribo_lugre_f32_config_t     config;
static tribo_arm_f32_config_t       arm_config;
static tribo_friction_f32_config_t  law;
static tribo_friction_f32_params_t  friction_f32;
static tribo_friction_q31_params_t  friction;
static tribo_breakaway_point_q31_t  table[2];
static tribo_lugre_q31_params_t     params;
static tribo_lugre_q31_state_t      state;
static tribo_friction_q31_signals_t seen;
static tribo_lugre_f32_params_t     params_f32;
static tribo_lugre_f32_state_t      state_f32;
static tribo_friction_f32_signals_t seen_f32;
static tribo_arm_f32_params_t       arm_params;
static tribo_arm_f32_state_t        arm;

static void init_at(float h)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_lugre_q31_init(&params, &config, &arm_config, h));
    law.pulse_width_s = h; // not read
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_q31_init(&friction, table, &law, h, FULL_SCALE));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&friction_f32, &law, h));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_lugre_f32_init(&params_f32, &config, &arm_config, h));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_f32_init(&arm_params, &arm_config, h));
    tribo_lugre_q31_reset(&state);
    tribo_lugre_f32_reset(&state_f32);
    tribo_arm_f32_reset(&arm);
}

void setUp(void)
{
    config     = lugre_paper();
    arm_config = tribo_force_loop_f32_paper().compensator.arm;
    law        = tribo_force_loop_f32_paper().compensator.friction;
    init_at(H);
}

void tearDown(void)
{
}

static int32_t q31(double force_n)
{
    return (int32_t)round(force_n / (double)FULL_SCALE * 2147483648.0);
}

static double newton(int32_t x)
{
    return x / 2147483648.0 * (double)FULL_SCALE;
}

/// Both modules with the same u and F, the arm driven by the f32 one. Returns how far f is apart.
static double difference(float u)
{
    const float  f = tribo_lugre_f32_step(&params_f32, &friction_f32, &state_f32, u, arm.force_n, &seen_f32);
    const double g =
        newton(tribo_lugre_q31_step(&params, &friction, &state, q31((double)u), q31((double)arm.force_n), &seen));
    arm_f32_step(&arm_params, &arm, seen_f32.n_n - f);
    return fabs((double)f - g);
}

static void test_it_does_what_the_f32_module_does(void)
{
    double largest = 0.0;
    for (int k = 0; k < 20000; k++)
    {
        largest = fmax(largest, difference(0.3f * sinf(0.001f * (float)k) + 0.1f * sinf(0.013f * (float)k)));
    }
    printf("paper's parameters: f within %.2e N of f32\n", largest);
    TEST_ASSERT_TRUE(largest < 2e-7);
}

static void test_soft_bristles_too(void)
{
    config.stiffness = 200.0f;
    config.damping   = 0.3f;
    config.viscous   = 0.1f;
    init_at(1.0e-4f);
    double largest = 0.0;
    for (int k = 0; k < 20000; k++)
    {
        largest = fmax(largest, difference(0.3f * sinf(0.001f * (float)k)));
    }
    printf("soft bristles: f within %.2e N of f32\n", largest);
    TEST_ASSERT_TRUE(largest < 5e-7);
}

/// Bristles, momentum and net force at their largest, where sums need more than 32 bits: from any state as the f32 module.
static void test_far_stretched_bristles_too(void)
{
    static const float stiffness[] = {1.0f, 30.0f, 1.0e3f, 1.0e5f, 1.0e8f};

    random_t random       = {17};
    int      beyond       = 0; // stretches that do not fit
    int      free         = 0; // not at L
    law.positive.offset_n = 1.9f;
    law.negative.offset_n = 1.9f;
    arm_config.inertia *= 100.0f; // keeps its momentum
    for (int i = 0; i < 5; i++)
    {
        config.stiffness = stiffness[i];
        config.damping   = 0.0f;
        init_at(H);
        for (int k = 0; k < 5000; k++)
        {
            const float u     = (float)random_between(&random, -1.9, 1.9);
            state.bristle     = q31(random_between(&random, -1.9, 1.9));
            state.drive       = q31(random_between(&random, -1.9, 1.9));
            state_f32         = (tribo_lugre_f32_state_t){.bristle_n = (float)newton(state.bristle),
                                                          .drive_n   = (float)newton(state.drive)};
            const double most = (double)u + (double)params_f32.gamma_g * newton(state.drive) - newton(state.bristle);
            const double f = (double)tribo_lugre_f32_step(&params_f32, &friction_f32, &state_f32, u, 0.0f, &seen_f32);
            const double g = newton(tribo_lugre_q31_step(&params, &friction, &state, q31((double)u), 0, &seen));
            TEST_ASSERT_DOUBLE_WITHIN(5e-6, f, g);
            if (fabs((double)state_f32.drive_n) < 1.99)
            {
                TEST_ASSERT_DOUBLE_WITHIN(5e-6, (double)state_f32.drive_n, newton(state.drive));
                // Of the stiffest, c r has 8,000 times the rounding of r in f32.
                TEST_ASSERT_DOUBLE_WITHIN(i < 4 ? 5e-6 : 2e-4, (double)state_f32.bristle_n, newton(state.bristle));
            }
            beyond += fabs(most) > 4.0;
            free += fabs(f) < 1.8;
        }
    }
    printf("%d stretches beyond 32 bits, %d not at L\n", beyond, free);
    TEST_ASSERT_TRUE(beyond > 100 && free > 1000);
}

static void test_directions_of_their_own_too(void)
{
    law.negative = (tribo_breakaway_f32_t){.offset_n = 0.02f, .slope = 0.5f};
    init_at(H);
    double largest = 0.0;
    for (int k = 0; k < 20000; k++)
    {
        largest = fmax(largest, difference(0.3f * sinf(0.001f * (float)k) + 0.1f * sinf(0.013f * (float)k)));
    }
    TEST_ASSERT_TRUE(largest < 2e-7);
}

static void test_breakaway_beyond_full_scale_is_full_scale(void)
{
    law.negative = (tribo_breakaway_f32_t){.offset_n = 0.02f, .slope = 2.0f};
    init_at(H);
    for (int k = 0; k < 5; k++)
    {
        (void)tribo_lugre_q31_step(&params, &friction, &state, q31(-0.9), q31(0.1), &seen);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, -0.22, newton(seen.f));
    TEST_ASSERT_EQUAL_INT32(seen.L, -seen.f);
    // 0.02 + 2 * 1.5 N is beyond full scale.
    (void)tribo_lugre_q31_step(&params, &friction, &state, q31(-1.0), q31(1.5), &seen);
    TEST_ASSERT_EQUAL_INT32(TRIBO_Q31_MAX, seen.L);
}

static void test_any_input_and_any_accepted_params_keep_friction_and_bristles_within_breakaway(void)
{
    random_t seed     = {7};
    int      accepted = 0;
    for (int i = 0; i < 400; i++)
    {
        config.stiffness      = (float)pow(10.0, random_between(&seed, -3.8, 8.0));
        config.damping        = config.stiffness * (float)pow(10.0, random_between(&seed, -6.0, 0.0));
        config.viscous        = (float)pow(10.0, random_between(&seed, -3.0, 2.0));
        law.positive.offset_n = (float)pow(10.0, random_between(&seed, -5.0, 0.2));
        law.negative.slope    = (float)random_between(&seed, 0.0, 10.0);
        if (i % 10 == 0)
        {
            config.damping = config.viscous = 0.0f;
        }
        if (tribo_lugre_q31_init(&params, &config, &arm_config, H) != TRIBO_OK ||
            tribo_friction_q31_init(&friction, NULL, &law, H, FULL_SCALE) != TRIBO_OK)
        {
            continue;
        }
        accepted++;
        tribo_lugre_q31_reset(&state);
        uint32_t largest = 0;
        for (int k = 0; k < 300; k++)
        {
            const uint64_t bits = random_bits(&seed);
            const int32_t  u    = k % 4 == 0 ? (int32_t)(uint32_t)bits : (int32_t)(uint32_t)bits >> 20;
            const int32_t  F    = k % 8 == 0 ? (int32_t)(uint32_t)(bits >> 32) : (int32_t)(uint32_t)(bits >> 32) >> 18;
            const int32_t  f    = tribo_lugre_q31_step(&params, &friction, &state, u, F, &seen);
            TEST_ASSERT_TRUE(tribo_q31_magnitude(f) <= (uint32_t)seen.L);
            for (unsigned side = 0; side < 2; side++)
            {
                const tribo_breakaway_f32_t *const of   = side == 0 ? &law.positive : &law.negative;
                const double                       load = tribo_q31_magnitude(F);
                const double L    = (double)of->offset_n / (double)FULL_SCALE * 2147483648.0 + (double)of->slope * load;
                const double most = fmin(L * 1.0000001 + 2.0, 2147483647.0);
                largest           = (uint32_t)most > largest ? (uint32_t)most : largest;
            }
            TEST_ASSERT_TRUE(tribo_q31_magnitude(state.bristle) <= largest);
        }
    }
    printf("%d params\n", accepted);
    TEST_ASSERT_TRUE(accepted > 150);
}

static void test_a_net_force_beyond_full_scale_is_clamped_and_counted(void)
{
    (void)tribo_lugre_q31_step(&params, &friction, &state, TRIBO_Q31_MAX, -TRIBO_Q31_MAX, &seen);
    TEST_ASSERT_EQUAL_INT32(TRIBO_Q31_MAX, seen.n);
    TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
}

static void test_it_stands_to_the_last_bit(void)
{
    for (int k = 0; k < 2000; k++)
    {
        (void)tribo_lugre_q31_step(&params, &friction, &state, 1000, 0, &seen);
    }
    const tribo_lugre_q31_state_t before = state;
    (void)tribo_lugre_q31_step(&params, &friction, &state, 1000, 0, &seen);
    TEST_ASSERT_EQUAL_INT32(before.bristle, state.bristle);
    TEST_ASSERT_EQUAL_INT32(0, state.drive);
    TEST_ASSERT_EQUAL_INT32(1000, seen.f);
}

/// Whatever bits Z and r have, friction is within breakaway, and Z comes back within it.
static void test_any_state_is_left_within_breakaway(void)
{
    static const int32_t ends[] = {INT32_MIN, INT32_MIN + 1, -1, 0, 1, TRIBO_Q31_MAX};
    for (unsigned i = 0; i < 36; i++)
    {
        state.bristle = ends[i / 6u];
        state.drive   = ends[i % 6u];
        for (int k = 0; k < 2000; k++)
        {
            const int32_t f =
                tribo_lugre_q31_step(&params, &friction, &state, q31(k % 400 < 200 ? 0.3 : -0.3), 0, &seen);
            TEST_ASSERT_TRUE(tribo_q31_magnitude(f) <= (uint32_t)seen.L);
        }
        TEST_ASSERT_TRUE(tribo_q31_magnitude(state.bristle) <= (uint32_t)seen.L);
    }
}

static void test_reset_is_at_rest(void)
{
    (void)tribo_lugre_q31_step(&params, &friction, &state, TRIBO_Q31_MAX, -TRIBO_Q31_MAX, &seen);
    tribo_lugre_q31_reset(&state);
    TEST_ASSERT_EQUAL_INT32(0, state.bristle);
    TEST_ASSERT_EQUAL_INT32(0, state.drive);
    TEST_ASSERT_EQUAL_UINT32(0, state.saturated);
}

static void expect(tribo_status_t status)
{
    tribo_lugre_q31_params_t before;
    memset(&before, 0x5a, sizeof before);
    params = before;
    TEST_ASSERT_EQUAL_INT(status, tribo_lugre_q31_init(&params, &config, &arm_config, H));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof before);
    config = lugre_paper();
}

static void test_init_names_the_field_that_is_wrong(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_lugre_q31_init(NULL, &config, &arm_config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_lugre_q31_init(&params, NULL, &arm_config, H));
    config.stiffness = 1.0e8f; // c = 7e5
    config.damping   = 1.0e6f;
    expect(TRIBO_ERR_BRISTLE_DAMPING);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_it_does_what_the_f32_module_does);
    RUN_TEST(test_soft_bristles_too);
    RUN_TEST(test_far_stretched_bristles_too);
    RUN_TEST(test_directions_of_their_own_too);
    RUN_TEST(test_breakaway_beyond_full_scale_is_full_scale);
    RUN_TEST(test_any_input_and_any_accepted_params_keep_friction_and_bristles_within_breakaway);
    RUN_TEST(test_a_net_force_beyond_full_scale_is_clamped_and_counted);
    RUN_TEST(test_it_stands_to_the_last_bit);
    RUN_TEST(test_any_state_is_left_within_breakaway);
    RUN_TEST(test_reset_is_at_rest);
    RUN_TEST(test_init_names_the_field_that_is_wrong);
    return UNITY_END();
}
