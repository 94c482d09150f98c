// What only the f32 arithmetic has. What both promise: tests/contract/test_arm.c.

#include "friction/arm_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/friction_f32.h"

#include "random.h"
#include "same.h"
#include "unity.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define H 1.0e-3f

static tribo_arm_f32_config_t config;
static tribo_arm_f32_params_t params;
static tribo_arm_f32_state_t  state;

void setUp(void)
{
    config = tribo_force_loop_f32_paper().compensator.arm;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_f32_init(&params, &config, H));
    tribo_arm_f32_reset(&state);
}

static float step(float drive_n)
{
    tribo_arm_f32_step(&params, &state, drive_n);
    return state.force_n;
}

typedef struct
{
    double phi_d, phi_g, gamma_d, gamma_g;
} exact_t;

/// The zero-order-hold solution from the roots of s^2 + b h/I s + K h^2/I, s in 1/tick, in double.
static exact_t exact(double stiffness, double damping)
{
    const double complex root = csqrt(damping * damping / 4.0 - stiffness);
    const double complex s1   = -damping / 2.0 + root;
    const double complex s2   = -damping / 2.0 - root;
    const double complex e1   = cexp(s1);
    const double complex e2   = cexp(s2);
    exact_t              x;
    x.phi_g   = creal((e1 - e2) / (s1 - s2));
    x.phi_d   = 1.0 - creal((s1 * e2 - s2 * e1) / (s1 - s2));
    x.gamma_d = stiffness * x.phi_g;
    x.gamma_g = creal((s1 * e1 - s2 * e2) / (s1 - s2));
    return x;
}

static void test_arm_discretisation_is_exact_for_the_papers_arm(void)
{
    const exact_t x = exact(3.84 / 1.2e-4 * 1e-6, 0.0288 / 1.2e-4 * 1e-3);
    TEST_ASSERT_DOUBLE_WITHIN(2e-7 * x.phi_d, x.phi_d, (double)params.phi_d);
    TEST_ASSERT_DOUBLE_WITHIN(2e-7, x.phi_g, (double)params.phi_g);
    TEST_ASSERT_DOUBLE_WITHIN(2e-7 * x.gamma_d, x.gamma_d, (double)params.gamma_d);
    TEST_ASSERT_DOUBLE_WITHIN(2e-7, x.gamma_g, (double)params.gamma_g);
}

static void test_arm_discretisation_holds_from_slow_to_stiff_and_overdamped(void)
{
    const uint64_t seed = 20110701;
    random_t       r    = {seed};
    printf("seed %llu\n", (unsigned long long)seed);
    for (int i = 0; i < 2000; i++)
    {
        const double stiffness = pow(10.0, random_between(&r, -8.5, 3.5));
        const double damping   = i % 10 == 0 ? 0.0 : pow(10.0, random_between(&r, -4.0, 2.5));
        config.inertia         = 1.0f;
        config.stiffness       = (float)(stiffness / ((double)H * (double)H));
        config.damping         = (float)(damping / (double)H);
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_f32_init(&params, &config, H));
        const exact_t x = exact((double)config.stiffness * (double)H * (double)H, (double)config.damping * (double)H);
        // Phase is lost in proportion to the number of radians or time constants a tick; an arm that is slow against
        // the tick keeps its relative precision.
        const double tolerance = 1e-6 * (1.0 + sqrt(stiffness) + damping);
        const double scale     = 1.0 + sqrt(stiffness);
        const double small     = stiffness < 1.0 && damping < 1.0 ? stiffness : 1.0;
        TEST_ASSERT_DOUBLE_WITHIN(tolerance * small, x.phi_d, (double)params.phi_d);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, x.phi_g, (double)params.phi_g);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance * scale * small, x.gamma_d, (double)params.gamma_d);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance * scale, x.gamma_g, (double)params.gamma_g);
    }
}

