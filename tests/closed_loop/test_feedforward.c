// The benchmark with the feed-forward, and the cases where the paper's method is better. The figures are the design's;
// compensation_study prints many more.

#include "compensation.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

static compensation_truth_t          truth;
static const compensation_triangle_t benchmark = {0.4, 0.6, 0.02};

void setUp(void)
{
    truth = compensation_nominal();
}

void tearDown(void)
{
}

static compensation_result_t run(compensation_t method, const tribo_feedforward_f32_config_t *config)
{
    const compensation_result_t x = compensation_run_triangle(method, config, &truth, benchmark);
    printf("RMS %.6f N, peak %.2f mN, total variation %.3f N\n", x.rms, 1e3 * x.peak, x.variation);
    return x;
}

static void test_triangle_has_a_thirtieth_of_the_error(void)
{
    const compensation_result_t off = run(COMPENSATION_OFF, NULL);
    const compensation_result_t x   = run(COMPENSATION_FEEDFORWARD, NULL);
    TEST_ASSERT_TRUE(x.rms <= 0.00013);
    TEST_ASSERT_TRUE(x.peak <= 0.0035);
    TEST_ASSERT_TRUE(x.variation <= 1.35 * off.variation);
}

static void test_triangle_without_the_lead_of_the_jump(void)
{
    tribo_feedforward_f32_config_t config = tribo_feedforward_f32_default();
    config.jump_lead                      = 0.0f;
    TEST_ASSERT_TRUE(run(COMPENSATION_FEEDFORWARD, &config).rms <= 0.00020);
}

static void test_triangle_with_half_and_one_and_a_half_times_the_breakaway_and_noise(void)
{
    static const double scale[] = {0.5, 1.5};
    for (int i = 0; i < 2; i++)
    {
        truth.breakaway_positive = scale[i];
        truth.breakaway_negative = scale[i];
        truth.noise_n            = 1e-3;
        const double off         = run(COMPENSATION_OFF, NULL).rms;
        TEST_ASSERT_TRUE(off / run(COMPENSATION_FEEDFORWARD, NULL).rms >= 3.4);
    }
}

/// A slide up alone cannot tell less friction from a load.
static void test_first_reversal_of_an_arm_with_less_breakaway_than_believed_is_no_worse(void)
{
    static const double scale[] = {0.5, 0.8, 1.0, 1.5};
    for (int i = 0; i < 4; i++)
    {
        truth.breakaway_positive = scale[i];
        truth.breakaway_negative = scale[i];
        const double off         = run(COMPENSATION_OFF, NULL).first_rms;
        const double x           = run(COMPENSATION_FEEDFORWARD, NULL).first_rms;
        printf("breakaway x%.1f, first period: %.2f times\n", scale[i], off / x);
        TEST_ASSERT_TRUE(off / x >= 1.4);
    }
}

static void test_a_command_of_the_wrong_scale_is_no_worse_on_both_sides_of_0(void)
{
    static const compensation_triangle_t across  = {-0.25, 0.25, 0.02};
    static const double                  scale[] = {0.95, 1.05};
    for (int i = 0; i < 2; i++)
    {
        truth.actuator_gain = scale[i];
        const double off    = compensation_run_triangle(COMPENSATION_OFF, NULL, &truth, across).rms;
        const double x      = compensation_run_triangle(COMPENSATION_FEEDFORWARD, NULL, &truth, across).rms;
        printf("scale of u %.2f: %.2f times\n", scale[i], off / x);
        TEST_ASSERT_TRUE(off / x >= 15.0);
    }
}

static double square(const void *context, double t)
{
    return fmod(t, 10.0) < 5.0 ? 0.4 : *(const double *)context;
}

static double ratio(double high)
{
    const double off = compensation_run(COMPENSATION_OFF, NULL, &truth, square, &high, 10.0, 20.0).rms;
    const double x   = compensation_run(COMPENSATION_FEEDFORWARD, NULL, &truth, square, &high, 10.0, 20.0).rms;
    printf("steps 0.4/%.2f: %.2f times\n", high, off / x);
    return off / x;
}

static void test_steps_are_fed_back_while_the_reference_stands(void)
{
    TEST_ASSERT_TRUE(ratio(0.6) >= 1.9);
    TEST_ASSERT_TRUE(ratio(0.42) >= 2.3);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_triangle_has_a_thirtieth_of_the_error);
    RUN_TEST(test_triangle_without_the_lead_of_the_jump);
    RUN_TEST(test_triangle_with_half_and_one_and_a_half_times_the_breakaway_and_noise);
    RUN_TEST(test_first_reversal_of_an_arm_with_less_breakaway_than_believed_is_no_worse);
    RUN_TEST(test_a_command_of_the_wrong_scale_is_no_worse_on_both_sides_of_0);
    RUN_TEST(test_steps_are_fed_back_while_the_reference_stands);
    return UNITY_END();
}
