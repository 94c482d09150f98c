// The drive's state machine through its port: every fault at 50 different ticks, and no output after it.

#include "app/drive.h"
#include "app/loop.h"
#include "board.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PERIOD_US   1000u
#define LATE_US     100u
#define BUDGET_US   500u
#define STUCK_TICKS 5u

static board_t        board;
static drive_t        drive;
static drive_config_t config;
static drive_setup_t  drive_setup_used;
static loop_setup_t   setup;
static loop_force_t   reference;
static unsigned       ticks;

/// A drive that begins with the fault `found`. The clock starts near its wrap, so that every run crosses it.
static void power_up_with(drive_fault_t found)
{
    drive_config_error_t error;
    board_init(&board, UINT32_MAX - 20u * PERIOD_US);
    TEST_ASSERT_TRUE(drive_setup_init(&drive_setup_used, &config, &setup.params, &board.port, &error));
    drive_init(&drive, &board.port, &drive_setup_used, found);
    reference = board_force(0.5);
    ticks     = 0;
}

static void power_up(void)
{
    power_up_with(DRIVE_FAULT_NONE);
}

/// The sensor here does not follow the command, so the rig's faults are off: they have tests of their own.
void setUp(void)
{
    const tribo_force_loop_f32_config_t paper = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_setup(&setup, &paper, BOARD_FULL_SCALE_N));
    config                  = drive_config_default();
    config.period_us        = PERIOD_US;
    config.late_us          = LATE_US;
    config.budget_us        = BUDGET_US;
    config.stuck_ticks      = STUCK_TICKS;
    config.residual_n       = 0.0f;
    config.command_limit_ms = 0;
    power_up();
}

void tearDown(void)
{
    TEST_ASSERT_FALSE_MESSAGE(board.moved_while_off, "a command while the power stage was off");
    TEST_ASSERT_FALSE_MESSAGE(board.off_late, "the power stage went off behind a command");
}

/// A tick one period after the last one, with a sensor that changes every tick.
static void tick(void)
{
    board_new_tick(&board);
    board.y = board_force(0.3 + 0.001 * (double)(ticks % 7u));
    drive_reference(&drive, reference);
    drive_tick(&drive);
    ticks++;
    board.now_us += PERIOD_US;
}

static void run_until(unsigned count)
{
    while (ticks < count)
    {
        tick();
    }
}

static void check_off(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, tribo_force_word(board.command));
    TEST_ASSERT_FALSE(board.enabled);
}

static void check_running(void)
{
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    TEST_ASSERT_TRUE(board.enabled);
    TEST_ASSERT_NOT_EQUAL(0, tribo_force_word(board.command));
    TEST_ASSERT_EQUAL_UINT(1, board.commands);
}

static void start(void)
{
    drive_start(&drive);
    tick();
    check_running();
}

// --- the faults ----------------------------------------------------------------------------------------------------

static void emergency_stop(void)
{
    board.inputs = PORT_INPUT_EMERGENCY_STOP;
}

static void power_fault(void)
{
    board.inputs = PORT_INPUT_POWER_FAULT;
}

static void supply_low(void)
{
    board.inputs = PORT_INPUT_SUPPLY;
}

static void bridge_off_by_current(void)
{
    board.inputs = PORT_INPUT_OVER_CURRENT;
}

static void bridge_off_by_voltage(void)
{
    board.inputs = PORT_INPUT_OVER_VOLTAGE;
}

static void miss_a_tick(void)
{
    board.now_us += PERIOD_US;
}

static void miss_many_ticks(void)
{
    board.now_us += 2000000000u;
}

static void be_late(void)
{
    board.now_us += LATE_US + 1u;
}

static void be_almost_a_tick_late(void)
{
    board.now_us += PERIOD_US - 1u;
}

static void be_early(void)
{
    board.now_us -= LATE_US + 1u;
}

static void stop_the_clock(void)
{
    board.now_us -= PERIOD_US;
}

static void silence_the_sensor(void)
{
    board.silent = true;
}

static void take_too_long(void)
{
    board.tick_us = BUDGET_US + 1u;
}

/// A fault, and the inputs of a tick with it.
typedef struct
{
    const char   *name;
    drive_fault_t cause;
    void (*inject)(void); ///< null: only y or r differ
    double y_n, r_n;      ///< 0: as without the fault
} injection_t;

