// When the bridge's outputs may be on: calibration, and each trip in whatever sample it comes.

#include "bridge/bridge.h"

#include "unity.h"

#include <math.h>

#define A_PER_CODE 0.004f
#define V_PER_CODE 0.016f
#define TRIP_A     3.0f
#define TRIP_V     36.0f
#define MIDDLE     2048u
#define BUS        1500u // 24 V

static bridge_t         bridge;
static bridge_brushed_t motor;
static bridge_sample_t  sample;
static bridge_duty_t    duty;
static bool             are_on;

static void init(bridge_law_t law, uint32_t currents)
{
    const current_config_t config = {.resistance_ohm = 2.0f,
                                     .inductance_h   = 1e-3f,
                                     .bandwidth_hz   = 1250.0f,
                                     .sample_time_s  = 50e-6f,
                                     .limit_a        = 2.0f};
    TEST_ASSERT_TRUE(current_init(&motor.params, &config));
    bridge_init(&bridge,
                &(bridge_params_t){.a_per_code = A_PER_CODE,
                                   .v_per_code = V_PER_CODE,
                                   .trip_a     = TRIP_A,
                                   .trip_v     = TRIP_V,
                                   .currents   = currents,
                                   .law        = law,
                                   .context    = &motor,
                                   .begin      = bridge_brushed_begin});
    sample = (bridge_sample_t){.current = {MIDDLE, MIDDLE}, .bus = BUS};
    are_on = false;
}

void setUp(void)
{
    init(bridge_brushed, 1);
}

static bool step(void)
{
    are_on = bridge_step(&bridge, &sample, are_on, &duty);
    if (!are_on)
    {
        for (unsigned i = 0; i < BRIDGE_LEGS; i++)
        {
            TEST_ASSERT_EQUAL_FLOAT(0.5f, duty.leg[i]);
        }
    }
    return are_on;
}

/// With a command in each millisecond, as the tick gives it.
static bool run(unsigned samples, float reference_a)
{
    for (unsigned i = 0; i < samples; i++)
    {
        if (i % 20u == 0u)
        {
            bridge_command(&bridge, reference_a);
        }
        (void)step();
    }
    return are_on;
}

static void turn_on(void)
{
    bridge_want(&bridge, true);
    TEST_ASSERT_TRUE(run(BRIDGE_OFFSET_SAMPLES + 1u, 0.0f));
}

static void test_the_outputs_stay_off_until_they_are_wanted_and_calibrated(void)
{
    TEST_ASSERT_FALSE(run(1000, 1.0f));
    bridge_want(&bridge, true);
    TEST_ASSERT_FALSE(run(BRIDGE_OFFSET_SAMPLES, 1.0f));
    TEST_ASSERT_TRUE(step());
    bridge_want(&bridge, false);
    TEST_ASSERT_FALSE(step());
    TEST_ASSERT_EQUAL_INT(BRIDGE_TRIP_NONE, bridge_take_trip(&bridge));
}

static void test_the_mean_code_without_current_is_0_a(void)
{
    bridge_want(&bridge, true);
    for (unsigned i = 0; i <= BRIDGE_OFFSET_SAMPLES; i++)
    {
        sample.current[0] = MIDDLE + 40u + i % 2u; // 40.5
        (void)step();
    }
    TEST_ASSERT_TRUE(are_on);
    sample.current[0] = MIDDLE + 40u + 250u;
    (void)step();
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 249.5f * A_PER_CODE, bridge.measured.current_a[0]);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 24.0f, bridge.measured.bus_v);
    // Each start anew.
    bridge_want(&bridge, false);
    sample.current[0] = MIDDLE - 20u;
    (void)step();
    turn_on();
    (void)step();
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 0.0f, bridge.measured.current_a[0]);
}

