#include "tribo/hold_q31.h"

#include "random.h"
#include "tribo/quantize_feedforward_q31.h"
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
    tribo_hold_q31_reset(&hold, 1000);
}

void tearDown(void)
{
}

static int32_t units(double force_n)
{
    return (int32_t)lround(force_n / UNIT);
}

static bool stands_for(int ticks, int32_t reference, bool step)
{
    bool stands = false;
    for (int k = 0; k < ticks; k++)
    {
        stands = tribo_hold_q31_stands(&params, &hold, reference, 100, step);
    }
    return stands;
}

static void test_a_reference_stands_when_it_has_for_the_still_time(void)
{
    TEST_ASSERT_FALSE(stands_for(1500, 1000, false));
    TEST_ASSERT_TRUE(stands_for(2, 1000, false));
    TEST_ASSERT_TRUE(stands_for(10000, 1100, false));
    hold.active = true;
    TEST_ASSERT_TRUE(stands_for(1, 5000, true));
    TEST_ASSERT_FALSE(stands_for(1, 5101, false));
    hold.active = false;
    TEST_ASSERT_TRUE(stands_for(1502, 5101, false));
    TEST_ASSERT_FALSE(stands_for(1, INT32_MIN, true));
    TEST_ASSERT_EQUAL_INT32(-(INT32_C(1) << 29), hold.anchor);
    config.gain = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_hold_q31_init(&params, &config, H, (float)FS));
    TEST_ASSERT_FALSE(stands_for(5000, 5101, false));
}

static void test_hold_follows_its_twin_and_mirrors(void)
{
    tribo_hold_f32_params_t twin_params;
    tribo_hold_f32_state_t  twin;
    tribo_hold_q31_state_t  mirror;
    random_t                r       = {21};
    double                  worst_f = 0.0;
    double                  worst_e = 0.0;
    double                  u       = 0.5;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_hold_f32_init(&twin_params, &config, H));
    tribo_hold_f32_reset(&twin, 0.5f);
    tribo_hold_q31_reset(&mirror, -1000);
    tribo_hold_f32_enter(&twin, 0.5f, 0.1f, 1, 0.5f);
    tribo_hold_q31_enter(&hold, units(0.5), units(0.1), 1, units(0.5));
    tribo_hold_q31_enter(&mirror, -units(0.5), -units(0.1), -1, -units(0.5));
    for (int k = 0; k < 100000; k++)
    {
        // Calm for 20 s, then from side to side in up to 0.3 s.
        u                = k < 20000                              ? u + random_between(&r, -1e-3, 1e-3)
                           : k == 20000                           ? 1.0
                           : random_between(&r, 0.0, 150.0) < 1.0 ? 1.0 - u
                                                                  : u;
        const double  y  = k % 3 == 0 ? 0.5 : 0.5 + random_between(&r, -1e-3, 1e-3);
        const double  e  = random_between(&r, -1e-3, 2e-3);
        const int32_t f  = tribo_hold_q31_step(&params, &hold, units(u), (uint32_t)units(0.2), (uint32_t)units(0.1));
        const int32_t g  = tribo_hold_q31_step(&params, &mirror, -units(u), (uint32_t)units(0.1), (uint32_t)units(0.2));
        const int32_t d  = tribo_hold_q31_deadband(&params, &hold, units(e), units(y));
        const int32_t dm = tribo_hold_q31_deadband(&params, &mirror, -units(e), -units(y));
        TEST_ASSERT_EQUAL_INT32(-f, g);
        TEST_ASSERT_EQUAL_INT32(-d, dm);
        TEST_ASSERT_EQUAL_UINT32(hold.caution, mirror.caution);
        worst_f =
            fmax(worst_f, fabs(f * UNIT - (double)tribo_hold_f32_step(&twin_params, &twin, (float)u, 0.2f, 0.1f)));
        worst_e =
            fmax(worst_e, fabs(d * UNIT - (double)tribo_hold_f32_deadband(&twin_params, &twin, (float)e, (float)y)));
        if (k % 1000 == 0)
        {
            tribo_hold_q31_learned(&params, &hold, (uint32_t)units(1e-3));
            tribo_hold_q31_learned(&params, &mirror, (uint32_t)units(1e-3));
            tribo_hold_f32_learned(&twin_params, &twin, 1e-3f);
        }
    }
    TEST_ASSERT_TRUE(hold.caution > UINT32_C(1) << 30);
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 0.0, worst_f);
    TEST_ASSERT_DOUBLE_WITHIN(3e-6, 0.0, worst_e);
}

static void test_hold_takes_extremes(void)
{
    tribo_hold_q31_enter(&hold, INT32_MIN, INT32_MAX, 1, INT32_MIN);
    for (int k = 0; k < 5000; k++)
    {
        const int32_t end = k % 2 == 0 ? INT32_MIN : INT32_MAX;
        const int32_t f   = tribo_hold_q31_step(&params, &hold, end, UINT32_MAX, UINT32_MAX);
        TEST_ASSERT_TRUE(f <= 1 << 29 && f >= -(1 << 29));
        const int32_t e = tribo_hold_q31_deadband(&params, &hold, end, end);
        TEST_ASSERT_TRUE(e <= 1 << 30 && e >= -(1 << 30));
    }
    TEST_ASSERT_TRUE(hold.caution > UINT32_C(0xf0000000));
    tribo_hold_q31_learned(&params, &hold, UINT32_MAX); // counts as 2^20 units, 3.9 mN of 0.1 N
    TEST_ASSERT_UINT32_WITHIN(UINT32_C(0x01000000), UINT32_C(0xf6000000), hold.caution);
    config.caution_travel_n = 2.6e-4f; // hardly 2^16 units
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_hold_q31_init(&params, &config, H, (float)FS));
    tribo_hold_q31_learned(&params, &hold, UINT32_MAX);
    TEST_ASSERT_TRUE(hold.caution <= 1u);
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

static void test_hold_init_names_the_field(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_hold_q31_init(NULL, &config, H, (float)FS));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_hold_q31_init(&params, NULL, H, (float)FS));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_FULL_SCALE, tribo_hold_q31_init(&params, &config, H, 0.0f));
    check(&config.gain, 1.0f, TRIBO_ERR_HOLD_GAIN);
    check(&config.caution_travel_n, 2.0e-4f, TRIBO_ERR_HOLD_CAUTION);
    check(&config.deadband_time_s, 200.0f, TRIBO_ERR_HOLD_DEADBAND);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_reference_stands_when_it_has_for_the_still_time);
    RUN_TEST(test_hold_follows_its_twin_and_mirrors);
    RUN_TEST(test_hold_takes_extremes);
    RUN_TEST(test_hold_init_names_the_field);
    return UNITY_END();
}