static const injection_t injections[] = {
    {"emergency stop", DRIVE_FAULT_EMERGENCY_STOP, emergency_stop, 0.0, 0.0},
    {"power stage", DRIVE_FAULT_POWER, power_fault, 0.0, 0.0},
    {"supply", DRIVE_FAULT_SUPPLY, supply_low, 0.0, 0.0},
    {"bridge, current", DRIVE_FAULT_OVER_CURRENT, bridge_off_by_current, 0.0, 0.0},
    {"bridge, voltage", DRIVE_FAULT_BUS_VOLTAGE, bridge_off_by_voltage, 0.0, 0.0},
    {"a tick missed", DRIVE_FAULT_TICK_MISSED, miss_a_tick, 0.0, 0.0},
    {"many ticks missed", DRIVE_FAULT_TICK_MISSED, miss_many_ticks, 0.0, 0.0},
    {"late", DRIVE_FAULT_TICK_LATE, be_late, 0.0, 0.0},
    {"almost a tick late", DRIVE_FAULT_TICK_LATE, be_almost_a_tick_late, 0.0, 0.0},
    {"early", DRIVE_FAULT_TICK_EARLY, be_early, 0.0, 0.0},
    {"clock stopped", DRIVE_FAULT_TICK_EARLY, stop_the_clock, 0.0, 0.0},
    {"sensor silent", DRIVE_FAULT_SENSOR_SILENT, silence_the_sensor, 0.0, 0.0},
    {"sensor above its range", DRIVE_FAULT_SENSOR_RANGE, NULL, 2.001, 0.0},
    {"sensor below its range", DRIVE_FAULT_SENSOR_RANGE, NULL, -2.001, 0.0},
    {"overrun", DRIVE_FAULT_TICK_OVERRUN, take_too_long, 0.0, 0.0},
#ifndef TRIBO_ARITHMETIC_Q31
    {"sensor NaN", DRIVE_FAULT_NAN, NULL, (double)NAN, 0.0},
    {"reference NaN", DRIVE_FAULT_NAN, NULL, 0.0, (double)NAN},
    {"sensor infinite", DRIVE_FAULT_SENSOR_RANGE, NULL, (double)INFINITY, 0.0},
#endif
};

#define INJECTIONS (sizeof injections / sizeof injections[0])

static void set_force(loop_force_t *force, double force_n)
{
#ifdef TRIBO_ARITHMETIC_Q31
    *force = board_force(force_n);
#else
    *force = (float)force_n;
#endif
}

/// The tick with the fault.
static void tick_with(const injection_t *injection)
{
    loop_force_t r = reference;
    board_new_tick(&board);
    board.y = board_force(0.35);
    if (injection->inject != NULL)
    {
        injection->inject();
    }
    if (injection->y_n != 0.0)
    {
        set_force(&board.y, injection->y_n);
    }
    if (injection->r_n != 0.0)
    {
        set_force(&r, injection->r_n);
    }
    drive_reference(&drive, r);
    drive_tick(&drive);
    ticks++;
    board.now_us += PERIOD_US;
}

static void repair(void)
{
    board.inputs  = 0;
    board.silent  = false;
    board.tick_us = 20;
}

static void check_latched(const injection_t *injection)
{
    check_off();
    TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_FAULT, drive.state, injection->name);
    TEST_ASSERT_EQUAL_INT_MESSAGE(injection->cause, drive.fault, injection->name);
}

static void check_fault(const injection_t *injection, unsigned at)
{
    power_up();
    start();
    run_until(at);
    check_running();
    tick_with(injection);
    check_latched(injection); // within the same tick
    TEST_ASSERT_EQUAL_UINT32(at + 1u, drive.fault_tick);

    // It stays latched with and without its cause, until an acknowledgement.
    tick();
    check_latched(injection);
    repair();
    drive_start(&drive);
    for (unsigned i = 0; i < 20u; i++)
    {
        tick();
        check_latched(injection);
    }

    // Once acknowledged the drive is idle, and the start from before is dropped.
    drive_acknowledge(&drive);
    for (unsigned i = 0; i < 20u; i++)
    {
        tick();
        check_off();
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_IDLE, drive.state, injection->name);
        TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_NONE, drive.fault);
    }
    start();
    run_until(ticks + 20u);
    check_running();
    TEST_ASSERT_FALSE(board.moved_while_off);
}

