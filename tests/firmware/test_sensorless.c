// A drive without a force sensor: what it asks of its config, which way its friction acts, and what it learns beside a position loop
// on an arm that the library knows nothing of.

#include "app/drive.h"
#include "app/params.h"
#include "board.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define PERIOD_US 1000u
#define BREAKAWAY 0.1f // believed
#define BELIEF    0.9
#define WIDTH     10u // counts of the position

static board_t       board;
static drive_t       drive;
static params_t      params;
static loop_memory_t memory;

static params_set_t blind_set(void)
{
    params_set_t   set   = params_default();
    const float    level = BREAKAWAY;
    const uint32_t none  = 0;
    memcpy((uint32_t *)&set + PARAMS_BREAKAWAY_OFFSET, &level, sizeof level);
    memcpy((uint32_t *)&set + PARAMS_BREAKAWAY_NEGATIVE_OFFSET, &level, sizeof level);
    memcpy((uint32_t *)&set + PARAMS_BREAKAWAY_SLOPE, &none, sizeof none);
    memcpy((uint32_t *)&set + PARAMS_BREAKAWAY_NEGATIVE_SLOPE, &none, sizeof none);
    set.method             = PARAMS_METHOD_SENSORLESS;
    set.drive.period_us    = PERIOD_US;
    set.drive.residual_n   = 0.0f;
    set.drive.tracking_n   = 0.0f;
    set.drive.reference_ms = 0;
    return set;
}

static void power_up(const params_set_t *set)
{
    params_error_t error;
    board_init(&board, 0);
    board.port.measures |= PORT_MEASURES_POSITION;
    board.silent = true; // there is none
    params.set   = *set;
    TEST_ASSERT_TRUE(params_make(&params, &board.port, &error));
    drive_init(&drive, &board.port, &params.drive, DRIVE_FAULT_NONE);
    loop_forget(&params.loop.params, &memory);
    drive_attach(&drive, &memory);
}

static void power_up_with_position(uint32_t reversed)
{
    params_set_t set          = blind_set();
    set.drive.motion_units    = WIDTH;
    set.drive.motion_reversed = reversed;
    power_up(&set);
}

void setUp(void)
{
    memset(&memory, 0xff, sizeof memory); // loop_forget has to begin it
    const params_set_t set = blind_set();
    power_up(&set);
}

void tearDown(void)
{
    TEST_ASSERT_FALSE_MESSAGE(board.moved_while_off, "a command while the power stage was off");
}

static void tick(void)
{
    board_new_tick(&board);
    drive_tick(&drive);
    board.now_us += PERIOD_US;
}