static void check_trip(bridge_trip_t cause)
{
    TEST_ASSERT_FALSE(are_on);
    TEST_ASSERT_EQUAL_INT(cause, bridge_take_trip(&bridge));
    TEST_ASSERT_EQUAL_INT(BRIDGE_TRIP_NONE, bridge_take_trip(&bridge));
    sample = (bridge_sample_t){.current = {MIDDLE, MIDDLE}, .bus = BUS};
    TEST_ASSERT_FALSE(run(1000, 1.0f)); // it does not start again by itself ...
    TEST_ASSERT_EQUAL_INT(BRIDGE_TRIP_NONE, bridge_take_trip(&bridge));
    bridge_want(&bridge, false);
    TEST_ASSERT_FALSE(step());
    turn_on(); // ... but where it is wanted anew
    bridge_want(&bridge, false);
    (void)step();
}

static void test_an_offset_that_cannot_be_one_is_a_trip(void)
{
    const uint32_t codes[] = {MIDDLE + BRIDGE_OFFSET_MOST + 1u, MIDDLE - BRIDGE_OFFSET_MOST - 1u};
    for (unsigned i = 0; i < 2; i++)
    {
        sample.current[0] = codes[i];
        bridge_want(&bridge, true);
        (void)run(BRIDGE_OFFSET_SAMPLES + 1u, 0.0f);
        check_trip(BRIDGE_TRIP_OFFSET);
    }
    sample.current[0] = MIDDLE + BRIDGE_OFFSET_MOST;
    turn_on();
}

static void test_a_current_while_the_outputs_are_off_is_a_trip(void)
{
    bridge_want(&bridge, true);
    (void)run(100, 0.0f);
    sample.current[0] = MIDDLE + BRIDGE_SPREAD_MOST + 1u;
    (void)step();
    sample.current[0] = MIDDLE;
    (void)run(BRIDGE_OFFSET_SAMPLES - 100u, 0.0f);
    check_trip(BRIDGE_TRIP_OFFSET);
}

static void test_two_samples_beyond_the_level_are_a_trip_at_whatever_time(void)
{
    for (unsigned at = 0; at < 50; at++)
    {
        for (int sign = -1; sign <= 1; sign += 2)
        {
            turn_on();
            (void)run(at, 1.0f);
            sample.current[0] = (uint32_t)((int)MIDDLE + sign * 760); // 3.04 A
            TEST_ASSERT_TRUE(step());
            TEST_ASSERT_FALSE(step());
            check_trip(BRIDGE_TRIP_CURRENT);
        }
    }
}

static void test_two_samples_of_a_bus_beyond_its_level_are_a_trip(void)
{
    for (unsigned at = 0; at < 50; at++)
    {
        turn_on();
        (void)run(at, 1.0f);
        sample.bus = 2251; // 36.016 V
        TEST_ASSERT_TRUE(step());
        TEST_ASSERT_FALSE(step());
        check_trip(BRIDGE_TRIP_BUS);
    }
    turn_on();
    sample.bus = 2250;
    TEST_ASSERT_TRUE(run(100, 0.0f));
    for (unsigned i = 0; i < 100; i++)
    {
        sample.bus = i % 5u == 0u ? 2300 : BUS;
        TEST_ASSERT_TRUE(run(1, 0.0f));
    }
    for (unsigned i = 0; i < 5; i++)
    {
        sample.bus = i % 2u == 0u ? 2300 : BUS;
        TEST_ASSERT_EQUAL_INT(i < 4, run(1, 0.0f));
    }
    check_trip(BRIDGE_TRIP_BUS);
}

/// The second current's converter has no pin then.
static void test_a_motor_with_one_winding_has_one_current(void)
{
    for (unsigned code = 0; code < BRIDGE_CODES; code += 5u)
    {
        sample.current[1] = code;
        (void)run(1, 0.0f);
    }
    turn_on();
    for (unsigned code = 0; code < BRIDGE_CODES; code += 5u)
    {
        sample.current[1] = code;
        TEST_ASSERT_TRUE(run(1, 0.0f));
    }
}

