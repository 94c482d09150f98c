// What only the Q31 arithmetic has. What both promise: tests/contract/test_reference_model.c.

#include "feedforward/reference_model_f32.h"
#include "feedforward/reference_model_q31.h"

#include "unity.h"

#define H 1.0e-3f

static tribo_reference_model_f32_config_t config;
static tribo_reference_model_q31_params_t params;
static tribo_reference_model_q31_state_t  model;

void setUp(void)
{
    config = tribo_reference_model_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_reference_model_q31_init(&params, &config, H));
    tribo_reference_model_q31_reset(&model);
}

void tearDown(void)
{
}

static void test_reference_model_saturates_nothing_within_a_quarter_of_its_range(void)
{
    for (int k = 0; k < 2000; k++)
    {
        const int32_t end = INT32_C(1) << 29;
        (void)reference_model_q31_step(&params, &model, k % 300 == 0 ? (k % 600 == 0 ? end : -end) : 0, k % 7 * 1000);
    }
    TEST_ASSERT_EQUAL_UINT32(0, model.saturated);
}

static void test_reference_model_comes_back_from_saturation(void)
{
    for (int k = 0; k < 100; k++)
    {
        (void)reference_model_q31_step(&params, &model, INT32_MIN, INT32_MAX);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(50, model.saturated);
    for (int k = 0; k < 2000; k++)
    {
        (void)reference_model_q31_step(&params, &model, 0, 0);
    }
    TEST_ASSERT_INT32_WITHIN(40, 0, model.sensor); // less than 1/part for each low pass
}

static void test_reference_model_init_refuses_what_has_too_few_bits(void)
{
    const tribo_reference_model_q31_params_t before = params;
    config.actuator_pole_rad_per_s                  = 9e-3f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_ACTUATOR_POLE, tribo_reference_model_q31_init(&params, &config, H));
    config                       = tribo_reference_model_f32_paper();
    config.sensor_pole_rad_per_s = 9e-3f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SENSOR_POLE, tribo_reference_model_q31_init(&params, &config, H));
    config             = tribo_reference_model_f32_paper();
    config.arm.inertia = 3.84e-8f; // an oscillation of 10 rad a tick: coefficients beyond 4
    config.arm.damping = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_ARM_TOO_FAST, tribo_reference_model_q31_init(&params, &config, H));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reference_model_saturates_nothing_within_a_quarter_of_its_range);
    RUN_TEST(test_reference_model_comes_back_from_saturation);
    RUN_TEST(test_reference_model_init_refuses_what_has_too_few_bits);
    return UNITY_END();
}