static void start(void)
{
    drive_start(&drive);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

static double command_n(void)
{
    return (double)scaling_value(board.command, BOARD_FULL_SCALE_N);
}

/// r goes to `end` within 100 ticks, and stays for the actuator's lead to end. The command less r: what is fed forward.
static double added_after(double begin, double end)
{
    for (int i = 1; i <= 100; i++)
    {
        drive_set_reference(&drive, board_force(begin + (end - begin) * i / 100.0));
        tick();
    }
    for (unsigned i = 0; i < 1000; i++)
    {
        tick();
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    return command_n() - end;
}

// --- the config ----------------------------------------------------------------------------------------------------

static void test_a_level_of_a_sensor_that_there_is_not_is_refused(void)
{
    const params_set_t blind = blind_set();
    params_error_t     error;
#define CHECK(field, level)                                                                                            \
    params.set             = blind;                                                                                    \
    params.set.drive.field = (level);                                                                                  \
    TEST_ASSERT_FALSE(params_make(&params, &board.port, &error));                                                      \
    TEST_ASSERT_EQUAL_UINT32(DRIVE_CONFIG_##field, error.word);                                                        \
    TEST_ASSERT_EQUAL_FLOAT((float)(level), error.value);                                                              \
    TEST_ASSERT_EQUAL_FLOAT(0.0f, error.high);
    CHECK(residual_n, 0.11f)
    CHECK(tracking_n, 0.3f)
    CHECK(stuck_ticks, 5)
    CHECK(tare_max_n, 0.1f)
#undef CHECK
}

/// The ends of the converter are within input_max, so a broken wire would not be seen; but there is no sensor.
static void test_the_range_of_a_sensor_that_there_is_not_does_not_matter(void)
{
    params_error_t error;
    board.port.sensor.low_units  = -1.0f;
    board.port.sensor.high_units = 1.0f;
    params.set                   = blind_set();
    TEST_ASSERT_TRUE(params_make(&params, &board.port, &error));
    params.set.method = PARAMS_METHOD_FEEDFORWARD;
    TEST_ASSERT_FALSE(params_make(&params, &board.port, &error));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_CONFIG_sensor_n_per_unit, error.word);
}

static void test_a_position_that_the_board_does_not_measure_is_refused(void)
{
    params_error_t error;
    params.set                    = blind_set();
    params.set.drive.motion_units = WIDTH;
    board.port.measures           = 0;
    TEST_ASSERT_FALSE(params_make(&params, &board.port, &error));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_CONFIG_motion_units, error.word);
}

static void test_no_client_takes_the_sensor_away_or_gives_one(void)
{
    params_set_t   blind = blind_set();
    params_set_t   sees  = params_default();
    params_error_t error;
    TEST_ASSERT_TRUE(params_check_method(&blind, &blind, &error));
    TEST_ASSERT_FALSE(params_check_method(&blind, &sees, &error));
    TEST_ASSERT_EQUAL_UINT32(PARAMS_METHOD_AT, error.word);
    TEST_ASSERT_EQUAL_FLOAT(2.0f, error.high);
    for (uint32_t method = PARAMS_METHOD_PAPER; method <= PARAMS_METHOD_OFF; method++)
    {
        sees.method = method;
        TEST_ASSERT_TRUE(params_check_method(&sees, &sees, &error));
        TEST_ASSERT_FALSE(params_check_method(&sees, &blind, &error));
        TEST_ASSERT_EQUAL_FLOAT((float)method, error.value);
        TEST_ASSERT_EQUAL_FLOAT(3.0f, error.low);
        TEST_ASSERT_EQUAL_FLOAT(3.0f, error.high);
    }
}

// --- the tick ------------------------------------------------------------------------------------------------------

static void test_a_silent_or_implausible_sensor_is_not_judged(void)
{
    start();
    for (int i = 0; i < 100; i++)
    {
        board.silent = i % 2 == 0;
        board.y      = board_force(i % 3 == 0 ? 3.9 : -3.9);
        tick();
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    TEST_ASSERT_TRUE(drive.y == 0);
}

static void test_there_is_no_tare(void)
{
    drive_tare(&drive);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_TARE_REFUSED, drive.tare);
}

static void test_friction_is_fed_against_the_motion_of_r(void)
{
    start();
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, BELIEF * (double)BREAKAWAY, added_after(0.0, 0.5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -BELIEF * (double)BREAKAWAY, added_after(0.5, 0.3));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, BELIEF * (double)BREAKAWAY, added_after(0.3, 0.4));
}

/// The arm moves by `counts` a tick, r stands: the command less r.
static double added_in_motion(int32_t counts)
{
    drive_set_reference(&drive, board_force(0.5));
    for (unsigned i = 0; i < 1000; i++)
    {
        board.measured.position = (int32_t)((uint32_t)board.measured.position + (uint32_t)counts);
        tick();
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    return command_n() - 0.5;
}

static void test_friction_opposes_the_measured_motion(void)
{
    for (uint32_t reversed = 0; reversed < 2u; reversed++)
    {
        const double fed = (reversed != 0u ? -BELIEF : BELIEF) * (double)BREAKAWAY;
        power_up_with_position(reversed);
        board.measured.position = INT32_MAX - 500; // it wraps on the way
        start();
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, fed, added_in_motion(3));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, -fed, added_in_motion(-2));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, -fed, added_in_motion(0)); // at rest, as before
    }
}

static void test_where_the_arm_is_at_the_start_is_no_motion(void)
{
    power_up_with_position(0);
    drive_position_reference(&drive, 100000);
    board.measured.position = 100000;
    tick();
    start();
    drive_set_reference(&drive, board_force(0.5));
    tick();
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.5, command_n()); // no sign yet
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, added_in_motion(0));
    drive_position_reference(&drive, 100000 - 2 * (int32_t)WIDTH);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -BELIEF * (double)BREAKAWAY, added_in_motion(0));
}

/// This happens where a client applies motion_units and starts within one tick, or a board starts at once.
static void test_a_start_in_the_first_tick_is_no_motion(void)
{
    power_up_with_position(0);
    board.measured.position = 100000;
    start();
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, added_in_motion(0));
    board.measured.position -= 2 * (int32_t)WIDTH;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -BELIEF * (double)BREAKAWAY, added_in_motion(0));
}

static void test_a_move_while_the_power_stage_is_off_is_no_motion(void)
{
    power_up_with_position(0);
    tick();
    board.measured.position = 100;
    start();
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, added_in_motion(0));
}

