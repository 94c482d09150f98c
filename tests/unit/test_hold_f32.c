// What only the f32 arithmetic has. What both promise: tests/contract/test_hold.c.

#include "feedforward/hold_f32.h"

#include "same.h"
#include "unity.h"

static tribo_hold_f32_params_t params;
static tribo_hold_f32_state_t  hold;

void setUp(void)
{
    const tribo_hold_f32_config_t config = tribo_hold_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_hold_f32_init(&params, &config, 1.0e-3f));
    hold_f32_reset(&hold);
}

void tearDown(void)
{
}

static void test_a_long_slide_takes_all_of_the_extra_margin_back(void)
{
    hold.extra_margin = 0.5f;
    hold_f32_learned(&params, &hold, 1.0f); // over margin_travel_n
    TEST_ASSERT_SAME_FLOAT(0.0f, hold.extra_margin);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_long_slide_takes_all_of_the_extra_margin_back);
    return UNITY_END();
}