/// Of several inputs the drive names the most important one.
static void test_the_most_important_input_is_named(void)
{
    static const struct
    {
        uint32_t      input;
        drive_fault_t cause;
    } order[]       = {{PORT_INPUT_EMERGENCY_STOP, DRIVE_FAULT_EMERGENCY_STOP},
                       {PORT_INPUT_SUPPLY, DRIVE_FAULT_SUPPLY},
                       {PORT_INPUT_OVER_CURRENT, DRIVE_FAULT_OVER_CURRENT},
                       {PORT_INPUT_OVER_VOLTAGE, DRIVE_FAULT_BUS_VOLTAGE},
                       {PORT_INPUT_POWER_FAULT, DRIVE_FAULT_POWER}};
    uint32_t inputs = UINT32_MAX;
    for (size_t i = 0; i < sizeof order / sizeof order[0]; i++)
    {
        setUp();
        start();
        board.inputs = inputs;
        tick();
        TEST_ASSERT_EQUAL_INT(order[i].cause, drive.fault);
        inputs &= ~order[i].input;
    }
}

static void test_every_fault_at_50_ticks_stops_in_that_tick_and_stays_until_acknowledged(void)
{
    for (unsigned i = 0; i < INJECTIONS; i++)
    {
        for (unsigned at = 1; at <= 50u; at++)
        {
            check_fault(&injections[i], at);
        }
    }
    printf("%u faults at 50 ticks each\n", (unsigned)INJECTIONS);
}

static void test_faults_of_an_idle_drive_are_latched_too(void)
{
    for (unsigned i = 0; i < INJECTIONS; i++)
    {
        if (injections[i].cause == DRIVE_FAULT_TICK_OVERRUN)
        {
            continue; // an idle tick does not run the loop
        }
        power_up();
        run_until(10);
        TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
        tick_with(&injections[i]);
        check_latched(&injections[i]);
        repair();
        drive_start(&drive);
        run_until(ticks + 5u);
        check_latched(&injections[i]);
    }
}

static void test_a_start_in_the_tick_of_a_fault_is_forgotten(void)
{
    for (unsigned i = 0; i < INJECTIONS; i++)
    {
        if (injections[i].cause == DRIVE_FAULT_TICK_OVERRUN)
        {
            continue; // detected only after the loop has run
        }
        power_up();
        run_until(10);
        drive_start(&drive);
        tick_with(&injections[i]);
        check_latched(&injections[i]);
        repair();
        drive_acknowledge(&drive);
        run_until(ticks + 5u);
        TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
        check_off();
    }
}

static void test_an_acknowledgement_does_nothing_while_the_cause_is_there(void)
{
    start();
    emergency_stop();
    tick();
    for (unsigned i = 0; i < 10u; i++)
    {
        drive_acknowledge(&drive);
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
        TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_EMERGENCY_STOP, drive.fault);
    }
    repair();
    tick(); // the acknowledgements were dropped
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
    drive_acknowledge(&drive);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
}

static void test_an_acknowledgement_before_the_fault_is_forgotten(void)
{
    start();
    for (unsigned i = 0; i < 3u; i++)
    {
        drive_acknowledge(&drive);
        drive_acknowledge(&drive);
        tick();
        check_running();
    }
    drive_acknowledge(&drive);
    emergency_stop();
    tick();
    repair();
    run_until(ticks + 10u);
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_EMERGENCY_STOP, drive.fault);
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
}

static void test_the_first_cause_stays_the_one_that_is_latched(void)
{
    start();
    power_fault();
    tick();
    board.inputs = PORT_INPUT_EMERGENCY_STOP | PORT_INPUT_POWER_FAULT;
    board.silent = true;
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_POWER, drive.fault);
}

static void test_of_causes_in_one_tick_the_first_of_the_list_is_latched(void)
{
    start();
    board.inputs = PORT_INPUT_EMERGENCY_STOP | PORT_INPUT_POWER_FAULT;
    board.silent = true;
    be_late();
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_EMERGENCY_STOP, drive.fault);
}

// --- the stuck sensor ----------------------------------------------------------------------------------------------

static void tick_stuck(void)
{
    board_new_tick(&board);
    drive_reference(&drive, reference);
    drive_tick(&drive);
    ticks++;
    board.now_us += PERIOD_US;
}