/// To where the arm is, in a run and after whatever ends one; the next is a motion.
static void check_first_position(int32_t first)
{
    drive_position_reference(&drive, first);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, added_in_motion(0));
    drive_position_reference(&drive, first - 2 * (int32_t)WIDTH);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -BELIEF * (double)BREAKAWAY, added_in_motion(0));
}

static void test_the_first_position_that_a_host_tells_is_no_motion(void)
{
    power_up_with_position(0);
    start();
    check_first_position(50000);
    drive_stop(&drive);
    tick();
    start();
    check_first_position(-70000);
    board.inputs = PORT_INPUT_EMERGENCY_STOP;
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
    drive_position_reference(&drive, 3);
    board.inputs = 0;
    drive_acknowledge(&drive);
    tick();
    start();
    check_first_position(INT32_MAX - 5);
    board.inputs = PORT_INPUT_EMERGENCY_STOP;
    tick();
    board.inputs = 0;
    drive_acknowledge(&drive);
    tick();
    start();
    check_first_position(INT32_MIN + 2 * (int32_t)WIDTH);
}

/// A sixteenth of what is left a tick, so that a bus of some ten ticks has no rests between its positions.
static void test_a_position_is_gone_to_over_some_ticks(void)
{
    power_up_with_position(0);
    drive_position_reference(&drive, INT32_MAX);
    start();
    drive_position_reference(&drive, INT32_MIN + 255); // 256 on: it wraps
    tick();
    TEST_ASSERT_EQUAL_INT32(INT32_MIN + 16, drive.intended);
    drive_position_reference(&drive, INT32_MIN + 2);
    tick();
    TEST_ASSERT_EQUAL_INT32(INT32_MIN + 15, drive.intended);
    for (unsigned i = 0; i < 13u; i++)
    {
        tick();
    }
    TEST_ASSERT_EQUAL_INT32(INT32_MIN + 2, drive.intended);
}

/// One of more widths than Q31 has.
static void test_a_jump_of_the_position_has_its_sign(void)
{
    for (int i = 0; i < 2; i++)
    {
        const double  fed = (i == 0 ? BELIEF : -BELIEF) * (double)BREAKAWAY;
        const int32_t far = i == 0 ? 1 << 30 : -(1 << 30);
        power_up_with_position(0);
        start();
        board.measured.position = far;
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, fed, added_in_motion(0));
        drive_position_reference(&drive, 0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, fed, added_in_motion(0));
        drive_position_reference(&drive, -far);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, -fed, added_in_motion(0));
    }
}

/// The position of a drive that has a sensor is for its speed alone.
static void test_a_drive_with_a_sensor_does_not_use_the_motion(void)
{
    params_set_t set       = params_default();
    set.drive.motion_units = WIDTH;
    set.drive.period_us    = PERIOD_US;
    set.drive.reference_ms = 0;
    power_up(&set);
    TEST_ASSERT_TRUE(params.drive.has_sensor);
    TEST_ASSERT_TRUE(params.drive.widths_per_unit == 0);
    board.silent = false;
    start();
    drive_position_reference(&drive, 100000);
    board.measured.position = -100000;
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    TEST_ASSERT_EQUAL_INT32(0, drive.position);
    TEST_ASSERT_EQUAL_INT32(0, drive.intended);
}

/// With any values from the bus and the encoder, u stays within the friction that is fed forward, and reaches it in steps.
static void test_wild_positions_move_u_by_no_more_than_friction(void)
{
    const double jump = 2.5 * BELIEF * (double)BREAKAWAY;
    uint32_t     x    = 1;
    power_up_with_position(0);
    start();
    drive_set_reference(&drive, board_force(0.5));
    tick();
    for (unsigned k = 0; k < 20000u; k++)
    {
        x                       = x * 1664525u + 1013904223u;
        board.measured.position = (int32_t)(k % 3u == 0u ? x : 0x80000000u - x);
        drive_position_reference(&drive, (int32_t)(x * 0x9e3779b9u));
        const double before = command_n();
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
        TEST_ASSERT_DOUBLE_WITHIN(1.5 * BELIEF * (double)BREAKAWAY, 0.5, command_n());
        TEST_ASSERT_DOUBLE_WITHIN(jump, before, command_n());
    }
}

static void test_less_than_a_width_is_no_motion(void)
{
    power_up_with_position(0);
    start();
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, BELIEF * (double)BREAKAWAY, added_in_motion(3));
    board.measured.position -= (int32_t)WIDTH / 2;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, BELIEF * (double)BREAKAWAY, added_in_motion(0));
    board.measured.position -= (int32_t)WIDTH;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -BELIEF * (double)BREAKAWAY, added_in_motion(0));
}

