#include "tribo/friction_meter_q31.h"

#include "random.h"
#include "tribo/quantize_feedforward_q31.h"
#include "unity.h"

#include <math.h>

#define H    1.0e-3f
#define UNIT (4.0 / 2147483648.0) // N, of a full scale of 1 N

static tribo_path_f32_config_t            path;
static tribo_friction_meter_q31_params_t  params;
static tribo_friction_meter_q31_state_t   meter;
static tribo_friction_meter_q31_signals_t seen;

void setUp(void)
{
    path = tribo_path_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_meter_q31_init(&params, &path, 0.02f, H));
    tribo_friction_meter_q31_reset(&meter, 0);
}

void tearDown(void)
{
}

static void test_meter_follows_its_twin_and_mirrors(void)
{
    tribo_friction_meter_f32_params_t  twin_params;
    tribo_friction_meter_f32_state_t   twin;
    tribo_friction_meter_f32_signals_t twin_seen;
    tribo_friction_meter_q31_state_t   mirror;
    tribo_friction_meter_q31_signals_t mirror_seen;
    random_t                           r     = {9};
    double                             u     = 0.0;
    double                             y     = 0.0;
    double                             worst = 0.0;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_meter_f32_init(&twin_params, &path, 0.02f, H));
    tribo_friction_meter_f32_reset(&twin, 0.0f);
    tribo_friction_meter_q31_reset(&mirror, 0);
    for (int k = 0; k < 20000; k++)
    {
        u                = fmin(0.5, fmax(-0.5, u + random_between(&r, -1e-2, 1e-2)));
        y                = fmin(0.5, fmax(-0.5, y + random_between(&r, -1e-3, 1e-3)));
        const int32_t uq = (int32_t)lround(u / UNIT);
        const int32_t yq = (int32_t)lround(y / UNIT);
        tribo_friction_meter_q31_step(&params, &meter, uq, yq, &seen);
        tribo_friction_meter_q31_step(&params, &mirror, -uq, -yq, &mirror_seen);
        tribo_friction_meter_f32_step(&twin_params, &twin, (float)u, (float)y, &twin_seen);
        TEST_ASSERT_EQUAL_INT32(-seen.friction, mirror_seen.friction);
        TEST_ASSERT_EQUAL_INT32(-seen.force, mirror_seen.force);
        TEST_ASSERT_EQUAL_INT32(-seen.change, mirror_seen.change);
        worst = fmax(worst, fabs(seen.friction * UNIT - (double)twin_seen.friction_n));
        worst = fmax(worst, fabs(seen.force * UNIT - (double)twin_seen.force_n));
    }
    TEST_ASSERT_DOUBLE_WITHIN(4e-7, 0.0, worst);
}

static void test_meter_takes_what_is_beyond_for_the_nearest_that_is_not(void)
{
    tribo_friction_meter_q31_state_t   end = meter;
    tribo_friction_meter_q31_signals_t end_seen;
    for (int k = 0; k < 100; k++)
    {
        tribo_friction_meter_q31_step(&params, &meter, INT32_MIN, INT32_MAX, &seen);
        tribo_friction_meter_q31_step(&params, &end, -(INT32_C(1) << 29), INT32_C(1) << 29, &end_seen);
        TEST_ASSERT_EQUAL_INT32(end_seen.friction, seen.friction);
    }
    tribo_friction_meter_q31_reset(&meter, INT32_MIN);
    TEST_ASSERT_EQUAL_INT32(-(INT32_C(1) << 29), meter.force);
}

static void test_a_change_beyond_counts_up_to_what_fits(void)
{
    tribo_friction_meter_q31_reset(&meter, -(INT32_C(1) << 29));
    tribo_friction_meter_q31_step(&params, &meter, 0, INT32_C(1) << 29, &seen);
    const double damping = 0.0288 / 3.84 / 1e-3;
    TEST_ASSERT_DOUBLE_WITHIN(100.0, meter.difference - damping * seen.change, seen.friction); // 0.4 N of 1 fits
    path.arm.damping *= 100.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_meter_q31_init(&params, &path, 0.02f, H));
    tribo_friction_meter_q31_reset(&meter, -(INT32_C(1) << 29));
    tribo_friction_meter_q31_step(&params, &meter, 0, INT32_C(1) << 29, &seen);
    TEST_ASSERT_TRUE(seen.change > params.change_max);
    TEST_ASSERT_DOUBLE_WITHIN(1e3, meter.difference - 100.0 * damping * params.change_max, seen.friction);
}

static void test_meter_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_friction_meter_q31_init(NULL, &path, 0.02f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_friction_meter_q31_init(&params, NULL, 0.02f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SLIDE_FILTER, tribo_friction_meter_q31_init(&params, &path, 0.02f * 1e3f, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SLIDE_FILTER, tribo_friction_meter_q31_init(&params, &path, 10.0f, 1e-5f));
    path.arm.stiffness = 3.84e-3f;
    path.arm.damping   = 0.13f;
    path.arm.inertia   = 1.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_DAMPING, tribo_friction_meter_q31_init(&params, &path, 0.02f, H));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_meter_follows_its_twin_and_mirrors);
    RUN_TEST(test_meter_takes_what_is_beyond_for_the_nearest_that_is_not);
    RUN_TEST(test_a_change_beyond_counts_up_to_what_fits);
    RUN_TEST(test_meter_init_names_the_field);
    return UNITY_END();
}
