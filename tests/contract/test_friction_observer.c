#include PARTS_HEADER
#include "random.h"
#include "unity.h"

#include <math.h>

#define H           1e-3
#define FILTER_TIME 0.02

static tribo_reference_model_f32_config_t model;
static observer_t                         observer;

void setUp(void)
{
    model = tribo_reference_model_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, observer_init(&observer, &model, FILTER_TIME, H));
    observer_reset(&observer, 0.3);
}

void tearDown(void)
{
}

/// F rises by `rate` in N/s from 0.3 N against friction `L`, which the motor overcomes, behind its pole, and the damping.
static void check_slide(double rate, double L)
{
    const double    actuator = -expm1(-0.2);
    const double    sensor   = -expm1(-0.055);
    double          F        = 0.3;
    double          y        = 0.3;
    observer_seen_t seen     = {.force = 0.0};
    observer_reset(&observer, 0.3);
    for (int k = 0; k < 2000; k++)
    {
        const double pushed = F + 0.0288 / 3.84 * rate + L;
        const double u      = pushed - rate * H + rate * H / actuator; // what the actuator makes `pushed` of
        F += rate * H;
        seen = observer_step(&observer, u, y);
        y += sensor * (F - y);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, y - rate * FILTER_TIME, seen.force);
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, L, seen.friction);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, rate * H, seen.change);
}

static void test_observer_shows_friction_of_a_steady_slide_with_the_sign_of_the_slide(void)
{
    check_slide(0.02, 0.05);
    check_slide(-0.04, -0.08);
}

static void test_observer_shows_what_the_motor_pushes_while_the_arm_sticks(void)
{
    observer_seen_t seen = {.force = 0.0};
    observer_reset(&observer, 0.25);
    for (int k = 0; k < 1000; k++)
    {
        seen = observer_step(&observer, 0.3125, 0.25);
        TEST_ASSERT_TRUE(seen.force == 0.25 && seen.change == 0.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(OBSERVER_REST, 0.0625, seen.friction);
}

/// The equations of the header in double, in forces.
typedef struct
{
    double u1, u2, yf, difference;
} exact_t;

static observer_seen_t exact_step(exact_t *x, double u, double y)
{
    const double part   = H / (FILTER_TIME + H);
    const double before = x->yf;
    x->u1 += -expm1(-0.2) * (u - x->u1);
    x->u2 += -expm1(-0.055) * (x->u1 - x->u2);
    x->yf += part * (y - x->yf);
    x->difference += part * (x->u2 - y - x->difference);
    const double change = x->yf - before;
    return (observer_seen_t){.friction = x->difference - 0.0288 / 3.84 / H * change, .force = x->yf, .change = change};
}

static void test_observer_is_its_equations_and_mirrors(void)
{
    static observer_t mirror;
    exact_t           exact = {0.0, 0.0, 0.0, 0.0};
    random_t          r     = {9};
    double            u     = 0.0;
    double            y     = 0.0;
    double            worst = 0.0;
    observer_reset(&observer, 0.0);
    mirror = observer;
    for (int k = 0; k < 20000; k++)
    {
        u                           = (double)(float)fmin(0.5, fmax(-0.5, u + random_between(&r, -1e-2, 1e-2)));
        y                           = (double)(float)fmin(0.5, fmax(-0.5, y + random_between(&r, -1e-3, 1e-3)));
        const observer_seen_t seen  = observer_step(&observer, u, y);
        const observer_seen_t other = observer_step(&mirror, -u, -y);
        const observer_seen_t found = exact_step(&exact, u, y);
        TEST_ASSERT_TRUE(other.friction == -seen.friction && other.force == -seen.force &&
                         other.change == -seen.change);
        worst = fmax(worst, fabs(seen.friction - found.friction));
        worst = fmax(worst, fabs(seen.force - found.force));
    }
    TEST_ASSERT_DOUBLE_WITHIN(OBSERVER_TOLERANCE, 0.0, worst);
}

static void check_refused(tribo_status_t status, double filter_time)
{
    const observer_t before = observer;
    TEST_ASSERT_EQUAL_INT(status, observer_init(&observer, &model, filter_time, H));
    TEST_ASSERT_EQUAL_MEMORY(&before, &observer, sizeof observer);
}

static void test_observer_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, observer_init(NULL, &model, FILTER_TIME, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, observer_init(&observer, NULL, FILTER_TIME, H));
    check_refused(TRIBO_ERR_SLIDE_FILTER, (double)NAN);
    check_refused(TRIBO_ERR_SLIDE_FILTER, 11.0);
    model.sensor_pole_rad_per_s = -1.0f;
    check_refused(TRIBO_ERR_SENSOR_POLE, FILTER_TIME);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_observer_shows_friction_of_a_steady_slide_with_the_sign_of_the_slide);
    RUN_TEST(test_observer_shows_what_the_motor_pushes_while_the_arm_sticks);
    RUN_TEST(test_observer_is_its_equations_and_mirrors);
    RUN_TEST(test_observer_init_names_the_field);
    return UNITY_END();
}