static void test_a_stuck_sensor_stops_at_50_ticks_once_it_has_not_changed_for_as_long_as_allowed(void)
{
    for (unsigned at = 1; at <= 50u; at++)
    {
        power_up();
        start();
        run_until(at);
        for (unsigned i = 1; i < STUCK_TICKS; i++)
        {
            tick_stuck();
            check_running();
        }
        tick_stuck();
        check_off();
        TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_SENSOR_STUCK, drive.fault);
        drive_acknowledge(&drive);
        tick_stuck();
        TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
        drive_start(&drive);
        tick();
        drive_acknowledge(&drive);
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
        check_off();
    }
}

static void test_a_change_in_the_last_moment_is_not_stuck(void)
{
    start();
    for (unsigned i = 0; i < 200u; i++)
    {
        board.y = board_force(i % STUCK_TICKS == 0u ? 0.30001 + 0.0001 * i
                                                    : 0.0001 * (double)(i - i % STUCK_TICKS) + 0.30001);
        tick_stuck();
        check_running();
    }
}

static void test_a_still_sensor_may_be_allowed(void)
{
    config.stuck_ticks = 0;
    power_up();
    start();
    for (unsigned i = 0; i < 1000u; i++)
    {
        tick_stuck();
        check_running();
    }
}

// --- no fault ------------------------------------------------------------------------------------------------------

static void test_jitter_within_its_bound_runs_on_and_is_measured(void)
{
    start();
    for (unsigned i = 0; i < 100u; i++)
    {
        const uint32_t shift = i % 2u == 0u ? LATE_US : (uint32_t)0u - LATE_US;
        board.now_us += shift;
        tick();
        board.now_us -= shift;
        check_running();
    }
    TEST_ASSERT_EQUAL_UINT32(LATE_US, drive.max_late_us);
}

static void test_a_tick_as_long_as_its_budget_runs_on_and_is_measured(void)
{
    start();
    board.tick_us = BUDGET_US;
    tick();
    check_running();
    TEST_ASSERT_EQUAL_UINT32(BUDGET_US, drive.max_tick_us);
    TEST_ASSERT_EQUAL_UINT32(0, drive.overruns);
    board.tick_us = BUDGET_US + 250u;
    tick();
    check_off();
    TEST_ASSERT_EQUAL_UINT(1, board.commands); // the 0 of the fault, not the loop's command
    TEST_ASSERT_EQUAL_UINT32(BUDGET_US + 250u, drive.max_tick_us);
    TEST_ASSERT_EQUAL_UINT32(1, drive.overruns);
}

static void test_limits_act_and_do_not_stop(void)
{
    start();
    TEST_ASSERT_EQUAL_UINT32(0, drive.limits);
    reference = board_force(1.9);
    run_until(ticks + 200u);
    TEST_ASSERT_EQUAL_UINT32(DRIVE_LIMIT_COMMAND, drive.limits);
    reference = board_force(2.1);
    tick();
    check_running();
    TEST_ASSERT_TRUE((drive.limits & DRIVE_LIMIT_REFERENCE) != 0u);
    TEST_ASSERT_EQUAL_UINT32(1, drive.loop.bad_inputs);
    emergency_stop();
    tick();
    TEST_ASSERT_EQUAL_UINT32(0, drive.limits);
}

// --- states --------------------------------------------------------------------------------------------------------

static void test_power_up_turns_everything_off_and_waits(void)
{
    check_off();
    for (unsigned i = 0; i < 50u; i++)
    {
        tick();
        check_off();
        TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
    }
}

static void test_stop_is_obeyed_in_the_next_tick_and_wins_over_start(void)
{
    start();
    drive_stop(&drive);
    tick();
    check_off();
    TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
    drive_start(&drive);
    drive_stop(&drive);
    tick();
    check_off();
    TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
}

static void test_a_start_of_a_running_drive_changes_nothing(void)
{
    start();
    run_until(30);
    loop_state_t   again = drive.loop;
    loop_signals_t signals;
    drive_start(&drive);
    tick();
    check_running();
    (void)TRIBO(force_loop, step)(&setup.params, &again, reference, board.y, &signals);
    TEST_ASSERT_EQUAL_MEMORY(&again, &drive.loop, sizeof again);
}

static void test_every_start_begins_with_the_loop_at_rest(void)
{
    start();
    const uint32_t first = tribo_force_word(board.command);
    run_until(50);
    drive_stop(&drive);
    tick();
    ticks = 0; // the sensor as in the first run
    start();
    TEST_ASSERT_EQUAL_HEX32(first, tribo_force_word(board.command));
}

