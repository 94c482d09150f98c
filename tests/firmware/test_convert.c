// The STM32F405's converters, code by code, with the scaling of its rig.

#include "app/loop.h"
#include "app/scaling.h"
#include "board.h"
#include "port/stm32f405/convert.h"
#include "port/stm32f405/rig_config.h"
#ifdef TRIBO_ARITHMETIC_Q31
#include "../../examples/rig/rig_1khz_q31.h" // rig.yaml of this board: tests/examples/test_rig.py
#else
#include "../../examples/rig/rig_1khz_f32.h"
#endif

#include "unity.h"

#include <math.h>

static const port_t port = {.sensor = CONVERT_SENSOR_RANGE, .output = CONVERT_OUTPUT_RANGE};

static tribo_force_loop_f32_config_t loop;
static drive_config_t                config;
static loop_setup_t                  setup;
static scaling_t                     scaling;
static drive_config_error_t          error;

static const loop_params_t *set_up(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_setup(&setup, &loop, config.full_scale_n));
    return &setup.params;
}

void setUp(void)
{
    loop   = tribo_force_loop_f32_paper(); // up to 2 N
    config = rig_config;
    TEST_ASSERT_TRUE(scaling_init(&scaling, &config, &port, &error));
}

static double newton(loop_force_t force)
{
    return tribo_force_q31(force, config.full_scale_n) / 2147483648.0 * (double)config.full_scale_n;
}

static double sensor_n(uint32_t sum, uint32_t count)
{
    return newton(scaling_force(&scaling, scaling.sensor_zero, convert_sensor(sum, count)));
}

static uint32_t code_of(double force_n)
{
    return convert_output(scaling_output(&scaling, board_force(force_n)));
}

static void check_refused(const char *field)
{
    const bool made = scaling_init(&scaling, &config, &port, &error);
    TEST_ASSERT_FALSE(made && scaling_suits(&scaling, &config, &port, set_up(), &error));
    TEST_ASSERT_EQUAL_STRING(field, drive_config_name(error.field));
}

static void check_suits(void)
{
    TEST_ASSERT_TRUE(scaling_init(&scaling, &config, &port, &error));
    TEST_ASSERT_TRUE(scaling_suits(&scaling, &config, &port, set_up(), &error));
}

// --- the rig of the board ------------------------------------------------------------------------------------------

static void test_sensor_has_1638_codes_for_2_n(void)
{
    for (uint32_t code = 0; code <= CONVERT_CODES_MAX; code++)
    {
        const double expected = ((double)code - 2048.0) / 1638.4 * 2.0;
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, expected, sensor_n(code, 1));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, expected, sensor_n(CONVERT_READINGS_MAX * code, CONVERT_READINGS_MAX));
    }
}

// A short to either rail, with noise or without, is a sensor out of range.
static void test_codes_near_the_ends_are_not_credible(void)
{
    const loop_params_t *params = set_up();
    for (uint32_t code = 0; code <= CONVERT_CODES_MAX; code++)
    {
        const bool         within = code >= 2048 - 1638 && code <= 2048 + 1638;
        const loop_force_t one    = scaling_force(&scaling, scaling.sensor_zero, convert_sensor(code, 1));
        const loop_force_t mean   = scaling_force(&scaling, scaling.sensor_zero, convert_sensor(42u * code, 42u));
        TEST_ASSERT_EQUAL_INT(within, tribo_force_is_credible(params, one));
        TEST_ASSERT_EQUAL_INT(within, tribo_force_is_credible(params, mean));
    }
}

static void test_rig_and_paper_can_be_run(void)
{
    check_suits();
    TEST_ASSERT_TRUE(scaling_suits(&scaling, &config, &port, &rig_params, &error));
#ifdef TRIBO_ARITHMETIC_Q31
    TEST_ASSERT_TRUE(config.full_scale_n == RIG_FULL_SCALE_N);
#endif
}

static void test_sensor_keeps_what_the_mean_has_below_a_code(void)
{
    const double code_n = 2.0 / 1638.4;
    TEST_ASSERT_DOUBLE_WITHIN(code_n / 1000.0, 10.5 * code_n, sensor_n(2058u + 2059u, 2));
    TEST_ASSERT_DOUBLE_WITHIN(code_n / 1000.0, -10.25 * code_n, sensor_n(3u * 2038u + 2037u, 4));
}

static void test_command_is_the_nearest_code(void)
{
    TEST_ASSERT_EQUAL_UINT32(2048, convert_output(scaling.no_current));
    for (int32_t code = 1; code <= CONVERT_CODES_MAX; code++)
    {
        const double code_n  = 2.0 / 2048.0;
        const double force_n = (code - 2048) * code_n;
        TEST_ASSERT_EQUAL_UINT32(code, code_of(force_n));
        TEST_ASSERT_EQUAL_UINT32(code, code_of(force_n - 0.499 * code_n));
        TEST_ASSERT_EQUAL_UINT32(code, code_of(force_n + 0.499 * code_n));
    }
}

