// An axis whose configured breakaway is far from the truth's says so on each truth model of host_sim, and is silent where it is right within 2.

#include "plant/plant.h"
#include "scenario/config.h"
#include ARITH_HEADER

#include "tribo/axis_q31.h"
#include "unity.h"

// Q31, which has the same text, plays some of those that f32 leaves to tools/check --all.
#ifdef TRIBO_EVERY_TRUTH
#define FIRST  0
#define STRIDE TRIBO_EITHER(1, 3)
#else
#define FIRST  TRIBO_EITHER(0, 1)
#define STRIDE TRIBO_EITHER(2, 6)
#endif

/// breakaway_factor after `seconds` of the benchmark's triangle, with the breakaway of the benchmark's rig times `belief`.
static float factor_of(sim_truth_number_t truth, float belief, long seconds)
{
    static TRIBO(axis, t) axis;
    common_scenario_t *const  scenario = sim_scenario_create();
    const sim_config_t *const defaults = sim_scenario_config(scenario);
    const sim_plant_config_t  config   = {
           .step_s                  = 1e-4,
           .actuator_pole_rad_per_s = defaults->plant.actuator_pole_rad_per_s,
           .sensor_pole_rad_per_s   = defaults->sensor.pole_rad_per_s,
           .truth = {.friction = defaults->plant.friction, .arm = defaults->plant.arm, .own = defaults->plant.own[truth]}};
    sim_plant_t *const      plant           = sim_plant_create(&config, sim_truth_models[truth]);
    tribo_axis_f32_config_t own             = tribo_axis_f32_config();
    own.sample_time_s                       = 1e-3f;
    own.u_min_n                             = -2.0f;
    own.u_max_n                             = 2.0f;
    own.positive                            = (tribo_breakaway_f32_t){0.007f * belief, 0.3f * belief};
    own.arm_lag_s                           = 0.0075f;
    own.controller                          = tribo_paper();
    own.feedforward.actuator_pole_rad_per_s = 200.0f;
    own.feedforward.sensor_pole_rad_per_s   = 55.0f;
    TEST_ASSERT_EQUAL(
        TRIBO_OK,
        TRIBO_EITHER(TRIBO(axis, init)(&axis, &own), TRIBO(axis, init)(&axis, &own, (float)FULL_SCALE_N)));
    for (long tick = 0; tick < 1000 * seconds; tick++)
    {
        const double phase = (double)(tick % 20000) / 10000.0;
        const double r     = 0.4 + 0.2 * (phase < 1.0 ? phase : 2.0 - phase);
        const double u = from_force(TRIBO(axis, step)(&axis, to_force(r), to_force(sim_plant_filtered_force(plant))));
#if TRIBO_IS_Q31
        (void)tribo_axis_q31_learn(&axis);
#endif
        sim_plant_signals_t unused;
        for (int i = 0; i < 10; i++)
        {
            sim_plant_step(plant, u, &unused);
        }
    }
    tribo_axis_report_t report;
    TRIBO(axis, report)(&axis, &report);
    sim_plant_destroy(plant);
    common_scenario_destroy(scenario);
    return report.breakaway_factor;
}

/// The believed breakaway over the truth's is known within so many seconds, with the factor that is to be configured.
static void check_belief(float belief, long seconds, float factor)
{
    for (int truth = FIRST; truth < SIM_TRUTH_COUNT; truth += STRIDE)
    {
        TEST_ASSERT_EQUAL_FLOAT_MESSAGE(factor,
                                        factor_of((sim_truth_number_t)truth, belief, seconds),
                                        sim_truth_models[truth]->name);
    }
}

static void test_far_too_small_is_known_at_the_first_reversals(void)
{
    check_belief(0.03f, 25, 3.0f);
    check_belief(0.05f, 25, 3.0f);
    check_belief(0.1f, 25, 3.0f);
}

static void test_five_and_ten_times_too_large_are_known_after_some_reversals(void)
{
    check_belief(5.0f, 85, 0.2f);
    check_belief(10.0f, 85, 0.2f);
}

static void test_right_within_a_factor_of_two_is_no_warning(void)
{
    check_belief(0.5f, 60, 1.0f);
    check_belief(2.0f, 60, 1.0f);
}

#include "runners/test_axis_breakaway.inc" // main