static void test_the_loop_that_runs_is_the_librarys(void)
{
    loop_state_t   state = {.memory = NULL};
    loop_signals_t signals;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, TRIBO(force_loop, start)(&state, &setup.params, false));
    drive_start(&drive);
    for (unsigned i = 0; i < 100u; i++)
    {
        tick();
        const loop_force_t u = TRIBO(force_loop, step)(&setup.params, &state, reference, board.y, &signals);
        TEST_ASSERT_EQUAL_HEX32(tribo_force_word(u), tribo_force_word(board.command));
    }
}

static void test_a_failed_self_test_lasts_whatever_is_requested(void)
{
    const drive_fault_t found[] = {DRIVE_FAULT_IMAGE,
                                   DRIVE_FAULT_RAM,
                                   DRIVE_FAULT_GOLDEN,
                                   DRIVE_FAULT_PARAMS,
                                   DRIVE_FAULT_CLOCK};
    const drive_setup_t nothing = {.params = NULL}; // must not be read
    for (unsigned i = 0; i < sizeof found / sizeof found[0]; i++)
    {
        board_init(&board, 0);
        drive_init(&drive, &board.port, &nothing, found[i]);
        check_off();
        for (unsigned k = 0; k < 50u; k++)
        {
            drive_acknowledge(&drive);
            drive_start(&drive);
            board.enabled = true; // as if something else had turned it on
            board.command = board_force(1.0);
            tick();
            check_off();
            TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
            TEST_ASSERT_EQUAL_INT(found[i], drive.fault);
        }
    }
}

static void check_waits_after(drive_fault_t found, const char *line)
{
    power_up_with(found);
    check_off();
    for (unsigned k = 0; k < 20u; k++)
    {
        drive_start(&drive);
        tick();
        check_off();
        TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
        TEST_ASSERT_EQUAL_INT(found, drive.fault);
    }
    drive_log(&drive);
    TEST_ASSERT_EQUAL_STRING(line, board.log);
    emergency_stop();
    drive_acknowledge(&drive);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state); // another cause is active
    repair();
    drive_acknowledge(&drive);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
    check_off();
    start();
}

static void test_after_a_reset_that_nobody_asked_for_the_drive_waits_for_an_acknowledgement(void)
{
#define TAIL " since tick 0 at tick 20, longest tick 0 us, latest 0 us\n"
    check_waits_after(DRIVE_FAULT_WATCHDOG, "fault: reset by the watchdog" TAIL);
    check_waits_after(DRIVE_FAULT_EXCEPTION, "fault: reset after an exception" TAIL);
    check_waits_after(DRIVE_FAULT_CRYSTAL, "fault: reset after the crystal stopped" TAIL);
    check_waits_after(DRIVE_FAULT_BROWN_OUT, "fault: reset by a low supply" TAIL);
    check_waits_after(DRIVE_FAULT_RESTART, "fault: reset by software" TAIL);
}

// --- the reference -------------------------------------------------------------------------------------------------

/// A tick without a new reference.
static void tick_on(void)
{
    board_new_tick(&board);
    board.y = board_force(0.3 + 0.001 * (double)(ticks % 7u));
    drive_tick(&drive);
    ticks++;
    board.now_us += PERIOD_US;
}

static void check_reference_is_0(const char *when)
{
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(0, tribo_force_word(drive.reference), when);
    tick_on();
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(0, tribo_force_word(drive.r), when);
}

static void test_the_reference_returns_to_0_at_every_stop_fault_and_acknowledgement(void)
{
    start();
    drive_stop(&drive);
    tick();
    check_reference_is_0("a stop in RUN");
    tick();
    drive_stop(&drive);
    tick();
    check_reference_is_0("a stop in IDLE");
    for (unsigned i = 0; i < INJECTIONS; i++)
    {
        power_up();
        start();
        tick_with(&injections[i]);
        check_latched(&injections[i]);
        check_reference_is_0(injections[i].name);
        repair();
        tick(); // a reference that comes during the fault ...
        drive_acknowledge(&drive);
        tick(); // ... and with the acknowledgement
        TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
        check_reference_is_0("an acknowledgement");
    }
}

static void test_a_reference_lasts_until_the_next_if_it_need_not_be_renewed(void)
{
    config.reference_ms = 0;
    power_up();
    start();
    for (unsigned i = 0; i < 1000u; i++)
    {
        tick_on();
        check_running();
        TEST_ASSERT_EQUAL_HEX32(tribo_force_word(reference), tribo_force_word(drive.r));
    }
}

