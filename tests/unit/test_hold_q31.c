// What only the Q31 arithmetic has. What both promise: tests/contract/test_hold.c.

#include "feedforward/hold_f32.h"
#include "feedforward/hold_q31.h"
#include "tribo/feedforward_q31.h"

#include "random.h"
#include "unity.h"

#include <math.h>

#define H    1.0e-3f
#define FS   2.0
#define UNIT (FS / 536870912.0) // N

static tribo_hold_f32_config_t config;
static tribo_hold_q31_params_t params;
static tribo_hold_q31_state_t  hold;

void setUp(void)
{
    config = tribo_hold_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_hold_q31_init(&params, &config, H, (float)FS));
    hold_q31_reset(&hold);
}

void tearDown(void)
{
}

static int32_t units(double force_n)
{
    return (int32_t)lround(force_n / UNIT);
}

static void test_hold_follows_its_twin(void)
{
    tribo_hold_f32_params_t twin_params;
    tribo_hold_f32_state_t  twin;
    random_t                r       = {21};
    double                  worst_f = 0.0;
    double                  worst_e = 0.0;
    double                  u       = 0.5;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_hold_f32_init(&twin_params, &config, H));
    hold_f32_reset(&twin);
    hold_f32_enter(&twin, 0.5f, 0.1f, 1, 0.5f);
    hold_q31_enter(&hold, units(0.5), units(0.1), 1, units(0.5));
    for (int k = 0; k < 100000; k++)
    {
        // Calm for 20 s, then from side to side in up to 0.3 s.
        u               = k < 20000                              ? u + random_between(&r, -1e-3, 1e-3)
                          : k == 20000                           ? 1.0
                          : random_between(&r, 0.0, 150.0) < 1.0 ? 1.0 - u
                                                                 : u;
        const double  y = k % 3 == 0 ? 0.5 : 0.5 + random_between(&r, -1e-3, 1e-3);
        const double  e = random_between(&r, -1e-3, 2e-3);
        const int32_t f = hold_q31_step(&params, &hold, units(u), (uint32_t)units(0.2), (uint32_t)units(0.1));
        const int32_t d = hold_q31_deadband(&params, &hold, units(e), units(y));
        worst_f = fmax(worst_f, fabs(f * UNIT - (double)hold_f32_step(&twin_params, &twin, (float)u, 0.2f, 0.1f)));
        worst_e = fmax(worst_e, fabs(d * UNIT - (double)hold_f32_deadband(&twin_params, &twin, (float)e, (float)y)));
        if (k % 1000 == 0)
        {
            hold_q31_learned(&params, &hold, (uint32_t)units(1e-3));
            hold_f32_learned(&twin_params, &twin, 1e-3f);
        }
    }
    TEST_ASSERT_TRUE(hold.extra_margin > UINT32_C(1) << 30);
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 0.0, worst_f);
    TEST_ASSERT_DOUBLE_WITHIN(3e-6, 0.0, worst_e);
}

static void test_hold_takes_extremes(void)
{
    const int32_t  end_of = INT32_C(1) << 29;
    const uint32_t most   = UINT32_C(1) << 29;
    hold_q31_enter(&hold, -end_of, end_of, 1, -end_of);
    for (int k = 0; k < 5000; k++)
    {
        const int32_t end = k % 2 == 0 ? -end_of : end_of;
        const int32_t f   = hold_q31_step(&params, &hold, end, most, most);
        TEST_ASSERT_TRUE(f <= 1 << 29 && f >= -(1 << 29));
        const int32_t e = hold_q31_deadband(&params, &hold, end, end);
        TEST_ASSERT_TRUE(e <= 1 << 30 && e >= -(1 << 30));
    }
    TEST_ASSERT_TRUE(hold.extra_margin > UINT32_C(0xf0000000));
    hold_q31_learned(&params, &hold, UINT32_C(1) << 20); // 3.9 mN of 0.1 N
    TEST_ASSERT_UINT32_WITHIN(UINT32_C(0x01000000), UINT32_C(0xf6000000), hold.extra_margin);
    config.margin_travel_n = 2.6e-4f; // hardly 2^16 units
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_hold_q31_init(&params, &config, H, (float)FS));
    hold_q31_learned(&params, &hold, UINT32_C(1) << 20);
    TEST_ASSERT_TRUE(hold.extra_margin <= 1u);
}

static void check(float *field, float value, tribo_status_t status)
{
    const tribo_hold_q31_params_t before = params;
    const float                   kept   = *field;
    *field                               = value;
    TEST_ASSERT_EQUAL_INT(status, tribo_hold_q31_init(&params, &config, H, (float)FS));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    *field = kept;
}

static void test_hold_init_refuses_what_it_cannot_hold(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_FULL_SCALE, tribo_hold_q31_init(&params, &config, H, 0.0f));
    check(&config.margin_travel_n, 2.0e-4f, TRIBO_ERR_HOLD_MARGIN_TRAVEL);
    check(&config.deadband_time_s, 200.0f, TRIBO_ERR_HOLD_DEADBAND);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_hold_follows_its_twin);
    RUN_TEST(test_hold_takes_extremes);
    RUN_TEST(test_hold_init_refuses_what_it_cannot_hold);
    return UNITY_END();
}