static void test_command_ends_at_the_ends_of_the_converter(void)
{
    for (int32_t beyond = 0; beyond <= 2000; beyond++)
    {
        const double force_n = 2.0 + beyond * (2.0 / 2048.0);
        TEST_ASSERT_EQUAL_UINT32(CONVERT_CODES_MAX, code_of(fmin(force_n, 3.999)));
        TEST_ASSERT_EQUAL_UINT32(0, code_of(fmax(-force_n, -3.999)));
    }
    TEST_ASSERT_EQUAL_UINT32(CONVERT_CODES_MAX,
                             convert_output(scaling_output(&scaling, tribo_force_of_q31(INT32_MAX, 4.0f))));
    TEST_ASSERT_EQUAL_UINT32(0, convert_output(scaling_output(&scaling, tribo_force_of_q31(INT32_MIN, 4.0f))));
#ifndef TRIBO_ARITHMETIC_Q31
    TEST_ASSERT_EQUAL_UINT32(CONVERT_CODES_MAX, convert_output(1.0e6f));
    TEST_ASSERT_EQUAL_UINT32(0, convert_output(-1.0e6f));
    TEST_ASSERT_EQUAL_UINT32(0, convert_output(NAN));
#endif
}

// --- other rigs ----------------------------------------------------------------------------------------------------

/// The equations of config.h, in double precision, for rigs at random.
static void test_scaling_is_its_equation_for_any_rig(void)
{
    uint32_t random = 1;
    for (unsigned i = 0; i < 20000u; i++)
    {
        double x[6];
        for (unsigned k = 0; k < 6u; k++)
        {
            random = random * 1664525u + 1013904223u;
            x[k]   = (double)(random >> 8) / 16777216.0;
        }
        config.full_scale_n       = 4.0f;
        config.sensor_n_per_unit  = (float)(1e-4 * pow(10.0, 2.0 * x[0]));
        config.sensor_zero_units  = (float)(500.0 + 3000.0 * x[1]);
        config.sensor_reversed    = x[2] < 0.5;
        config.command_n_per_unit = (float)(1e-3 * pow(10.0, 2.0 * x[3]));
        config.command_zero_units = (float)(1000.0 + 2000.0 * x[4]);
        config.command_reversed   = x[5] < 0.5;
        TEST_ASSERT_TRUE(scaling_init(&scaling, &config, &port, &error));

        const uint32_t code     = random % 4096u;
        const double   sign     = x[2] < 0.5 ? -1.0 : 1.0;
        const double   y_n      = sign * (double)config.sensor_n_per_unit * (code - (double)config.sensor_zero_units);
        const double   u_n      = 4.0 * x[1] - 2.0;
        const double   u_units  = (x[5] < 0.5 ? -u_n : u_n) / (double)config.command_n_per_unit;
        const double   expected = fmax(0.0, fmin(4095.0, (double)config.command_zero_units + u_units));
        const double   tolerance_n = 1e-6 * fmax(1.0, fabs(y_n));
        TEST_ASSERT_DOUBLE_WITHIN(tolerance_n, fmax(-4.0, fmin(4.0, y_n)), sensor_n(code, 1));
        TEST_ASSERT_DOUBLE_WITHIN(0.51, expected, (double)code_of(u_n));
    }
}

// --- what is refused -----------------------------------------------------------------------------------------------

// Each end alone decides: the lower rail is 1948 codes from 0 N, the upper one 1947.
static void test_a_loop_is_refused_for_which_a_rail_is_a_reading(void)
{
    const float code_n = 2.0f / 1638.4f;
    loop.input_max_n   = 1946.5f * code_n;
    check_suits();
    loop.input_max_n = 1947.5f * code_n;
    check_refused("sensor_n_per_unit");
    TEST_ASSERT_FLOAT_WITHIN(1e-3f * code_n, 1947.5f / 1947.0f * code_n, error.low); // which would suit
    config.sensor_n_per_unit = error.low * 1.0001f;
    check_suits();
    loop.input_max_n = 1948.5f * code_n * 1.0004f;
    check_refused("sensor_n_per_unit");
}

static void test_a_loop_is_refused_whose_command_has_no_code(void)
{
    loop.controller.u_max_n = 2.001f;
    config.current_max_a    = 3.0f;
    check_refused("command_n_per_unit");
    loop.controller.u_max_n = 2.0f;
    loop.controller.u_min_n = -2.001f;
    check_refused("command_n_per_unit");
    config.command_n_per_unit = error.low * 1.0001f;
    check_suits();
    config.command_zero_units = 2100.0f; // the room is not the same on both sides
    loop.controller.u_min_n   = -2.0f;
    check_refused("command_n_per_unit");
    loop.controller.u_max_n = 1.9f;
    check_suits();
    config.command_reversed = 1;
    check_refused("command_n_per_unit");
}

static void test_a_loop_is_refused_that_asks_for_too_much_current(void)
{
    config.command_n_per_a = 0.8f;
    check_refused("current_max_a");
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 2.5f, error.low);
    config.current_max_a = 2.5f;
    check_suits();
    config.command_n_per_a = 0.1f;
    config.current_max_a   = 0.0f; // not checked
    check_suits();
}

