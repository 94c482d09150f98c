// The STM32F405's converters, code by code.

#include "app/loop_setup.h"
#include "port/stm32f405/convert.h"
#ifdef DRIVE_ARITH_Q31
#include "port/stm32f405/rig_q31.h"
#else
#include "port/stm32f405/rig_f32.h"
#endif

#include "unity.h"

static tribo_force_loop_f32_config_t config;
static loop_setup_t                  setup;

static const loop_params_t *set_up(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_setup(&setup, &config, CONVERT_FULL_SCALE_N));
    return &setup.params;
}

void setUp(void)
{
    config = tribo_force_loop_f32_paper(); // up to 2 N
}

void tearDown(void)
{
}

static double newton(loop_force_t force)
{
    return loop_to_q31(force, CONVERT_FULL_SCALE_N) / 2147483648.0 * (double)CONVERT_FULL_SCALE_N;
}

static void test_sensor_has_1638_codes_for_2_n(void)
{
    for (uint32_t code = 0; code <= CONVERT_CODES_MAX; code++)
    {
        const double expected = ((double)code - 2048.0) / 1638.4 * 2.0;
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, expected, newton(convert_sensor(code, 1)));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6,
                                  expected,
                                  newton(convert_sensor(CONVERT_READINGS_MAX * code, CONVERT_READINGS_MAX)));
    }
}

// A short to either rail, with noise or without, is a sensor out of range.
static void test_codes_near_the_ends_are_not_credible(void)
{
    const loop_params_t *params = set_up();
    for (uint32_t code = 0; code <= CONVERT_CODES_MAX; code++)
    {
        const bool within = code >= 2048 - 1638 && code <= 2048 + 1638;
        TEST_ASSERT_EQUAL_INT(within, loop_is_credible(params, convert_sensor(code, 1)));
        TEST_ASSERT_EQUAL_INT(within, loop_is_credible(params, convert_sensor(42u * code, 42u)));
    }
}

static void test_rig_and_paper_can_be_run(void)
{
    TEST_ASSERT_TRUE(convert_suits(&rig_params));
    TEST_ASSERT_TRUE(convert_suits(set_up()));
}

// Each end alone decides: the lower rail is 1948 codes from 0 N, the upper one 1947.
static void test_a_loop_is_refused_for_which_a_rail_is_a_reading(void)
{
    const float code_n = 2.0f / 1638.4f;
    config.input_max_n = 1946.5f * code_n;
    TEST_ASSERT_TRUE(convert_suits(set_up()));
    config.input_max_n = 1947.5f * code_n;
    TEST_ASSERT_FALSE(convert_suits(set_up()));
    config.input_max_n = 1948.5f * code_n;
    TEST_ASSERT_FALSE(convert_suits(set_up()));
}

static void test_a_loop_is_refused_whose_command_has_no_code(void)
{
    config.controller.u_max_n = 2.001f;
    TEST_ASSERT_FALSE(convert_suits(set_up()));
    config.controller.u_max_n = 2.0f;
    config.controller.u_min_n = -2.001f;
    TEST_ASSERT_FALSE(convert_suits(set_up()));
}

static void test_sensor_keeps_what_the_mean_has_below_a_code(void)
{
    const double code_n = 2.0 / 1638.4;
    TEST_ASSERT_DOUBLE_WITHIN(code_n / 1000.0, 10.5 * code_n, newton(convert_sensor(2058u + 2059u, 2)));
    TEST_ASSERT_DOUBLE_WITHIN(code_n / 1000.0, -10.25 * code_n, newton(convert_sensor(3u * 2038u + 2037u, 4)));
}

static void test_command_is_the_nearest_code(void)
{
    TEST_ASSERT_EQUAL_UINT32(CONVERT_ZERO, convert_command(0));
    for (int32_t code = 1; code <= CONVERT_CODES_MAX; code++)
    {
        const int32_t part = (code - CONVERT_ZERO) * CONVERT_COMMAND_Q31;
        const int32_t less = CONVERT_COMMAND_Q31 / 2 - 256; // a float has 24 bits
        TEST_ASSERT_EQUAL_INT32(code, convert_command(loop_from_q31(part, CONVERT_FULL_SCALE_N)));
        TEST_ASSERT_EQUAL_INT32(code, convert_command(loop_from_q31(part - less, CONVERT_FULL_SCALE_N)));
        TEST_ASSERT_EQUAL_INT32(code, convert_command(loop_from_q31(part + less, CONVERT_FULL_SCALE_N)));
    }
}

static void test_command_ends_at_the_ends_of_the_converter(void)
{
    const int32_t two_n = INT32_C(1) << 30;
    TEST_ASSERT_EQUAL_UINT32(CONVERT_CODES_MAX, convert_command(loop_from_q31(two_n, CONVERT_FULL_SCALE_N)));
    TEST_ASSERT_EQUAL_UINT32(0, convert_command(loop_from_q31(-two_n, CONVERT_FULL_SCALE_N)));
    for (int32_t beyond = 1; beyond <= 2000; beyond++)
    {
        const int32_t part = two_n + beyond * CONVERT_COMMAND_Q31;
        TEST_ASSERT_EQUAL_UINT32(CONVERT_CODES_MAX, convert_command(loop_from_q31(part, CONVERT_FULL_SCALE_N)));
        TEST_ASSERT_EQUAL_UINT32(0, convert_command(loop_from_q31(-part, CONVERT_FULL_SCALE_N)));
    }
    TEST_ASSERT_EQUAL_UINT32(CONVERT_CODES_MAX, convert_command(loop_from_q31(INT32_MAX, CONVERT_FULL_SCALE_N)));
    TEST_ASSERT_EQUAL_UINT32(0, convert_command(loop_from_q31(INT32_MIN, CONVERT_FULL_SCALE_N)));
#ifndef DRIVE_ARITH_Q31
    TEST_ASSERT_EQUAL_UINT32(CONVERT_CODES_MAX, convert_command(1.0e6f));
    TEST_ASSERT_EQUAL_UINT32(0, convert_command(-1.0e6f));
#endif
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_sensor_has_1638_codes_for_2_n);
    RUN_TEST(test_codes_near_the_ends_are_not_credible);
    RUN_TEST(test_rig_and_paper_can_be_run);
    RUN_TEST(test_a_loop_is_refused_for_which_a_rail_is_a_reading);
    RUN_TEST(test_a_loop_is_refused_whose_command_has_no_code);
    RUN_TEST(test_sensor_keeps_what_the_mean_has_below_a_code);
    RUN_TEST(test_command_is_the_nearest_code);
    RUN_TEST(test_command_ends_at_the_ends_of_the_converter);
    return UNITY_END();
}
