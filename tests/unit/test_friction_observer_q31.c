// What only the Q31 arithmetic has. What both promise: tests/contract/test_friction_observer.c.

#include "feedforward/friction_observer_q31.h"
#include "feedforward/reference_model_f32.h"

#include "unity.h"

#define H         1.0e-3f
#define FORCE_MAX (INT32_C(1) << 29)

static tribo_reference_model_f32_config_t    model;
static tribo_friction_observer_q31_params_t  params;
static tribo_friction_observer_q31_state_t   observer;
static tribo_friction_observer_q31_signals_t seen;

void setUp(void)
{
    model = tribo_reference_model_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_observer_q31_init(&params, &model, 0.02f, H));
    tribo_friction_observer_q31_reset(&observer, 0);
}

void tearDown(void)
{
}

static void test_observer_starts_within_its_range(void)
{
    tribo_friction_observer_q31_reset(&observer, INT32_MIN);
    TEST_ASSERT_EQUAL_INT32(-FORCE_MAX, observer.force);
    tribo_friction_observer_q31_reset(&observer, INT32_MAX);
    TEST_ASSERT_EQUAL_INT32(FORCE_MAX, observer.force);
}

static void test_observer_of_the_largest_forces_stays_in_its_range(void)
{
    for (int k = 0; k < 1000; k++)
    {
        const int32_t end = k / 300 % 2 == 0 ? FORCE_MAX : -FORCE_MAX;
        friction_observer_q31_step(&params, &observer, -end, end, &seen);
        TEST_ASSERT_INT32_WITHIN(FORCE_MAX, 0, seen.force);
        TEST_ASSERT_INT32_WITHIN(2 * FORCE_MAX, 0, observer.difference);
    }
}

static void test_a_change_beyond_counts_up_to_what_fits(void)
{
    tribo_friction_observer_q31_reset(&observer, -FORCE_MAX);
    friction_observer_q31_step(&params, &observer, 0, FORCE_MAX, &seen);
    const double damping = 0.0288 / 3.84 / 1e-3;
    TEST_ASSERT_DOUBLE_WITHIN(100.0, observer.difference - damping * seen.change, seen.friction); // 0.4 N of 1 fits
    model.arm.damping *= 100.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_observer_q31_init(&params, &model, 0.02f, H));
    tribo_friction_observer_q31_reset(&observer, -FORCE_MAX);
    friction_observer_q31_step(&params, &observer, 0, FORCE_MAX, &seen);
    TEST_ASSERT_TRUE(seen.change > params.change_max);
    TEST_ASSERT_DOUBLE_WITHIN(1e3, observer.difference - 100.0 * damping * params.change_max, seen.friction);
}

static void test_observer_init_refuses_what_it_cannot_hold(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SLIDE_FILTER, tribo_friction_observer_q31_init(&params, &model, 10.0f, 1e-5f));
    model.arm.stiffness = 3.84e-3f;
    model.arm.damping   = 0.13f;
    model.arm.inertia   = 1.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_DAMPING, tribo_friction_observer_q31_init(&params, &model, 0.02f, H));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_observer_starts_within_its_range);
    RUN_TEST(test_observer_of_the_largest_forces_stays_in_its_range);
    RUN_TEST(test_a_change_beyond_counts_up_to_what_fits);
    RUN_TEST(test_observer_init_refuses_what_it_cannot_hold);
    return UNITY_END();
}