static void test_a_zero_beyond_the_converter_is_refused(void)
{
    config.sensor_zero_units = 99.0f;
    check_refused("sensor_zero_units");
    config                    = rig_config;
    config.command_zero_units = 4097.0f;
    check_refused("command_zero_units");
    TEST_ASSERT_EQUAL_UINT32(2048, convert_output(scaling.no_current)); // the best that can be said
    config.command_zero_units = NAN;
    check_refused("command_zero_units");
    TEST_ASSERT_EQUAL_UINT32(2048, convert_output(scaling.no_current));
}

static void test_a_unit_without_a_number_is_refused(void)
{
    config.sensor_n_per_unit = 1e-12f;
    config.full_scale_n      = 1e6f;
#ifdef TRIBO_ARITHMETIC_Q31
    check_refused("sensor_n_per_unit");
    config                    = rig_config;
    config.command_n_per_unit = 1e6f;
    TEST_ASSERT_FALSE(scaling_init(&scaling, &config, &port, &error));
    TEST_ASSERT_EQUAL_STRING("command_n_per_unit", drive_config_name(error.field));
#endif
    config                   = rig_config;
    config.sensor_n_per_unit = NAN;
    check_refused("sensor_n_per_unit");
}

static void test_what_the_power_stage_shows_is_scaled(void)
{
    const uint32_t  zero[] = {2048, 0, 0};
    const uint32_t  low[]  = {0, 2048, 1024};
    const uint32_t  high[] = {4095, 4095, 4095};
    port_measured_t is     = convert_measured(zero);
    TEST_ASSERT_TRUE(is.current_ma == 0 && is.bus_mv == 0 && is.temperature_mc == 0);
    is = convert_measured(low);
    TEST_ASSERT_EQUAL_INT32(-8250, is.current_ma); // 0 V
    TEST_ASSERT_EQUAL_INT32(33000, is.bus_mv);     // 1.65 V
    TEST_ASSERT_EQUAL_INT32(82500, is.temperature_mc);
    is = convert_measured(high);
    TEST_ASSERT_INT32_WITHIN(5, 8250, is.current_ma);
    TEST_ASSERT_INT32_WITHIN(20, 66000, is.bus_mv);
    TEST_ASSERT_INT32_WITHIN(100, 330000, is.temperature_mc);
}

/// Nanoseconds that the manual's table (TIM1, BDTR) gives for the bits DTG.
static double dead_time_ns(uint32_t bits, double timer_hz)
{
    const double cycle_ns = 1e9 / timer_hz;
    if (bits < 0x80u)
    {
        return bits * cycle_ns;
    }
    if (bits < 0xc0u)
    {
        return (64u + (bits & 0x3fu)) * 2u * cycle_ns;
    }
    return (32u + (bits & 0x1fu)) * (bits < 0xe0u ? 8u : 16u) * cycle_ns;
}

static void test_a_dead_time_is_never_shorter_than_requested(void)
{
    const uint32_t clocks_hz[] = {168000000u, 16000000u};
    for (int i = 0; i < 2; i++)
    {
        const double cycle_ns = 1e9 / (double)clocks_hz[i];
        for (uint32_t ns = 50; ns <= 6000; ns++)
        {
            const uint32_t bits  = convert_dead_time(ns, clocks_hz[i]);
            const double   found = dead_time_ns(bits, (double)clocks_hz[i]);
            const double   step  = bits < 0x80u ? 1.0 : bits < 0xc0u ? 2.0 : bits < 0xe0u ? 8.0 : 16.0;
            TEST_ASSERT_TRUE(bits <= 0xffu);
            TEST_ASSERT_TRUE(found >= ns - 1e-6);
            TEST_ASSERT_TRUE(found < ns + (step + 1.0) * cycle_ns);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0xffu, convert_dead_time(7000, 168000000u)); // the longest
}

static void test_the_bridges_output_is_in_ampere(void)
{
    const double full = (double)CONVERT_BRIDGE_FULL_A;
#ifdef TRIBO_ARITHMETIC_Q31
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.5f * CONVERT_BRIDGE_FULL_A, convert_bridge(1 << 30));
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, -CONVERT_BRIDGE_FULL_A, convert_bridge(INT32_MIN));
#else
    TEST_ASSERT_EQUAL_FLOAT(-1.5f, convert_bridge(-1.5f));
#endif
    config                    = rig_config;
    config.command_zero_units = 0.0f;
    config.command_n_per_unit = 1.0f; // N/A
    const port_t bridge       = {.sensor = CONVERT_SENSOR_RANGE, .output = CONVERT_BRIDGE_RANGE};
    TEST_ASSERT_TRUE(scaling_init(&scaling, &config, &bridge, &error));
    for (double u_n = -2.0; u_n <= 2.0; u_n += 0.01)
    {
        const float a = convert_bridge(scaling_output(&scaling, board_force(u_n)));
        TEST_ASSERT_TRUE(fabs((double)a - u_n) < full * 1e-6);
    }
}

#include "runners/test_convert.inc" // main