// --- beside a position loop ----------------------------------------------------------------------------------------

#define MASS         0.05 // N s^2/count: the arm, whose force is u
#define TRUE_L       0.15 // N, Coulomb's, the same in both directions
#define COUNT        1e-4 // of the arm's position
#define STROKE       0.2  // N: of the arm's position, 2,000 counts
#define STROKE_TICKS 1000u
#define STEPS        10 // of the arm in a tick

/// An arm of 0.05 kg with Coulomb friction, in m.
static struct
{
    double position, speed;
} arm;

static void move_arm(double u)
{
    const double h = 1e-6 * PERIOD_US / STEPS;
    for (int i = 0; i < STEPS; i++)
    {
        const double free    = arm.speed + h * u / MASS;
        const double stopped = h * TRUE_L / MASS;
        arm.speed            = free > stopped ? free - stopped : free < -stopped ? free + stopped : 0.0;
        arm.position += h * arm.speed;
    }
}

/// A host's position loop moves the arm to and fro, its effort is r. If it `tells` where to, friction opposes that motion, else the
/// measured. The RMS error of the last stroke.
static double strokes(unsigned count, bool tells)
{
    double squares = 0.0;
    for (unsigned k = 0; k < count * STROKE_TICKS; k++)
    {
        const double phase    = 2.0 * 3.14159265358979 * (double)(k % (2u * STROKE_TICKS)) / (2.0 * STROKE_TICKS);
        const double omega    = 3.14159265358979 / (1e-6 * PERIOD_US * STROKE_TICKS);
        const double wanted   = 0.5 * STROKE * (1.0 - cos(phase));
        const double rate     = 0.5 * STROKE * omega * sin(phase);
        const double pull     = 0.5 * STROKE * omega * omega * cos(phase);
        const double measured = COUNT * floor(arm.position / COUNT);
        const double error    = wanted - measured;
        if (tells && k % 10u == 0u) // a bus is slower than the tick
        {
            drive_position_reference(&drive, (int32_t)floor(wanted / COUNT));
        }
        drive_set_reference(&drive, board_force(20.0 * error + 1.5 * (rate - arm.speed) + MASS * pull));
        board.measured.position = (int32_t)floor(arm.position / COUNT);
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
        move_arm(command_n());
        squares += k + STROKE_TICKS >= count * STROKE_TICKS ? (wanted - arm.position) * (wanted - arm.position) : 0.0;
    }
    return sqrt(squares / STROKE_TICKS);
}

static double learned_n(uint32_t direction)
{
    return (double)loop_learned(&params.loop.params, &memory, direction, 0).L_n;
}

static void start_at(double position)
{
    arm.position            = position;
    arm.speed               = 0.0;
    board.measured.position = (int32_t)floor(position / COUNT);
    tick();
    start();
}

/// From two thirds of the breakaway as believed. The error after it over that before.
static double check_learning(bool tells)
{
    power_up_with_position(0);
    start_at(0.0);
    const double before = strokes(2, tells);
    const double after  = strokes(60, tells);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * TRUE_L, TRUE_L, learned_n(TRIBO_BREAKAWAY_POSITIVE));
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * TRUE_L, TRUE_L, learned_n(TRIBO_BREAKAWAY_NEGATIVE));
    return after / before;
}

static void test_breakaway_is_learned_next_to_a_position_loop(void)
{
    TEST_ASSERT_TRUE(check_learning(true) < 0.4);
    TEST_ASSERT_TRUE(check_learning(false) < 1.0); // friction turns late
}

static void test_what_is_learned_outlasts_a_stop_until_it_is_forgotten(void)
{
    power_up_with_position(0);
    start_at(0.0);
    (void)strokes(60, true);
    drive_stop(&drive);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
    start_at(0.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * TRUE_L, TRUE_L, learned_n(TRIBO_BREAKAWAY_POSITIVE));
    drive_stop(&drive);
    tick();
    drive_forget(&drive);
    tick();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, (double)BREAKAWAY, learned_n(TRIBO_BREAKAWAY_POSITIVE));
}

/// No slide: what was learned stays, and friction acts as it did.
static void test_an_encoder_that_stands_still_changes_nothing(void)
{
    power_up_with_position(0);
    start();
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, BELIEF * (double)BREAKAWAY, added_in_motion(3));
    const double learned = learned_n(TRIBO_BREAKAWAY_POSITIVE);
    for (int i = 0; i < 20; i++)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, BELIEF * (double)BREAKAWAY, added_in_motion(0));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, learned, learned_n(TRIBO_BREAKAWAY_POSITIVE));
}

#include "runners/test_sensorless.inc" // main
