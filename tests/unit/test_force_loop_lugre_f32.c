#include "tribo/force_loop_f32.h"
#include "tribo/friction_f32.h"
#include "unity.h"

#include <math.h>
#include <string.h>

static tribo_force_loop_f32_config_t config;
static tribo_lugre_f32_config_t      lugre_config;
static tribo_force_loop_f32_params_t params;
static tribo_lugre_f32_params_t      lugre;
static tribo_force_loop_f32_state_t  state;

void setUp(void)
{
    config       = tribo_force_loop_f32_paper();
    lugre_config = tribo_lugre_f32_paper();
    memset(&params, 0x5a, sizeof params);
    memset(&lugre, 0x5a, sizeof lugre);
    tribo_force_loop_f32_reset(&state);
}

void tearDown(void)
{
}

/// Nothing is written.
static void expect(tribo_status_t status)
{
    tribo_force_loop_f32_params_t before;
    tribo_lugre_f32_params_t      lugre_before;
    memset(&before, 0x5a, sizeof before);
    memset(&lugre_before, 0x5a, sizeof lugre_before);
    TEST_ASSERT_EQUAL_INT(status, tribo_force_loop_lugre_f32_init(&params, &lugre, &config, &lugre_config));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof before);
    TEST_ASSERT_EQUAL_MEMORY(&lugre_before, &lugre, sizeof lugre_before);
    setUp();
}

static void test_init_names_the_field_that_is_wrong(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_lugre_f32_init(NULL, &lugre, &config, &lugre_config));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_lugre_f32_init(&params, NULL, &config, &lugre_config));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_lugre_f32_init(&params, &lugre, NULL, &lugre_config));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_lugre_f32_init(&params, &lugre, &config, NULL));
    config.gain = NAN;
    expect(TRIBO_ERR_GAIN);
    lugre_config.stiffness = 0.0f;
    expect(TRIBO_ERR_BRISTLE_STIFFNESS);
    lugre_config.viscous = NAN;
    expect(TRIBO_ERR_BRISTLE_VISCOUS);
}

static void test_init_makes_the_loop_of_the_config_with_lugres_own_params(void)
{
    tribo_force_loop_f32_params_t plain;
    tribo_lugre_f32_params_t      own;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_lugre_f32_init(&params, &lugre, &config, &lugre_config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&plain, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_lugre_f32_init(&own, &lugre_config, &config.compensator.arm, 1e-3f));
    TEST_ASSERT_TRUE(plain.method == NULL && plain.compensator.model == NULL);
    TEST_ASSERT_TRUE(params.method == NULL && params.compensator.model == &lugre.model);
    TEST_ASSERT_TRUE(lugre.model.step == tribo_lugre_f32_model_step &&
                     lugre.model.enter == tribo_lugre_f32_model_enter);
    own.model = lugre.model;
    TEST_ASSERT_EQUAL_MEMORY(&own, &lugre, sizeof own);
    plain.compensator.model = params.compensator.model;
    TEST_ASSERT_EQUAL_MEMORY(&plain.compensator, &params.compensator, sizeof plain.compensator);
    TEST_ASSERT_EQUAL_FLOAT(plain.gain, params.gain);
}

/// f^ of a tick is what the compensator says of u, and goes into u a tick later, times the gain.
static void test_a_tick_adds_the_friction_of_the_last(void)
{
    tribo_compensator_f32_state_t   alone;
    tribo_compensator_f32_signals_t expected;
    tribo_force_loop_f32_signals_t  seen;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_lugre_f32_init(&params, &lugre, &config, &lugre_config));
    tribo_compensator_f32_reset(&alone);
    tribo_lugre_f32_reset(&alone.friction.lugre);
    float f = 0.0f;
    for (int k = 0; k < 200; k++)
    {
        const float u = tribo_force_loop_f32_step(&params, &state, 0.1f, 0.0f, &seen);
        TEST_ASSERT_EQUAL_FLOAT(config.gain * f, seen.friction_term_n);
        f = tribo_compensator_f32_step(&params.compensator, &alone, u, &expected);
        TEST_ASSERT_EQUAL_FLOAT(f, seen.compensator.friction.f_n);
        TEST_ASSERT_EQUAL_FLOAT(expected.force_n, seen.compensator.force_n);
    }
    TEST_ASSERT_TRUE(f > 0.03f);
}

static void test_lugre_takes_over_where_no_memory_is_attached(void)
{
    tribo_force_loop_f32_params_t paper;
    tribo_force_loop_f32_state_t  unchanged;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_f32_init(&paper, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_lugre_f32_init(&params, &lugre, &config, &lugre_config));
    for (int k = 0; k < 200; k++)
    {
        (void)tribo_force_loop_f32_step(&paper, &state, 0.1f, 0.09f, NULL);
    }
    unchanged     = state;
    const float u = tribo_force_loop_f32_step(&paper, &unchanged, 0.1f, 0.09f, NULL);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, u, tribo_force_loop_f32_step(&params, &state, 0.1f, 0.09f, NULL));
}

static void test_a_corrupt_arm_starts_again_from_rest(void)
{
    tribo_compensator_f32_signals_t seen;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_lugre_f32_init(&params, &lugre, &config, &lugre_config));
    state.compensator.arm.force_n = NAN;
    (void)tribo_compensator_f32_step(&params.compensator, &state.compensator, 0.005f, &seen);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, seen.force_n);
    TEST_ASSERT_EQUAL_FLOAT(0.007f, seen.friction.L_n);
    TEST_ASSERT_TRUE(isfinite(seen.friction.f_n) && isfinite(state.compensator.arm.force_n));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_init_names_the_field_that_is_wrong);
    RUN_TEST(test_init_makes_the_loop_of_the_config_with_lugres_own_params);
    RUN_TEST(test_a_tick_adds_the_friction_of_the_last);
    RUN_TEST(test_lugre_takes_over_where_no_memory_is_attached);
    RUN_TEST(test_a_corrupt_arm_starts_again_from_rest);
    return UNITY_END();
}
