// Errors of the drive, around any truth model.

#include "plant/plant.h"
#include "rig.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

static rig_t rig;

void setUp(void)
{
    rig_init(&rig, &sim_coulomb_truth);
}

/// F after `seconds` at constant u, from rest.
static double settled(const sim_drive_error_t *error, double u_n, double seconds)
{
    const sim_plant_config_t config = {.step_s                  = RIG_STEP_S,
                                       .actuator_pole_rad_per_s = 200.0,
                                       .sensor_pole_rad_per_s   = 55.0,
                                       .truth                   = rig.config,
                                       .drive_error             = *error};
    sim_plant_t             *plant  = sim_plant_create(&config, rig.truth);
    TEST_ASSERT_NOT_NULL(plant);
    sim_plant_signals_t signals;
    for (long i = 0; i < lround(seconds / RIG_STEP_S); i++)
    {
        sim_plant_step(plant, u_n, &signals);
    }
    const double force = sim_plant_force(plant);
    sim_plant_destroy(plant);
    return force;
}

static void test_scale_and_bias_are_those_of_the_command(void)
{
    const sim_drive_error_t none  = {0};
    const sim_drive_error_t error = {.scale = 0.1, .bias_n = 0.02};
    TEST_ASSERT_TRUE(settled(&error, 0.4, 1.0) == settled(&none, 1.1 * 0.4 + 0.02, 1.0));
    TEST_ASSERT_TRUE(settled(&error, 0.4, 1.0) > settled(&none, 0.4, 1.0) + 0.03);
}

static void test_no_error_changes_nothing(void)
{
    // A period, but no amplitude.
    const sim_drive_error_t none = {.ripple_period_deg = 0.01, .ripple_phase = 0.3};
    TEST_ASSERT_TRUE(settled(&none, 0.4, 0.3) == settled(&(sim_drive_error_t){0}, 0.4, 0.3));
}

typedef struct
{
    double period_n, phase, amplitude_n, largest_n;
    double slowest, fastest; ///< of F against u
} wave_t;

/// u + ripple - F equals L while the arm slides up.
static void check_balance(void *context, const rig_sample_t *sample)
{
    wave_t *wave = context;
    if (sample->u_n < 0.1)
    {
        return;
    }
    const double ripple = wave->amplitude_n * sin(2.0 * acos(-1.0) * (sample->force_n / wave->period_n + wave->phase));
    const double net    = sample->u_n + ripple - sample->force_n;
    wave->largest_n     = fmax(wave->largest_n, fabs(net - 0.007 - 0.3 * sample->force_n));
    wave->slowest       = fmin(wave->slowest, sample->speed_deg_per_s * 3.84);
    wave->fastest       = fmax(wave->fastest, sample->speed_deg_per_s * 3.84);
}

static void test_ripple_is_a_force_periodic_in_position(void)
{
    // Slope 2 pi 0.01 / 0.1 N = 0.63 of the spring's: F ripples without jumps.
    wave_t wave     = {.period_n = 0.1, .phase = 0.25, .amplitude_n = 0.01, .slowest = 1.0};
    rig.drive_error = (sim_drive_error_t){.ripple_n = 0.01, .ripple_period_deg = 0.1 / 3.84, .ripple_phase = 0.25};
    const rig_ramp_t ramps[] = {{0.6, 12.0}};
    rig_run(&rig, RIG_STEP_S, ramps, 1, check_balance, &wave);
    printf("u + ripple - F - L: %.2e N; F' %.3f to %.3f N/s\n", wave.largest_n, wave.slowest, wave.fastest);
    TEST_ASSERT_TRUE(wave.largest_n < 2e-3); // damping: b F'/K is 7.5 ms F'
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * 0.05 / 1.93, 0.05 / 1.93, wave.slowest);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * 0.05 / 0.67, 0.05 / 0.67, wave.fastest);
}

/// Through the plant, whose actuator lags by 5 ms: 0.25 mN at 0.05 N/s.
static void test_the_plants_arm_feels_the_ripple(void)
{
    const sim_plant_config_t config = {.step_s                  = RIG_STEP_S,
                                       .actuator_pole_rad_per_s = 200.0,
                                       .sensor_pole_rad_per_s   = 55.0,
                                       .truth                   = rig.config,
                                       .drive_error             = {.ripple_n = 0.01, .ripple_period_deg = 0.1 / 3.84}};
    sim_plant_t             *plant  = sim_plant_create(&config, rig.truth);
    TEST_ASSERT_NOT_NULL(plant);
    sim_plant_signals_t signals;
    for (int i = 0; i < 100000; i++)
    {
        const double u = 0.05 * RIG_STEP_S * i;
        sim_plant_step(plant, u, &signals);
        const double force  = sim_plant_force(plant);
        const double ripple = 0.01 * sin(2.0 * acos(-1.0) * force / 0.1);
        if (u > 0.05)
        {
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.007 + 0.3 * force, u + ripple - force);
        }
    }
    sim_plant_destroy(plant);
}

/// Ripple as large as L at 0.5 N, but not so steep that the arm jumps between valleys: the smallest difference would then
/// decide where it stops.
static void test_every_model_agrees_with_cvode_under_ripple_and_command_errors(void)
{
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_init(&rig, sim_truth_models[i]);
        rig.drive_error                   = (sim_drive_error_t){.scale             = 0.05,
                                                                .bias_n            = 0.01,
                                                                .ripple_n          = 0.15,
                                                                .ripple_period_deg = 0.3,
                                                                .ripple_phase      = 0.1};
        const rig_comparison_t comparison = rig_compare(&rig, RIG_STEP_S, rig_compare_ramps, rig_compare_count, NULL);
        printf("%-16s %7.4f %% of %.3f N, at %6.3f s\n",
               rig.truth->name,
               100.0 * comparison.difference,
               comparison.largest_n,
               comparison.at_s);
        TEST_ASSERT_TRUE_MESSAGE(comparison.difference <= 0.01, rig.truth->name);
    }
}

#include "runners/test_drive_error.inc" // main
