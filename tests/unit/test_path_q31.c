#include "tribo/path_q31.h"

#include "random.h"
#include "tribo/quantize_feedforward_q31.h"
#include "unity.h"

#include <math.h>

#define H    1.0e-3f
#define UNIT (4.0 / 2147483648.0) // N, of a full scale of 1 N

static tribo_path_f32_config_t config;
static tribo_path_q31_params_t params;
static tribo_path_q31_state_t  path;

void setUp(void)
{
    config = tribo_path_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_path_q31_init(&params, &config, H));
    tribo_path_q31_reset(&path);
}

void tearDown(void)
{
}

static void test_path_follows_its_twin(void)
{
    tribo_path_f32_params_t twin_params;
    tribo_path_f32_state_t  twin;
    random_t                r     = {7};
    double                  worst = 0.0;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_path_f32_init(&twin_params, &config, H));
    tribo_path_f32_reset(&twin);
    for (int k = 0; k < 20000; k++)
    {
        const double moved = k % 500 == 0 ? random_between(&r, -0.5, 0.5) : random_between(&r, -1e-4, 1e-4);
        const double ahead = random_between(&r, -1e-2, 1e-2);
        const double found =
            tribo_path_q31_step(&params, &path, (int32_t)lround(moved / UNIT), (int32_t)lround(ahead / UNIT));
        worst = fmax(worst,
                     fabs(found * UNIT - (double)tribo_path_f32_step(&twin_params, &twin, (float)moved, (float)ahead)));
    }
    TEST_ASSERT_DOUBLE_WITHIN(2e-7, 0.0, worst);
    TEST_ASSERT_EQUAL_UINT32(0, path.saturated);
}

static void test_path_mirrors_to_the_last_bit(void)
{
    tribo_path_q31_state_t mirror;
    random_t               r = {8};
    tribo_path_q31_reset(&mirror);
    for (int k = 0; k < 20000; k++)
    {
        const int32_t moved = (int32_t)random_between(&r, -1e7, 1e7);
        const int32_t ahead = (int32_t)random_between(&r, -1e7, 1e7);
        const int32_t found = tribo_path_q31_step(&params, &path, moved, ahead);
        TEST_ASSERT_EQUAL_INT32(-found, tribo_path_q31_step(&params, &mirror, -moved, -ahead));
    }
}

static void test_path_comes_back_from_saturation(void)
{
    for (int k = 0; k < 100; k++)
    {
        (void)tribo_path_q31_step(&params, &path, INT32_MIN, INT32_MAX);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(50, path.saturated);
    for (int k = 0; k < 2000; k++)
    {
        (void)tribo_path_q31_step(&params, &path, 0, 0);
    }
    TEST_ASSERT_INT32_WITHIN(40, 0, path.sensor); // less than 1/part for each low pass
}

static void test_path_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_path_q31_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_path_q31_init(&params, NULL, H));
    const tribo_path_q31_params_t before = params;
    config.actuator_pole_rad_per_s       = 9e-3f; // has too few bits
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_ACTUATOR_POLE, tribo_path_q31_init(&params, &config, H));
    config                       = tribo_path_f32_paper();
    config.sensor_pole_rad_per_s = 9e-3f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SENSOR_POLE, tribo_path_q31_init(&params, &config, H));
    config             = tribo_path_f32_paper();
    config.arm.inertia = 3.84e-8f; // an oscillation of 10 rad a tick: coefficients beyond 4
    config.arm.damping = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_ARM_TOO_FAST, tribo_path_q31_init(&params, &config, H));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_path_follows_its_twin);
    RUN_TEST(test_path_mirrors_to_the_last_bit);
    RUN_TEST(test_path_comes_back_from_saturation);
    RUN_TEST(test_path_init_names_the_field);
    return UNITY_END();
}
