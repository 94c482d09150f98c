#include "tribo/path_f32.h"

#include "random.h"
#include "runs.h"
#include "same.h"
#include "unity.h"

#include <math.h>

#define H 1.0e-3f

static tribo_path_f32_config_t config;
static tribo_path_f32_params_t params;
static tribo_path_f32_state_t  path;

void setUp(void)
{
    config = tribo_path_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_path_f32_init(&params, &config, H));
    tribo_path_f32_reset(&path);
}

void tearDown(void)
{
}

static void test_path_parts_are_exact(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(3e-8, 1.0 - exp(-0.2), (double)params.actuator_part);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 1.0 - exp(-0.055), (double)params.sensor_part);
    const float pole[] = {1.0e-3f, 1.0f, 30.0f, 300.0f, 3.0e3f, 4.9e4f};
    for (int i = 0; i < 6; i++)
    {
        config.actuator_pole_rad_per_s = pole[i];
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_path_f32_init(&params, &config, H));
        const double exact = -expm1(-(double)pole[i] * (double)H);
        TEST_ASSERT_DOUBLE_WITHIN(3e-7 * exact, exact, (double)params.actuator_part);
    }
}

/// The three parts one after the other, in double and in forces instead of distances: actuator, arm in 1,000 steps a tick,
/// sensor.
typedef struct
{
    double actuator, F, speed, sensor;
} exact_t;

static void exact_step(exact_t *e, double asked)
{
    e->actuator += -expm1(-0.2) * (asked - e->actuator);
    for (int i = 0; i < 1000; i++)
    {
        const double dt = 1e-6;
        e->speed += dt / 1.2e-4 * (3.84 * (e->actuator - e->F) - 0.0288 * e->speed);
        e->F += dt * e->speed;
    }
    e->sensor += -expm1(-0.055) * (e->F - e->sensor);
}

static void test_path_follows_a_reference_as_actuator_arm_and_sensor_do(void)
{
    random_t r     = {7};
    exact_t  exact = {0.0, 0.0, 0.0, 0.0};
    double   at    = 0.0;
    for (int k = 0; k < RUNS(3000, 600); k++)
    {
        const float moved = (float)(k % 500 == 0 ? random_between(&r, -0.5, 0.5) : random_between(&r, -1e-4, 1e-4));
        const float ahead = (float)random_between(&r, -1e-2, 1e-2);
        at += (double)moved;
        exact_step(&exact, at + (double)ahead);
        const double y = at + (double)tribo_path_f32_step(&params, &path, moved, ahead);
        TEST_ASSERT_DOUBLE_WITHIN(3e-5, exact.sensor, y); // the steps of the exact one
    }
}

static void test_path_without_its_lag_follows_a_ramp_with_the_sensors_alone(void)
{
    const double rate = 0.04;
    for (int k = 0; k < 2000; k++)
    {
        (void)tribo_path_f32_step(&params, &path, (float)(rate * 1e-3), (float)(rate * (1.0 / 200.0 + 0.0288 / 3.84)));
    }
    // The reference is of the tick's begin and y of its end, less half a tick for the input that is held.
    TEST_ASSERT_DOUBLE_WITHIN(0.05e-3 * rate, -rate * (1.0 / 55.0 - 1.5e-3), (double)path.sensor_n);
}

static void test_path_rests_where_the_reference_stands(void)
{
    (void)tribo_path_f32_step(&params, &path, 0.3f, 0.0f);
    for (int k = 0; k < 2000; k++)
    {
        (void)tribo_path_f32_step(&params, &path, 0.0f, 0.0f);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-20, 0.0, (double)path.sensor_n);
}

static void test_path_takes_a_bad_input_for_0(void)
{
    const float bad[] = {NAN, INFINITY, -2.1e6f};
    for (int i = 0; i < 3; i++)
    {
        TEST_ASSERT_SAME_FLOAT(0.0f, tribo_path_f32_step(&params, &path, bad[i], 0.0f));
        TEST_ASSERT_SAME_FLOAT(0.0f, tribo_path_f32_step(&params, &path, 0.0f, bad[i]));
    }
}

static void test_path_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_path_f32_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_path_f32_init(&params, NULL, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, tribo_path_f32_init(&params, &config, 0.2f));
    const tribo_path_f32_params_t before = params;
    config.actuator_pole_rad_per_s       = NAN;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_ACTUATOR_POLE, tribo_path_f32_init(&params, &config, H));
    config                       = tribo_path_f32_paper();
    config.sensor_pole_rad_per_s = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SENSOR_POLE, tribo_path_f32_init(&params, &config, H));
    config             = tribo_path_f32_paper();
    config.arm.inertia = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_INERTIA, tribo_path_f32_init(&params, &config, H));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_path_parts_are_exact);
    RUN_TEST(test_path_follows_a_reference_as_actuator_arm_and_sensor_do);
    RUN_TEST(test_path_without_its_lag_follows_a_ramp_with_the_sensors_alone);
    RUN_TEST(test_path_rests_where_the_reference_stands);
    RUN_TEST(test_path_takes_a_bad_input_for_0);
    RUN_TEST(test_path_init_names_the_field);
    return UNITY_END();
}