/// The current is beyond its limit in one of `of` samples. Returns the samples until the trip; 1000: none.
static unsigned samples_until_trip(unsigned of)
{
    turn_on();
    for (unsigned i = 0; i < 1000u; i++)
    {
        sample.current[0] = i % of == 0u ? MIDDLE + 760u : MIDDLE;
        if (!run(1, 0.0f))
        {
            sample.current[0] = MIDDLE;
            check_trip(BRIDGE_TRIP_CURRENT);
            return i + 1u;
        }
    }
    return 1000u;
}

static void test_single_samples_beyond_the_level_are_a_trip_if_they_are_many(void)
{
    TEST_ASSERT_EQUAL_UINT(5u, samples_until_trip(2));
    TEST_ASSERT_EQUAL_UINT(17u, samples_until_trip(4));
    TEST_ASSERT_EQUAL_UINT(1000u, samples_until_trip(5));
    TEST_ASSERT_EQUAL_UINT(1000u, samples_until_trip(50));
}

static void test_a_sensor_at_a_rail_is_a_trip_in_every_state(void)
{
    const uint32_t rails[] = {0u, BRIDGE_RAIL - 1u, BRIDGE_CODES - BRIDGE_RAIL, BRIDGE_CODES - 1u};
    for (unsigned i = 0; i < 4; i++)
    {
        for (unsigned state = 0; state < 3; state++)
        {
            bridge_want(&bridge, state > 0);
            TEST_ASSERT_EQUAL_INT(state == 2, run(state == 1 ? 100 : 300, 0.0f));
            sample.current[0] = rails[i];
            (void)step();
            TEST_ASSERT_EQUAL_INT(BRIDGE_TRIP_NONE, bridge_take_trip(&bridge));
            (void)step();
            check_trip(BRIDGE_TRIP_SENSOR);
        }
    }
}

static void test_a_reading_at_the_rail_trips_again_and_again(void)
{
    sample.current[0] = 0;
    for (unsigned tick = 0; tick < 100; tick++)
    {
        (void)run(20, 0.0f);
        TEST_ASSERT_EQUAL_INT(BRIDGE_TRIP_SENSOR, bridge_take_trip(&bridge));
    }
}

static void test_a_command_that_is_not_renewed_is_a_trip(void)
{
    turn_on();
    (void)run(41, 1.0f); // the last command is one sample old
    for (unsigned i = 0; i < BRIDGE_STALE_SAMPLES - 1u; i++)
    {
        TEST_ASSERT_TRUE(step());
    }
    TEST_ASSERT_FALSE(step());
    check_trip(BRIDGE_TRIP_STALE);
}

static void test_outputs_that_went_off_by_themselves_are_a_trip(void)
{
    turn_on();
    are_on = false;
    TEST_ASSERT_FALSE(step());
    check_trip(BRIDGE_TRIP_BREAK);
}

static void test_the_motors_legs_move_against_each_other(void)
{
    turn_on();
    (void)run(1, 1.0f);
    TEST_ASSERT_TRUE(duty.leg[0] > 0.6f);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f, duty.leg[0] + duty.leg[1]);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, duty.leg[2]);
    (void)run(1, -2.0f);
    TEST_ASSERT_TRUE(duty.leg[0] < 0.4f);
    // What dead time takes away is added, by the reference's sign.
    motor.state      = (current_state_t){.integral_v = 0.0f};
    motor.dead_share = bridge_dead_share(500u);
    (void)run(1, -1.0f);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 0.5f - motor.params.kp_v_per_a / 48.0f - 0.01f, duty.leg[0]);
    motor.dead_share = 0.0f;
    // At most BRIDGE_DUTY_MOST of the bus, and nothing of a bus that is not there.
    (void)run(100, 2.0f);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.5f + 0.5f * BRIDGE_DUTY_MOST, duty.leg[0]);
    sample.bus = 0;
    (void)run(1, 2.0f);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, duty.leg[0]);
}