// --- scaling and tare ----------------------------------------------------------------------------------------------

static double newton(loop_force_t force)
{
    return tribo_force_q31(force, BOARD_FULL_SCALE_N) / 2147483648.0 * (double)BOARD_FULL_SCALE_N;
}

static void tick_reading(double units)
{
    board.y = board_force(units);
    tick_stuck();
}

static void test_readings_and_outputs_are_scaled_as_the_config_says(void)
{
    config.sensor_n_per_unit  = 0.5f;
    config.sensor_zero_units  = 0.25f;
    config.sensor_reversed    = 1;
    config.command_n_per_unit = 2.0f;
    config.command_zero_units = 0.125f;
    config.command_reversed   = 1;
    power_up();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.125, newton(board.command));
    tick_reading(0.75);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -0.25, newton(drive.y));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.125, newton(board.command));
    drive_start(&drive);
    tick_reading(0.75);
    const double u_n = newton(drive.signals.controller.TRIBO_N(u));
    TEST_ASSERT_TRUE(u_n > 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.125 - u_n / 2.0, newton(board.command));
    emergency_stop();
    tick_reading(0.75);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.125, newton(board.command));
    TEST_ASSERT_FALSE(board.enabled);
    board.moved_while_off = false; // 0.125 units are no current
}

/// The mean of the readings is 40 mN.
static void tick_until_tared(void)
{
    for (unsigned i = 0; i < DRIVE_TARE_TICKS; i++)
    {
        TEST_ASSERT_EQUAL_INT(i == 0u ? DRIVE_TARE_NONE : DRIVE_TARE_BUSY, drive.tare);
        tick_reading(i % 2u == 0u ? 0.05 : 0.03);
    }
}

static void test_a_tare_makes_the_mean_reading_0_n(void)
{
    config.tare_max_n = 0.1f;
    power_up();
    drive_tare(&drive);
    tick_until_tared();
    TEST_ASSERT_EQUAL_INT(DRIVE_TARE_DONE, drive.tare);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.04, (double)drive_sensor_zero_units(&drive));
    tick_reading(0.04);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, newton(drive.y));
    tick_reading(0.54);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, newton(drive.y));

    // It lasts over a start and another setup of the same sensor, and ends with a setup of another zero.
    static drive_setup_t other;
    drive_config_error_t error;
    drive_start(&drive);
    tick_reading(0.3);
    check_running();
    config.stuck_ticks = 300;
    TEST_ASSERT_TRUE(drive_setup_init(&other, &config, &setup.params, &board.port, &error));
    drive_change(&drive, &other);
    tick_reading(0.54);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, newton(drive.y));
    static drive_setup_t moved;
    config.sensor_zero_units = 0.01f;
    TEST_ASSERT_TRUE(drive_setup_init(&moved, &config, &setup.params, &board.port, &error));
    drive_change(&drive, &moved);
    tick_reading(0.51);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, newton(drive.y));
}

static void check_tare_refused(void)
{
    TEST_ASSERT_EQUAL_INT(DRIVE_TARE_REFUSED, drive.tare);
    TEST_ASSERT_TRUE(drive_sensor_zero_units(&drive) == 0.0f);
}

static void test_a_tare_is_refused_while_the_drive_runs_or_has_a_fault(void)
{
    config.tare_max_n = 0.1f;
    power_up();
    start();
    drive_tare(&drive);
    tick();
    check_running();
    check_tare_refused();
    emergency_stop();
    tick();
    drive.tare = DRIVE_TARE_NONE;
    drive_tare(&drive);
    tick();
    check_tare_refused();
    power_up_with(DRIVE_FAULT_PARAMS);
    drive_tare(&drive);
    tick();
    check_tare_refused();
}

static void test_a_start_or_a_fault_ends_a_tare(void)
{
    config.tare_max_n = 0.1f;
    power_up();
    drive_tare(&drive);
    run_until(100);
    TEST_ASSERT_EQUAL_INT(DRIVE_TARE_BUSY, drive.tare);
    start();
    check_tare_refused();
    power_up();
    drive_tare(&drive);
    run_until(100);
    emergency_stop();
    tick();
    check_tare_refused();
}

