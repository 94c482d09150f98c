// What only the Q31 arithmetic has. What both promise: tests/contract/test_guard.c.

#include "loop/guard_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/q31.h"

#include "random.h"
#include "unity.h"

#include <math.h>
#include <stddef.h>

#define H  1.0e-3f
#define FS 2.0

static tribo_guard_f32_config_t config;
static tribo_guard_q31_params_t params;
static tribo_guard_q31_state_t  guard;

void setUp(void)
{
    config = tribo_guard_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_guard_q31_init(&params, &config, H, (float)FS));
    tribo_guard_q31_reset(&guard);
}

static int32_t q31(double force_n)
{
    return (int32_t)lround(force_n / FS * 2147483648.0);
}

/// Friction that swings at random speeds and y with it, on both sides or one, while r steps now and then.
typedef struct
{
    double r, y, f;
} sample_t;

static sample_t sample(random_t *random, int k)
{
    static double sign;
    static double y;
    static double left;
    if (k == 0)
    {
        sign = 1.0;
        y    = 0.5;
        left = 0.0;
    }
    if (left < 0.0)
    {
        sign = -sign;
        left = k % 20000 < 6000 ? 60.0 : random_between(random, 20.0, 400.0);
    }
    left -= 1.0;
    y = 0.5 + 0.98 * (y - 0.5) + 1e-3 * sign;
    if (k % 20000 > 12000)
    {
        y = 0.5 + (left > 50.0 && left < 100.0 ? 0.03 * sign : 0.0); // beyond r, and back
    }
    return (sample_t){.r = 0.5 + (k % 20000 < 12000 && k % 700 < 100 ? 0.02 : 0.0),
                      .y = y,
                      .f = sign * 0.1 + random_between(random, -0.01, 0.01)};
}

static void test_guard_decides_as_its_twin_and_mirrors(void)
{
    tribo_guard_f32_params_t twin_params;
    tribo_guard_f32_state_t  twin;
    tribo_guard_q31_state_t  mirror;
    random_t                 random    = {9};
    int                      causes[3] = {0, 0, 0};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_guard_f32_init(&twin_params, &config, H));
    tribo_guard_f32_reset(&twin);
    tribo_guard_q31_reset(&mirror);
    for (int k = 0; k < 100000; k++)
    {
        const sample_t x    = sample(&random, k);
        const float    f32  = tribo_guard_f32_step(&twin_params, &twin, (float)x.r, (float)x.y, (float)x.f, true);
        const uint32_t fade = tribo_guard_q31_step(&params, &guard, q31(x.r), q31(x.y), q31(x.f), true);
        TEST_ASSERT_EQUAL_UINT32(fade, tribo_guard_q31_step(&params, &mirror, -q31(x.r), -q31(x.y), -q31(x.f), true));
        TEST_ASSERT_EQUAL_INT(guard.cause, mirror.cause);
        TEST_ASSERT_EQUAL_INT(twin.cause, guard.cause);
        TEST_ASSERT_EQUAL_UINT8(twin.turns, guard.turns);
        TEST_ASSERT_EQUAL_UINT8(twin.strays, guard.strays);
        TEST_ASSERT_TRUE(fabs((double)f32 - (double)fade / 4294967296.0) < 1e-4);
        causes[guard.cause]++;
        if (k % 5000 == 4999)
        {
            tribo_guard_f32_restore(&twin);
            tribo_guard_q31_restore(&guard);
            tribo_guard_q31_restore(&mirror);
        }
    }
    for (int i = 0; i < 3; i++)
    {
        TEST_ASSERT_TRUE_MESSAGE(causes[i] > 0, "a cause that never was");
    }
}

static void test_full_scale_swings_of_the_longest_swing_fit(void)
{
    config.quick_time_s = 100.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_guard_q31_init(&params, &config, H, (float)FS));
    TEST_ASSERT_TRUE(params.quick_ticks <= 131072u);
    // f and y the same way in one tick, and y back at f's turn of less than its width: W only grows.
    params.half = INT32_C(1) << 29;
    for (int k = 0; k < 140000; k++)
    {
        const int32_t x     = k % 2 == 0 ? INT32_MAX - 1 : 1 - INT32_MAX;
        const int32_t other = -x;
        (void)tribo_guard_q31_step(&params, &guard, other, x, x, true);
        TEST_ASSERT_TRUE(k < 2 || guard.work > 0);
    }
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.cause);
}

static void check(float *field, float bad, tribo_status_t expected)
{
    const float                    good = *field;
    const tribo_guard_q31_params_t was  = params;
    *field                              = bad;
    TEST_ASSERT_EQUAL_INT(expected, tribo_guard_q31_init(&params, &config, H, (float)FS));
    TEST_ASSERT_EQUAL_MEMORY(&was, &params, sizeof params);
    *field = good;
}

static void test_set_up_refuses_what_it_cannot_hold(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_FULL_SCALE, tribo_guard_q31_init(&params, &config, H, 0.0f));
    check(&config.turn_n, 1.0e-6f, TRIBO_ERR_GUARD_TURN);
    check(&config.turn_n, 2.0f, TRIBO_ERR_GUARD_TURN);
    check(&config.stray_n, 1.0e-6f, TRIBO_ERR_GUARD_STRAY);
    check(&config.stray_n, 2.0f, TRIBO_ERR_GUARD_STRAY);
}

#include "runners/test_guard_q31.inc" // main