static void test_each_start_begins_without_an_integral(void)
{
    turn_on();
    (void)run(100, 2.0f);
    TEST_ASSERT_TRUE(motor.state.integral_v > 1.0f);
    bridge_want(&bridge, false);
    (void)step();
    turn_on();
    TEST_ASSERT_EQUAL_FLOAT(0.0f, motor.state.integral_v);
}

/// A law of three phases at a fixed angle: i_q is the reference, i_d is 0.
static void field_oriented(void *context, float reference_a, const bridge_measured_t *measured, bridge_duty_t *to)
{
    (void)context;
    const float angle = 0.7f;
    const float alpha = measured->current_a[0];
    const float beta  = (measured->current_a[0] + 2.0f * measured->current_a[1]) / sqrtf(3.0f);
    const float d     = cosf(angle) * alpha + sinf(angle) * beta;
    const float q     = cosf(angle) * beta - sinf(angle) * alpha;
    const float v_d = -5.0f * d, v_q = 5.0f * (reference_a - q);
    const float v_alpha = cosf(angle) * v_d - sinf(angle) * v_q, v_beta = sinf(angle) * v_d + cosf(angle) * v_q;
    to->leg[0] = 0.5f + v_alpha / measured->bus_v;
    to->leg[1] = 0.5f + (-0.5f * v_alpha + 0.5f * sqrtf(3.0f) * v_beta) / measured->bus_v;
    to->leg[2] = 0.5f + (-0.5f * v_alpha - 0.5f * sqrtf(3.0f) * v_beta) / measured->bus_v;
}

static void test_a_law_of_three_phases_takes_the_place_of_the_motors(void)
{
    init(field_oriented, 2);
    turn_on();
    (void)run(1, 1.0f);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.5f, duty.leg[0] + duty.leg[1] + duty.leg[2]);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.5f - 5.0f * sinf(0.7f) / 24.0f, duty.leg[0]);
    const float before = duty.leg[1];
    sample.current[1]  = MIDDLE + 250u; // the second phase's
    (void)run(1, 1.0f);
    TEST_ASSERT_TRUE(fabsf(duty.leg[1] - before) > 0.01f);
    sample.current[0] = MIDDLE + 760u;
    (void)run(2, 1.0f);
    check_trip(BRIDGE_TRIP_CURRENT);
}

/// Each phase, of which the third's current is not measured; either converter at a rail; either offset.
static void test_of_three_phases_each_trips(void)
{
    static const struct
    {
        int           codes[2];
        bridge_trip_t cause;
    } cases[] = {{{760, 0}, BRIDGE_TRIP_CURRENT},
                 {{0, 760}, BRIDGE_TRIP_CURRENT},
                 {{0, -760}, BRIDGE_TRIP_CURRENT},
                 {{380, 380}, BRIDGE_TRIP_CURRENT},
                 {{-380, -380}, BRIDGE_TRIP_CURRENT},
                 {{0, -2000}, BRIDGE_TRIP_SENSOR},
                 {{2000, 0}, BRIDGE_TRIP_SENSOR}};
    init(field_oriented, 2);
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++)
    {
        turn_on();
        sample.current[0] = (uint32_t)((int)MIDDLE + cases[i].codes[0]);
        sample.current[1] = (uint32_t)((int)MIDDLE + cases[i].codes[1]);
        (void)run(2, 0.0f);
        check_trip(cases[i].cause);
    }
    turn_on();
    sample.current[0] = MIDDLE + 700u;
    sample.current[1] = MIDDLE - 700u;
    TEST_ASSERT_TRUE(run(100, 0.0f)); // no phase beyond it
    bridge_want(&bridge, false);
    (void)step();
    sample.current[0] = MIDDLE;
    sample.current[1] = MIDDLE + BRIDGE_OFFSET_MOST + 1u;
    bridge_want(&bridge, true);
    (void)run(BRIDGE_OFFSET_SAMPLES + 1u, 0.0f);
    check_trip(BRIDGE_TRIP_OFFSET);
}

#include "runners/test_bridge.inc" // main
