// Of a board: no client that has the key makes its detectors blind. Each param that protects goes to each end that the board allows, alone
// and the residual's model with all of its params together; then a sensor that shows 0 N, one that shows the wrong sign and a lost
// contact must stop the drive, whether they were so from the start or break later. The arm is that of own_plant.h. A test includes its
// board's convert.h and rig_config.h first, and RIG_CONFIG is the config of its rig.

#ifndef TESTS_FIRMWARE_CEILINGS_H
#define TESTS_FIRMWARE_CEILINGS_H

#include "app/params.h"
#include "board.h"
#include "own_plant.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define HEALTHY_TICKS 1000u
#define WITHIN_TICKS  1000u
#define LEVEL_N       0.6
#define HARMLESS_N    0.15 // with a smaller input_max the loop coasts

typedef enum
{
    HEALTHY,
    DETACHED,
    REVERSED,
    CONTACT_LOST,
    BREAKS
} break_t;

static params_set_t  defaults;
static params_t      params;
static board_t       board;
static drive_t       drive;
static loop_memory_t memory;
static own_plant_t   plant;

static double number_of(uint32_t word)
{
    return word < (uint32_t)DRIVE_CONFIG_COUNT ? (double)drive_config_value(&defaults.drive, word)
                                               : (double)params_number(&defaults, word);
}

static void put(uint32_t word, double value)
{
    const float    number = (float)value;
    const uint32_t whole  = (uint32_t)fmin(fmax(value, 0.0), (double)UINT32_MAX); // a pole of 1e12 is a number
    memcpy(&params.words[word], params_is_number(word) ? (const void *)&number : (const void *)&whole, sizeof whole);
}

/// The force that the board's scaling makes of an output, at the board as it was built.
static double driven_n(void)
{
    const drive_config_t *config = &defaults.drive;
    const double          units  = (double)scaling_value(board.command, board.port.output.full_units);
    return (units - (double)config->command_zero_units) * (double)config->command_n_per_unit;
}

static void show(double force_n)
{
    const drive_config_t *config = &defaults.drive;
    const double units = floor(force_n / (double)config->sensor_n_per_unit + (double)config->sensor_zero_units + 0.5);
    board.y            = scaling_number((float)units, board.port.sensor.full_units);
}

static bool tick(break_t what)
{
    const double force_n = plant.filtered_n;
    const double noise_n = drive.ticks % 2u == 0u ? 1.3e-3 : -1.3e-3; // a unit
    board_new_tick(&board);
    show((what == DETACHED ? 0.0 : what == REVERSED ? -force_n : force_n) + noise_n);
    drive_reference(&drive, scaling_number((float)LEVEL_N, drive.setup->config.full_scale_n));
    drive_tick(&drive);
    own_plant_step(&plant, drive.state == DRIVE_RUN ? driven_n() : 0.0, 1e-3);
    board.now_us += 1000u;
    return drive.state != DRIVE_FAULT;
}

/// Whether the drive with `params` runs until the break, and then on with a force that matters.
static bool runs_on(break_t what, unsigned healthy_ticks)
{
    plant = own_plant(OWN_PLANT_LUGRE, 1.0);
    drive_init(&drive, &board.port, &params.drive, DRIVE_FAULT_NONE);
    loop_forget(&params.loop.params, &memory);
    drive_attach(&drive, &memory);
    drive_start(&drive);
    bool on = true;
    for (unsigned i = 0; on && i < healthy_ticks; i++)
    {
        on = tick(HEALTHY);
    }
    plant.stiffness = what == CONTACT_LOST ? 0.0 : plant.stiffness;
    double most_n   = 0.0;
    for (unsigned i = 0; on && i < WITHIN_TICKS; i++)
    {
        on     = tick(what);
        most_n = fmax(most_n, fabs(driven_n()));
    }
    return on && most_n > HARMLESS_N;
}

/// Whether the board takes `params`.
static bool is_taken(const params_ceiling_t *ceilings, uint32_t count)
{
    params_error_t error;
    return params_make(&params, &board.port, &error) && params_check_ceilings(&params.set, ceilings, count, &error) &&
           params_check_wiring(&params.set, &defaults, &error) && params_check_method(&params.set, &defaults, &error);
}

static unsigned taken;

/// Levels are wide as far as the board allows, so that of them only the order of seconds is asked for.
static void check_blindness(const char *name, const params_ceiling_t *ceilings, uint32_t count)
{
    if (!is_taken(ceilings, count))
    {
        return;
    }
    taken++;
    for (break_t what = DETACHED; what < BREAKS; what++)
    {
        TEST_ASSERT_FALSE_MESSAGE(runs_on(what, 0), name);
        TEST_ASSERT_FALSE_MESSAGE(runs_on(what, HEALTHY_TICKS), name);
    }
}

static const params_ceiling_t *ceiling_of(uint32_t word, const params_ceiling_t *ceilings, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
    {
        if (ceilings[i].word == word)
        {
            return &ceilings[i];
        }
    }
    return NULL;
}

