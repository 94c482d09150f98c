// What the board measures of its power stage: current, supply and temperature beyond their levels for longer than they may be.

#include "app/drive.h"
#include "app/loop.h"
#include "board.h"
#include "unity.h"

#define PERIOD_US 1000u

static board_t        board;
static drive_t        drive;
static drive_config_t config;
static drive_setup_t  setup;
static loop_setup_t   loop;

static void power_up(void)
{
    drive_config_error_t error;
    board_init(&board, 0);
    TEST_ASSERT_TRUE(drive_setup_init(&setup, &config, &loop.params, &board.port, &error));
    drive_init(&drive, &board.port, &setup, DRIVE_FAULT_NONE);
}

void setUp(void)
{
    const tribo_force_loop_f32_config_t paper = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_setup(&loop, &paper, BOARD_FULL_SCALE_N));
    config                   = drive_config_default();
    config.over_current_a    = 3.0f;
    config.over_current_ms   = 5;
    config.bus_low_v         = 18.0f;
    config.bus_high_v        = 30.0f;
    config.bus_voltage_ms    = 10;
    config.temperature_max_c = 80.0f;
    config.temperature_ms    = 100;
    power_up();
}

static void tick(void)
{
    board_new_tick(&board);
    drive_tick(&drive);
    board.now_us += PERIOD_US;
}

static void run(unsigned count)
{
    for (unsigned i = 0; i < count; i++)
    {
        tick();
    }
}

static void start(void)
{
    drive_start(&drive);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

static const port_measured_t healthy = {.current_ma = 100, .bus_mv = 24000, .temperature_mc = 25000};

/// `measured` is a fault after `allowed` ticks, in RUN and at rest, and until it is over.
static void check(port_measured_t measured, unsigned allowed, drive_fault_t fault)
{
    for (int running = 0; running < 2; running++)
    {
        power_up();
        board.measured = healthy;
        if (running)
        {
            start();
        }
        run(20);
        const drive_state_t before = drive.state;
        board.measured             = measured;
        run(allowed);
        TEST_ASSERT_EQUAL_INT(before, drive.state);
        board.measured = healthy; // a tick of health does not begin anew
        tick();
        TEST_ASSERT_EQUAL_INT(before, drive.state);
        board.measured = measured;
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
        TEST_ASSERT_EQUAL_INT(fault, drive.fault);
        TEST_ASSERT_FALSE(board.enabled);
        TEST_ASSERT_EQUAL_HEX32(0, tribo_force_word(board.command));
        drive_acknowledge(&drive);
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
        board.measured = healthy;
        drive_acknowledge(&drive);
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_IDLE, drive.state);
    }
}

