// What only the f32 arithmetic has. What both promise: tests/contract/test_friction_observer.c.

#include "feedforward/friction_observer_f32.h"

#include "same.h"
#include "unity.h"

#include <math.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_observer_starts_at_0_from_a_bad_force(void)
{
    const float                         bad[] = {NAN, INFINITY, -INFINITY, -1.1e6f};
    tribo_friction_observer_f32_state_t observer;
    for (int i = 0; i < 4; i++)
    {
        tribo_friction_observer_f32_reset(&observer, bad[i]);
        TEST_ASSERT_SAME_FLOAT(0.0f, observer.y_n);
    }
    tribo_friction_observer_f32_reset(&observer, -1.0e6f);
    TEST_ASSERT_SAME_FLOAT(-1.0e6f, observer.y_n);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_observer_starts_at_0_from_a_bad_force);
    return UNITY_END();
}