/// Sets the other checks as wide as the board allows, which leaves the residual.
static void widen_others(const params_ceiling_t *ceilings, uint32_t count)
{
    static const uint16_t others[] = {DRIVE_CONFIG_tracking_n,
                                      DRIVE_CONFIG_tracking_ms,
                                      DRIVE_CONFIG_command_limit_ms,
                                      DRIVE_CONFIG_swing_ms};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
    {
        const params_ceiling_t *ceiling = ceiling_of(others[i], ceilings, count);
        TEST_ASSERT_NOT_NULL(ceiling);
        put(others[i], (double)ceiling->high);
    }
}

static bool is_of_residual(uint32_t word)
{
    return word == DRIVE_CONFIG_residual_n || word == DRIVE_CONFIG_residual_ms || word == DRIVE_CONFIG_residual_slope;
}

static void check_refused(uint32_t word, double value, const params_ceiling_t *ceilings, uint32_t count)
{
    params.set = defaults;
    put(word, value);
    TEST_ASSERT_FALSE(is_taken(ceilings, count));
}

/// Checks of their own, which no break shows.
static void check_others(const params_ceiling_t *ceilings, uint32_t count)
{
    check_refused(DRIVE_CONFIG_swing_ms, 0.0, ceilings, count);
    check_refused(DRIVE_CONFIG_swing_ms, 10000.0, ceilings, count);
    check_refused(DRIVE_CONFIG_command_n_per_a, 2.0 * number_of(DRIVE_CONFIG_command_n_per_a), ceilings, count);
}

static void check_ends_of_all(const params_ceiling_t *ceilings, uint32_t count)
{
    uint32_t place = 0;
    taken          = 0;
    for (uint32_t word = params_next_protecting(&place); word < PARAMS_WORDS; word = params_next_protecting(&place))
    {
        const params_ceiling_t *of     = ceiling_of(word, ceilings, count);
        const double            is     = number_of(word);
        const double            ends[] = {of != NULL ? (double)of->low : is,
                               of != NULL ? (double)of->high : is,
                               0.0,
                               1e-12,
                               1e-6,
                               1e-3,
                               1e6,
                               1e12,
                               -1e6,
                               0.25 * is,
                               0.5 * is,
                               2.0 * is,
                               4.0 * is,
                               16.0 * is,
                               -is,
                               is + 0.3,
                               is - 0.3,
                               1.0,
                               32.0,
                               1000.0,
                               10000.0,
                               600000.0};
        for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++)
        {
            char name[64];
            (void)snprintf(name, sizeof name, "word %u at %g", (unsigned)word, ends[i]);
            params.set = defaults;
            if (!is_of_residual(word))
            {
                widen_others(ceilings, count);
            }
            put(word, params_is_number(word) || ends[i] >= 0.0 ? ends[i] : 0.0);
            check_blindness(name, ceilings, count);
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT(100u, taken);
}

static void check_model(const params_ceiling_t *ceilings, uint32_t count)
{
    static const struct
    {
        uint16_t word;
        bool     high;
    } slow[]   = {{DRIVE_CONFIG_actuator_pole_rad_per_s, false},
                  {DRIVE_CONFIG_sensor_pole_rad_per_s, false},
                  {PARAMS_STIFFNESS, false},
                  {PARAMS_INERTIA, true},
                  {PARAMS_DAMPING, true},
                  {PARAMS_GRAVITY, false}};
    params.set = defaults;
    widen_others(ceilings, count);
    for (size_t i = 0; i < sizeof slow / sizeof slow[0]; i++)
    {
        const params_ceiling_t *ceiling = ceiling_of(slow[i].word, ceilings, count);
        TEST_ASSERT_NOT_NULL(ceiling);
        put(slow[i].word, (double)(slow[i].high ? ceiling->high : ceiling->low));
    }
    TEST_ASSERT_TRUE(is_taken(ceilings, count));
    check_blindness("the whole model", ceilings, count);
}

#define CEILINGS rig_ceilings, sizeof rig_ceilings / sizeof rig_ceilings[0]

void setUp(void)
{
    board_init(&board, 0);
    board.port.sensor           = (port_range_t)CONVERT_SENSOR_RANGE;
    board.port.output           = (port_range_t)CONVERT_OUTPUT_RANGE;
    const drive_config_t config = RIG_CONFIG;
    defaults                    = params_default_of(&config);
}

static void test_the_boards_own_params_run_and_stop(void)
{
    params.set = defaults;
    TEST_ASSERT_TRUE(is_taken(CEILINGS));
    TEST_ASSERT_TRUE(runs_on(HEALTHY, HEALTHY_TICKS));
    check_blindness("defaults", CEILINGS);
}

static void test_no_param_at_an_end_makes_the_drive_blind(void)
{
    check_ends_of_all(CEILINGS);
}

static void test_nor_do_all_of_the_residuals_model(void)
{
    check_model(CEILINGS);
}

static void test_checks_that_no_break_shows_stay_on(void)
{
    check_others(CEILINGS);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_boards_own_params_run_and_stop);
    RUN_TEST(test_no_param_at_an_end_makes_the_drive_blind);
    RUN_TEST(test_nor_do_all_of_the_residuals_model);
    RUN_TEST(test_checks_that_no_break_shows_stay_on);
    return UNITY_END();
}

#endif
