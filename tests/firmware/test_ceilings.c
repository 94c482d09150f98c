// What the STM32F405's ceilings leave of its detectors.

#include "port/stm32f405/convert.h"
#include "port/stm32f405/rig_config.h"

#include "ceilings.h"

#define CEILINGS rig_ceilings, sizeof rig_ceilings / sizeof rig_ceilings[0]

void setUp(void)
{
    board_init(&board, 0);
    board.port.sensor = (port_range_t)CONVERT_SENSOR_RANGE;
    board.port.output = (port_range_t)CONVERT_OUTPUT_RANGE;
    defaults          = params_default_of(&rig_config);
}

void tearDown(void)
{
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
