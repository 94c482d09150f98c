// What only the f32 arithmetic has. What both promise: tests/contract/test_guard.c.

#include "loop/guard_f32.h"
#include "tribo/force_loop_f32.h"

#include "same.h"
#include "unity.h"

#include <math.h>

#define H 1.0e-3f

static tribo_guard_f32_config_t config;
static tribo_guard_f32_params_t params;
static tribo_guard_f32_state_t  guard;

void setUp(void)
{
    config = tribo_guard_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_guard_f32_init(&params, &config, H));
    tribo_guard_f32_reset(&guard);
}

/// `swings` in which f goes from one side to the other in `ticks`, and y with it by `swing_n` against `asked_n` of r.
static void swing(int swings, int ticks, float swing_n, float asked_n)
{
    for (int i = 0; i < swings; i++)
    {
        const float sign = i % 2 == 0 ? 1.0f : -1.0f;
        for (int k = 1; k <= ticks; k++)
        {
            const float part = (float)k / (float)ticks - 0.5f;
            (void)tribo_guard_f32_step(&params,
                                       &guard,
                                       0.5f + sign * asked_n * part,
                                       0.5f + sign * swing_n * part,
                                       sign * 0.1f,
                                       true);
        }
    }
}

static void test_bad_inputs_are_not_judged(void)
{
    const float bad[] = {NAN, INFINITY, -INFINITY, 1.1e6f, -1.1e6f};
    swing(10, 100, 0.02f, 0.0f);
    for (int i = 0; i < 5; i++)
    {
        tribo_guard_f32_state_t before = guard;
        TEST_ASSERT_SAME_FLOAT(1.0f, tribo_guard_f32_step(&params, &guard, bad[i], 0.5f, -0.1f, true));
        TEST_ASSERT_SAME_FLOAT(1.0f, tribo_guard_f32_step(&params, &guard, 0.5f, bad[i], -0.1f, true));
        TEST_ASSERT_SAME_FLOAT(1.0f, tribo_guard_f32_step(&params, &guard, 0.5f, 0.5f, bad[i], true));
        TEST_ASSERT_EQUAL_MEMORY(&before, &guard, sizeof guard);
    }
}

static void test_a_corrupt_state_recovers(void)
{
    swing(4, 100, 0.02f, 0.0f);
    guard.play.position_n = NAN;
    guard.work            = NAN;
    guard.high_n          = NAN;
    guard.y_n             = NAN;
    guard.fade            = NAN;
    swing(20, 100, 0.02f, 0.0f);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.cause);
    TEST_ASSERT_TRUE(guard.fade >= 0.0f && guard.fade < 1.0f);
}

#include "runners/test_guard_f32.inc" // main