/// `measured` is no fault.
static void check_allowed(port_measured_t measured)
{
    power_up();
    board.measured = measured;
    start();
    run(1000);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

static void test_too_much_current_of_either_sign_stops(void)
{
    check((port_measured_t){3001, 24000, 25000, 0}, 5, DRIVE_FAULT_OVER_CURRENT);
    check((port_measured_t){-3001, 24000, 25000, 0}, 5, DRIVE_FAULT_OVER_CURRENT);
    check_allowed((port_measured_t){3000, 24000, 25000, 0});
    check_allowed((port_measured_t){-3000, 24000, 25000, 0});
}

static void test_a_supply_outside_its_range_stops(void)
{
    check((port_measured_t){0, 17999, 25000, 0}, 10, DRIVE_FAULT_BUS_VOLTAGE);
    check((port_measured_t){0, 30001, 25000, 0}, 10, DRIVE_FAULT_BUS_VOLTAGE);
    check_allowed((port_measured_t){0, 18000, 25000, 0});
    check_allowed((port_measured_t){0, 30000, 25000, 0});
}

/// The ports report INT32_MAX for what they cannot measure. That is beyond each bound, also if it is the only one.
static void test_what_cannot_be_measured_stops(void)
{
    const drive_config_t all = config;
    check((port_measured_t){INT32_MAX, 24000, 25000, 0}, 5, DRIVE_FAULT_OVER_CURRENT);
    check((port_measured_t){0, INT32_MAX, 25000, 0}, 10, DRIVE_FAULT_BUS_VOLTAGE);
    check((port_measured_t){0, 24000, INT32_MAX, 0}, 100, DRIVE_FAULT_TEMPERATURE);
    config.bus_high_v = 0.0f;
    check((port_measured_t){0, INT32_MAX, 25000, 0}, 10, DRIVE_FAULT_BUS_VOLTAGE);
    config           = all;
    config.bus_low_v = 0.0f;
    check((port_measured_t){0, INT32_MAX, 25000, 0}, 10, DRIVE_FAULT_BUS_VOLTAGE);
    config.bus_high_v = 0.0f;
    check_allowed((port_measured_t){0, INT32_MAX, 25000, 0});
}

static void test_too_high_a_temperature_stops(void)
{
    check((port_measured_t){0, 24000, 80001, 0}, 100, DRIVE_FAULT_TEMPERATURE);
    check_allowed((port_measured_t){0, 24000, 80000, 0});
    check_allowed((port_measured_t){0, 24000, -20000, 0});
}

/// A value beyond its level in `bad` of `of` ticks. Returns whether that stops the drive within 2 s.
static bool stops(port_measured_t measured, unsigned bad, unsigned of)
{
    power_up();
    start();
    for (unsigned i = 0; i < 2000u && drive.state == DRIVE_RUN; i++)
    {
        board.measured = i % of < bad ? measured : healthy;
        tick();
    }
    return drive.state == DRIVE_FAULT;
}

static void test_what_comes_and_goes_stops_from_one_in_three_ticks_on(void)
{
    static const port_measured_t measured[] = {{3001, 24000, 25000, 0},
                                               {-9000, 24000, 25000, 0},
                                               {0, 17999, 25000, 0},
                                               {0, 30001, 25000, 0},
                                               {0, 24000, 80001, 0}};
    for (unsigned i = 0; i < sizeof measured / sizeof measured[0]; i++)
    {
        TEST_ASSERT_TRUE(stops(measured[i], 1, 2));
        TEST_ASSERT_TRUE(stops(measured[i], 4, 10));
        TEST_ASSERT_TRUE(stops(measured[i], 4, 5));
        TEST_ASSERT_FALSE(stops(measured[i], 1, 3));
        TEST_ASSERT_FALSE(stops(measured[i], 1, 10));
    }
}

static void test_a_level_of_0_is_off(void)
{
    config.over_current_a = config.bus_low_v = config.bus_high_v = config.temperature_max_c = 0.0f;
    check_allowed((port_measured_t){INT32_MAX, INT32_MIN, INT32_MAX, 0});
    check_allowed((port_measured_t){INT32_MIN, INT32_MAX, INT32_MAX, 0});
}

static void test_a_level_of_a_quantity_the_board_does_not_measure_is_refused(void)
{
    static const struct
    {
        uint32_t measures;
        unsigned field;
        float    value;
    } cases[] = {{PORT_MEASURES_BUS | PORT_MEASURES_TEMPERATURE, DRIVE_CONFIG_over_current_a, 3.0f},
                 {PORT_MEASURES_CURRENT | PORT_MEASURES_TEMPERATURE, DRIVE_CONFIG_bus_low_v, 18.0f},
                 {PORT_MEASURES_CURRENT | PORT_MEASURES_BUS, DRIVE_CONFIG_temperature_max_c, 80.0f}};
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++)
    {
        drive_config_error_t error;
        board.port.measures = cases[i].measures;
        TEST_ASSERT_FALSE(drive_setup_init(&setup, &config, &loop.params, &board.port, &error));
        TEST_ASSERT_EQUAL_UINT(cases[i].field, error.field);
        TEST_ASSERT_EQUAL_FLOAT(cases[i].value, error.value);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, error.high);
    }
    config.bus_low_v = config.temperature_max_c = config.over_current_a = 0.0f;
    drive_config_error_t error;
    board.port.measures = PORT_MEASURES_CURRENT;
    TEST_ASSERT_FALSE(drive_setup_init(&setup, &config, &loop.params, &board.port, &error));
    TEST_ASSERT_EQUAL_UINT(DRIVE_CONFIG_bus_high_v, error.field);
}

static void test_a_board_without_measurements_is_not_queried(void)
{
    config = drive_config_default();
    power_up();
    board.port.measures = 0;
    board.port.measure  = NULL;
    start();
    run(10);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

#include "runners/test_measured.inc" // main
