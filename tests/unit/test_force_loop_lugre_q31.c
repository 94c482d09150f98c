#include "controller/biquad_f32.h"
#include "controller/biquad_q31.h"
#include "guard/guard_q31.h"
#include "paper/arm_q31.h"
#include "paper/lugre_f32.h"
#include "paper/lugre_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/friction_q31.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define FULL_SCALE_N 2.0f

static tribo_force_loop_f32_config_t config;
static tribo_lugre_f32_config_t      lugre_config;
static tribo_force_loop_q31_params_t params;
static tribo_lugre_q31_params_t      lugre;
static tribo_headroom_q31_t          headroom;
static tribo_force_loop_q31_state_t  state;

void setUp(void)
{
    config       = tribo_force_loop_f32_paper();
    lugre_config = tribo_lugre_f32_paper();
    memset(&params, 0x5a, sizeof params);
    memset(&lugre, 0x5a, sizeof lugre);
    memset(&headroom, 0x5a, sizeof headroom);
    tribo_force_loop_q31_reset(&state);
}

void tearDown(void)
{
}

static tribo_status_t init(float full_scale_n)
{
    return tribo_force_loop_lugre_q31_init(&params, NULL, &lugre, &config, &lugre_config, full_scale_n, &headroom);
}

/// Nothing is written.
static void expect(tribo_status_t status, float full_scale_n)
{
    tribo_force_loop_q31_params_t before;
    tribo_lugre_q31_params_t      lugre_before;
    tribo_headroom_q31_t          headroom_before;
    memset(&before, 0x5a, sizeof before);
    memset(&lugre_before, 0x5a, sizeof lugre_before);
    memset(&headroom_before, 0x5a, sizeof headroom_before);
    TEST_ASSERT_EQUAL_INT(status, init(full_scale_n));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof before);
    TEST_ASSERT_EQUAL_MEMORY(&lugre_before, &lugre, sizeof lugre_before);
    TEST_ASSERT_EQUAL_MEMORY(&headroom_before, &headroom, sizeof headroom_before);
    setUp();
}

static void test_init_names_the_field_that_is_wrong(void)
{
    TEST_ASSERT_EQUAL_INT(
        TRIBO_ERR_NULL,
        tribo_force_loop_lugre_q31_init(NULL, NULL, &lugre, &config, &lugre_config, FULL_SCALE_N, NULL));
    TEST_ASSERT_EQUAL_INT(
        TRIBO_ERR_NULL,
        tribo_force_loop_lugre_q31_init(&params, NULL, NULL, &config, &lugre_config, FULL_SCALE_N, NULL));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_force_loop_lugre_q31_init(&params, NULL, &lugre, &config, NULL, FULL_SCALE_N, NULL));
    expect(TRIBO_ERR_FULL_SCALE, NAN);
    config.gain = NAN;
    expect(TRIBO_ERR_GAIN, FULL_SCALE_N);
    lugre_config.stiffness = 1.0e8f; // c = 7e5
    lugre_config.damping   = 1.0e6f;
    expect(TRIBO_ERR_BRISTLE_DAMPING, FULL_SCALE_N);
}

static void test_init_makes_the_loop_of_the_config_with_lugres_own_params(void)
{
    tribo_force_loop_q31_params_t plain;
    tribo_lugre_q31_params_t      own;
    tribo_headroom_q31_t          measured;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(FULL_SCALE_N));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_q31_init(&plain, NULL, &config, FULL_SCALE_N, &measured));
    memset(&own, 0x5a, sizeof own);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_lugre_q31_init(&own, &lugre_config, &config.compensator.arm, 1e-3f));
    TEST_ASSERT_TRUE(plain.method == NULL && plain.compensator.model == NULL);
    TEST_ASSERT_TRUE(params.method == NULL && params.compensator.model == &lugre.model);
    TEST_ASSERT_TRUE(lugre.model.step == tribo_lugre_q31_model_step &&
                     lugre.model.enter == tribo_lugre_q31_model_enter);
    own.model = lugre.model;
    TEST_ASSERT_EQUAL_MEMORY(&own, &lugre, sizeof own);
    TEST_ASSERT_EQUAL_FLOAT(measured.input, headroom.input);
    TEST_ASSERT_EQUAL_INT32(plain.gain, params.gain);
}

/// f^ of a tick is what the compensator says of u, and goes into u a tick later, times the gain.
static void test_a_tick_adds_the_friction_of_the_last(void)
{
    tribo_compensator_q31_state_t   alone;
    tribo_compensator_q31_signals_t expected;
    tribo_force_loop_q31_signals_t  seen;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(FULL_SCALE_N));
    tribo_compensator_q31_reset(&alone);
    tribo_lugre_q31_reset(&alone.friction.lugre);
    int32_t f = 0;
    for (int k = 0; k < 200; k++)
    {
        const int32_t u = tribo_force_loop_q31_step(&params, &state, TRIBO_Q31(0.1, 2.0), 0, &seen);
        TEST_ASSERT_INT32_WITHIN(1, (int32_t)floor((double)params.gain * f / 536870912.0), seen.friction_term);
        f = tribo_compensator_q31_step(&params.compensator, &alone, u, &expected);
        TEST_ASSERT_EQUAL_INT32(f, seen.compensator.friction.f);
        TEST_ASSERT_EQUAL_INT32(expected.force, seen.compensator.force);
    }
    TEST_ASSERT_TRUE(f > TRIBO_Q31(0.03, 2.0));
}

static void test_lugre_takes_over_where_no_memory_is_attached(void)
{
    const int32_t                 r = TRIBO_Q31(0.1, 2.0);
    const int32_t                 y = TRIBO_Q31(0.09, 2.0);
    tribo_force_loop_q31_params_t paper;
    tribo_force_loop_q31_state_t  unchanged;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_q31_init(&paper, NULL, &config, FULL_SCALE_N, NULL));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(FULL_SCALE_N));
    for (int k = 0; k < 200; k++)
    {
        (void)tribo_force_loop_q31_step(&paper, &state, r, y, NULL);
    }
    unchanged       = state;
    const int32_t u = tribo_force_loop_q31_step(&paper, &unchanged, r, y, NULL);
    TEST_ASSERT_INT32_WITHIN(TRIBO_Q31(1e-6, 2.0), u, tribo_force_loop_q31_step(&params, &state, r, y, NULL));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_init_names_the_field_that_is_wrong);
    RUN_TEST(test_init_makes_the_loop_of_the_config_with_lugres_own_params);
    RUN_TEST(test_a_tick_adds_the_friction_of_the_last);
    RUN_TEST(test_lugre_takes_over_where_no_memory_is_attached);
    return UNITY_END();
}