static void test_a_tare_beyond_its_bound_is_refused(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        config.tare_max_n = 0.0399f;
        power_up();
        drive_tare(&drive);
        for (unsigned i = 0; i < DRIVE_TARE_TICKS; i++)
        {
            tick_reading(sign * (i % 2u == 0u ? 0.05 : 0.03));
        }
        check_tare_refused();
    }
    config.tare_max_n = 0.0f; // off
    power_up();
    drive_tare(&drive);
    tick();
    check_tare_refused();
}

// --- another setup -------------------------------------------------------------------------------------------------

static void test_a_changed_setup_is_used_from_the_next_tick_on(void)
{
    static drive_setup_t other;
    drive_config_error_t error;
    config.stuck_ticks = 50;
    TEST_ASSERT_TRUE(drive_setup_init(&other, &config, &setup.params, &board.port, &error));
    start();
    for (unsigned i = 1; i < STUCK_TICKS; i++)
    {
        tick_stuck();
    }
    drive_change(&drive, &other);
    TEST_ASSERT_TRUE(drive_setup(&drive) == &drive_setup_used);
    for (unsigned i = STUCK_TICKS; i < 50u; i++)
    {
        tick_stuck();
        check_running();
        TEST_ASSERT_TRUE(drive_setup(&drive) == &other);
    }
    tick_stuck();
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT_SENSOR_STUCK, drive.fault);
}

static void test_a_changed_setup_goes_on_without_a_bump(void)
{
    static drive_setup_t          other;
    static loop_setup_t           other_loop;
    drive_config_error_t          error;
    tribo_force_loop_f32_config_t loop = tribo_force_loop_f32_paper();
    loop.gain                          = 0.4f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_setup(&other_loop, &loop, BOARD_FULL_SCALE_N));
    TEST_ASSERT_TRUE(drive_setup_init(&other, &config, &other_loop.params, &board.port, &error));
    start();
    run_until(30);
    const int64_t before = tribo_force_q31(board.command, BOARD_FULL_SCALE_N);
    tick();
    const int64_t without = tribo_force_q31(board.command, BOARD_FULL_SCALE_N) - before;
    drive_change(&drive, &other);
    const int64_t last = tribo_force_q31(board.command, BOARD_FULL_SCALE_N);
    tick();
    const int64_t with = tribo_force_q31(board.command, BOARD_FULL_SCALE_N) - last;
    check_running();
    TEST_ASSERT_TRUE(drive.loop.active == &other_loop.params);
    TEST_ASSERT_INT64_WITHIN(1 << 22, without, with); // 8 mN of 4 N
}

static void test_the_log_reports_each_change_once(void)
{
    drive_log(&drive);
    drive_log(&drive);
    start();
    drive_log(&drive);
    emergency_stop();
    tick();
    drive_log(&drive);
    drive_log(&drive);
    tick();
    drive_log(&drive);
    drive_report(&drive);
    TEST_ASSERT_EQUAL_STRING("idle at tick 0, longest tick 0 us, latest 0 us\n"
                             "run at tick 1, longest tick 20 us, latest 0 us\n"
                             "fault: emergency stop since tick 2 at tick 2, longest tick 20 us, latest 0 us\n"
                             "fault: emergency stop since tick 2 at tick 3, longest tick 20 us, latest 0 us\n",
                             board.log);
}

static void test_every_fault_has_a_text_of_its_own(void)
{
    for (int i = 0; i < DRIVE_FAULTS; i++)
    {
        TEST_ASSERT_NOT_NULL(drive_fault_text((drive_fault_t)i));
        for (int k = 0; k < i; k++)
        {
            TEST_ASSERT_TRUE(strcmp(drive_fault_text((drive_fault_t)i), drive_fault_text((drive_fault_t)k)) != 0);
        }
    }
    TEST_ASSERT_EQUAL_STRING("unknown", drive_fault_text(DRIVE_FAULTS));
}

/// A client may send hundreds of requests within a slow tick.
static void test_any_number_of_requests_between_two_ticks_is_seen(void)
{
    const unsigned counts[] = {1, 255, 256, 512, 65536};
    for (unsigned i = 0; i < sizeof counts / sizeof counts[0]; i++)
    {
        power_up();
        for (unsigned k = 0; k < counts[i]; k++)
        {
            drive_start(&drive);
        }
        tick();
        check_running();
        for (unsigned k = 0; k < counts[i]; k++)
        {
            drive_stop(&drive);
        }
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
        check_off();
    }
}

#include "runners/test_drive.inc" // main
