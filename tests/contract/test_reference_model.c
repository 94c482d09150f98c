#include PARTS_HEADER
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <complex.h>
#include <math.h>

#define H 1e-3

static tribo_reference_model_f32_config_t config;
static reference_model_t                  model;

void setUp(void)
{
    config = tribo_reference_model_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, reference_model_init(&model, &config, H));
}

void tearDown(void)
{
}

/// Actuator, arm and sensor one after the other, in double and in forces instead of distances. The arm's zero-order-hold solution
/// is that of the roots of s^2 + b h/I s + K h^2/I, s in 1/tick.
typedef struct
{
    double part_a, part_s;
    double phi_d, phi_g, gamma_d, gamma_g;
    double actuator, F, G, sensor;
} exact_t;

static exact_t exact_start(void)
{
    const double         stiffness = (double)config.arm.stiffness / (double)config.arm.inertia * H * H;
    const double         damping   = (double)config.arm.damping / (double)config.arm.inertia * H;
    const double complex root      = csqrt(damping * damping / 4.0 - stiffness);
    const double complex s1        = -damping / 2.0 + root;
    const double complex s2        = -damping / 2.0 - root;
    const double complex e1        = cexp(s1);
    const double complex e2        = cexp(s2);
    const double         phi_g     = creal((e1 - e2) / (s1 - s2));
    return (exact_t){.part_a  = -expm1(-(double)config.actuator_pole_rad_per_s * H),
                     .part_s  = -expm1(-(double)config.sensor_pole_rad_per_s * H),
                     .phi_d   = 1.0 - creal((s1 * e2 - s2 * e1) / (s1 - s2)),
                     .phi_g   = phi_g,
                     .gamma_d = stiffness * phi_g,
                     .gamma_g = creal((s1 * e1 - s2 * e2) / (s1 - s2))};
}

static void exact_step(exact_t *x, double input)
{
    x->actuator += x->part_a * (input - x->actuator);
    const double d = x->actuator - x->F;
    const double G = x->G;
    x->F += x->phi_d * d + x->phi_g * G;
    x->G = x->gamma_d * d + x->gamma_g * G;
    x->sensor += x->part_s * (x->F - x->sensor);
}

static void test_reference_model_is_actuator_arm_and_sensor_in_a_row(void)
{
    random_t r     = {7};
    exact_t  exact = exact_start();
    double   at    = 0.0;
    double   worst = 0.0;
    for (int k = 0; k < RUNS(20000, 2000); k++)
    {
        const double moved =
            (double)(float)(k % 500 == 0 ? random_between(&r, -0.5, 0.5) : random_between(&r, -1e-4, 1e-4));
        const double ahead = (double)(float)random_between(&r, -1e-2, 1e-2);
        at += moved;
        exact_step(&exact, at + ahead);
        worst = fmax(worst, fabs(exact.sensor - at - reference_model_step(&model, moved, ahead)));
    }
    TEST_ASSERT_DOUBLE_WITHIN(REFERENCE_MODEL_TOLERANCE, 0.0, worst);
}

static void test_reference_model_without_its_lag_follows_a_ramp_with_the_sensors_alone(void)
{
    const double rate = 0.04;
    double       y    = 0.0;
    for (int k = 0; k < 2000; k++)
    {
        y = reference_model_step(&model, rate * H, rate * (1.0 / 200.0 + 0.0288 / 3.84));
    }
    // The reference is of the tick's begin and y of its end, less half a tick for the input that is held.
    TEST_ASSERT_DOUBLE_WITHIN(0.05e-3 * rate, -rate * (1.0 / 55.0 - 1.5e-3), y);
}

static void test_reference_model_rests_where_the_reference_stands(void)
{
    double y = reference_model_step(&model, 0.3, 0.0);
    for (int k = 0; k < 2000; k++)
    {
        y = reference_model_step(&model, 0.0, 0.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(REFERENCE_MODEL_REST, 0.0, y);
}

static void test_reference_model_mirrors_to_the_last_bit(void)
{
    static reference_model_t mirror;
    random_t                 r = {8};
    mirror                     = model;
    for (int k = 0; k < 20000; k++)
    {
        const double moved = random_between(&r, -0.04, 0.04);
        const double ahead = random_between(&r, -0.04, 0.04);
        const double y     = reference_model_step(&model, moved, ahead);
        TEST_ASSERT_TRUE(reference_model_step(&mirror, -moved, -ahead) == -y);
    }
}

static void test_reference_model_after_a_reset_is_at_rest(void)
{
    (void)reference_model_step(&model, 0.3, 0.1);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, reference_model_init(&model, &config, H));
    TEST_ASSERT_TRUE(reference_model_step(&model, 0.0, 0.0) == 0.0);
}

static void check_refused(tribo_status_t status, double h)
{
    const reference_model_t before = model;
    TEST_ASSERT_EQUAL_INT(status, reference_model_init(&model, &config, h));
    TEST_ASSERT_EQUAL_MEMORY(&before.params, &model.params, sizeof before.params);
    config = tribo_reference_model_f32_paper();
}

static void test_reference_model_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, reference_model_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, reference_model_init(&model, NULL, H));
    check_refused(TRIBO_ERR_SAMPLE_TIME, 0.2);
    config.actuator_pole_rad_per_s = NAN;
    check_refused(TRIBO_ERR_ACTUATOR_POLE, H);
    config.sensor_pole_rad_per_s = 0.0f;
    check_refused(TRIBO_ERR_SENSOR_POLE, H);
    config.arm.inertia = 0.0f;
    check_refused(TRIBO_ERR_INERTIA, H);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reference_model_is_actuator_arm_and_sensor_in_a_row);
    RUN_TEST(test_reference_model_without_its_lag_follows_a_ramp_with_the_sensors_alone);
    RUN_TEST(test_reference_model_rests_where_the_reference_stands);
    RUN_TEST(test_reference_model_mirrors_to_the_last_bit);
    RUN_TEST(test_reference_model_after_a_reset_is_at_rest);
    RUN_TEST(test_reference_model_init_names_the_field);
    return UNITY_END();
}