static void test_arm_stays_finite_when_its_resonance_is_driven_with_all_there_is(void)
{
    config.damping = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_f32_init(&params, &config, H));
    for (int k = 0; k < 100000; k++)
    {
        const float push = state.force_change_n >= 0.0f ? 5.0e6f : -5.0e6f;
        const float F    = step(fmaxf(-1.0e7f, fminf(1.0e7f, push - state.force_n)));
        TEST_ASSERT_TRUE(isfinite(F));
    }
}

// Driven beyond what the other modules take, it stays where they can still bring it back from.
static void test_arm_is_held_at_the_largest_force_and_comes_back(void)
{
    for (float drive = -1.0e7f; drive <= 1.0e7f; drive += 2.0e7f)
    {
        tribo_arm_f32_reset(&state);
        for (int k = 0; k < 1000; k++)
        {
            TEST_ASSERT_TRUE(fabsf(step(drive)) <= 1.0e6f);
            TEST_ASSERT_TRUE(fabsf(state.force_change_n) <= 1.0e6f);
        }
        TEST_ASSERT_SAME_FLOAT(drive < 0.0f ? -1.0e6f : 1.0e6f, state.force_n);
        TEST_ASSERT_TRUE(state.clamped > 900u);
        for (int k = 0; k < 1000; k++)
        {
            (void)step(-state.force_n);
        }
        TEST_ASSERT_FLOAT_WITHIN(1.0f, 0.0f, state.force_n);
    }
}

static void test_arm_comes_back_from_a_lost_state(void)
{
    const float lost[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1.0e9f};
    for (size_t i = 0; i < 12; i++)
    {
        tribo_arm_f32_reset(&state);
        *(i % 2 == 0 ? &state.force_n : &state.force_change_n) = lost[i / 2];
        const float recovered                                  = isnan(lost[i / 2]) ? 0.0f : TRIBO_F32_FORCE_MAX_N;
        TEST_ASSERT_TRUE(fabsf(step(0.0f)) == recovered);
        TEST_ASSERT_SAME_FLOAT(0.0f, state.force_change_n);
        TEST_ASSERT_EQUAL_UINT32(1, state.clamped);
        for (int k = 0; k < 1000; k++)
        {
            (void)step(-state.force_n);
        }
        TEST_ASSERT_FLOAT_WITHIN(1.0f, 0.0f, state.force_n);
    }
}

static void check_refused(tribo_status_t status, float h)
{
    tribo_arm_f32_params_t out;
    memset(&out, 0xa5, sizeof out);
    TEST_ASSERT_EQUAL_INT(status, tribo_arm_f32_init(&out, &config, h));
    TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out, sizeof out);
}

static void test_arm_init_refuses_an_arm_too_fast_or_too_slow_for_the_sample_time(void)
{
    config = (tribo_arm_f32_config_t){.inertia = 1.0f, .damping = 1.0f, .stiffness = 0.99e10f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_f32_init(&params, &config, H));
    config.stiffness = 1.01e10f;
    check_refused(TRIBO_ERR_ARM_TOO_FAST, H);
    config.stiffness = 0.99e-3f;
    check_refused(TRIBO_ERR_ARM_TOO_FAST, H);
    config.stiffness = 1.0f;
    config.damping   = 0.99e7f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_f32_init(&params, &config, H));
    config.damping = 1.01e7f;
    check_refused(TRIBO_ERR_ARM_TOO_FAST, H);
    config = (tribo_arm_f32_config_t){.inertia = 1e-12f, .damping = 1e12f, .stiffness = 1e12f};
    check_refused(TRIBO_ERR_ARM_TOO_FAST, H);
    config.inertia = 0.99e-12f;
    check_refused(TRIBO_ERR_INERTIA, H);
}

static void test_arm_init_takes_no_null(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_arm_f32_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_arm_f32_init(&params, NULL, H));
}

#include "runners/test_arm_f32.inc" // main
