// The RP2040's converter codes and PWM compare values, with the scaling of its rig.

#include "app/scaling.h"
#include "board.h"
#include "port/rp2040/convert.h"
#include "port/rp2040/rig_config.h"
#include "unity.h"

#include <math.h>

static const port_t port = {.sensor = CONVERT_SENSOR_RANGE, .output = CONVERT_OUTPUT_RANGE};

static drive_config_t       config;
static scaling_t            scaling;
static drive_config_error_t error;

void setUp(void)
{
    config = rig_config();
    TEST_ASSERT_TRUE(scaling_init(&scaling, &config, &port, &error));
}

static uint32_t compare_of(double force_n)
{
    return convert_output(scaling_output(&scaling, board_force(force_n)));
}

static void test_a_force_is_the_share_of_a_period_forward_or_backward(void)
{
    for (int i = -CONVERT_TOP; i <= CONVERT_TOP; i++)
    {
        const uint32_t compare = compare_of(2.0 * i / CONVERT_TOP);
        const int      forward = (int)(compare & 0xffffu), backward = (int)(compare >> 16);
        TEST_ASSERT_TRUE(forward == 0 || backward == 0);
        TEST_ASSERT_INT_WITHIN(1, i, forward - backward);
    }
}

static void test_what_is_beyond_the_range_is_its_end(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, compare_of(0.0));
    TEST_ASSERT_EQUAL_UINT32(CONVERT_TOP, compare_of(2.0));
    TEST_ASSERT_EQUAL_UINT32((uint32_t)CONVERT_TOP << 16, compare_of(-2.0));
#ifdef TRIBO_ARITHMETIC_Q31
    TEST_ASSERT_EQUAL_UINT32(CONVERT_TOP, convert_output(INT32_MAX));
    TEST_ASSERT_EQUAL_UINT32((uint32_t)CONVERT_TOP << 16, convert_output(INT32_MIN));
#else
    TEST_ASSERT_EQUAL_UINT32(CONVERT_TOP, convert_output(INFINITY));
    TEST_ASSERT_EQUAL_UINT32((uint32_t)CONVERT_TOP << 16, convert_output(-1e30f));
    TEST_ASSERT_EQUAL_UINT32(0u, convert_output(NAN));
#endif
}

static void test_the_mean_of_codes_is_a_force(void)
{
    for (uint32_t code = 0; code <= CONVERT_CODES_MAX; code++)
    {
        const loop_force_t y = scaling_force(&scaling, scaling.sensor_zero, convert_sensor(16u * code, 16u));
        const double n = (double)tribo_force_q31(y, config.full_scale_n) / 2147483648.0 * (double)config.full_scale_n;
        TEST_ASSERT_TRUE(fabs(n - ((double)code - 2048.0) * 2.0 / 1638.4) < 1e-6);
    }
}

static void test_what_the_bridge_shows_is_in_milliampere_and_millivolt(void)
{
    const port_measured_t measured = convert_measured(2048u + 248u, 1489u); // 1 A, 24 V
    TEST_ASSERT_INT32_WITHIN(5, 999, measured.current_ma);
    TEST_ASSERT_INT32_WITHIN(20, 24000, measured.bus_mv);
    TEST_ASSERT_EQUAL_INT32(-8250, convert_measured(0u, 0u).current_ma);
}

#include "runners/test_convert_rp2040.inc" // main
