#include "loop/force_loop_f32.h"
#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"

#include "unity.h"

#include <stddef.h>

static tribo_compensator_f32_config_t model;
static tribo_friction_f32_params_t    friction;
static tribo_feedforward_f32_rig_t    rig;

void setUp(void)
{
    model = tribo_compensator_f32_paper();
    rig   = (tribo_feedforward_f32_rig_t){.actuator_pole_rad_per_s = 200.0f,
                                          .sensor_pole_rad_per_s   = 55.0f,
                                          .arm                     = &model.arm,
                                          .friction                = &friction,
                                          .input_max_n             = 2.0f,
                                          .sample_time_s           = 1.0e-3f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&friction, &model.friction, 1.0e-3f));
}

void tearDown(void)
{
}

/// Every field of a is `times` that of b, within 1e-4; all fields are floats.
static void check_ratio(const void *a, const void *b, size_t size, const float *times)
{
    const float *x = a;
    const float *y = b;
    for (size_t i = 0; i < size / sizeof(float); i++)
    {
        TEST_ASSERT_FLOAT_WITHIN(1e-4f * times[i] * y[i], times[i] * y[i], x[i]);
    }
}

#define ONES 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1

static void test_the_papers_rig_has_the_defaults(void)
{
    const float                          times[]  = {ONES};
    const tribo_feedforward_f32_config_t tuned    = tribo_feedforward_f32_tuned(&rig);
    const tribo_feedforward_f32_config_t standard = tribo_feedforward_f32_default();
    const tribo_guard_f32_config_t       guard    = tribo_guard_f32_tuned(&rig);
    const tribo_guard_f32_config_t       usual    = tribo_guard_f32_default();
    check_ratio(&tuned, &standard, sizeof tuned, times);
    check_ratio(&guard, &usual, sizeof guard, times);
    rig.noise_n                                = 1.0e-3f; // the defaults serve that, too
    const tribo_feedforward_f32_config_t noisy = tribo_feedforward_f32_tuned(&rig);
    check_ratio(&noisy, &standard, sizeof noisy, times);
}

static void test_all_forces_of_a_rig_times_8_are_all_of_these_times_8(void)
{
    const tribo_feedforward_f32_config_t standard = tribo_feedforward_f32_default();
    const tribo_guard_f32_config_t       usual    = tribo_guard_f32_default();
    model.friction.positive.offset_n *= 8.0f;
    model.friction.negative.offset_n *= 8.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&friction, &model.friction, 1.0e-3f));
    rig.input_max_n                            = 16.0f;
    const tribo_feedforward_f32_config_t tuned = tribo_feedforward_f32_tuned(&rig);
    const tribo_guard_f32_config_t       guard = tribo_guard_f32_tuned(&rig);
    //                       p  p  w  T  l  k  T  T  r  T  w  T  r  d  e   s  o  c  c  t  d  w  f       m  m   E  T  m  T  c  T
    static const float times[]  = {1, 1, 8, 1, 1, 1, 1,      1, 8, 1, 8, 1, 8, 8, 8, 1,
                                   8, 1, 1, 1, 1, 8, 0.125f, 1, 1, 1, 1, 1, 1, 8, 1};
    static const float guards[] = {8, 1, 8, 1};
    TEST_ASSERT_EQUAL_size_t(sizeof times, sizeof tuned);
    check_ratio(&tuned, &standard, sizeof tuned, times);
    check_ratio(&guard, &usual, sizeof guard, guards);
}

static void test_noise_widens_what_tells_it_from_travel(void)
{
    rig.noise_n                                = 5.0e-3f;
    const tribo_feedforward_f32_config_t tuned = tribo_feedforward_f32_tuned(&rig);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 15.0e-3f, tuned.slide_width_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 25.0e-3f, tuned.slide_run_in_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 4.7434e-3f, tuned.slide_error_max_n); // 30 mN sqrt(1/40)
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 40.0e-3f, tribo_guard_f32_tuned(&rig).stray_n);
    rig.noise_n       = 1.0f;
    rig.sample_time_s = 0.1f;
    rig.arm           = &model.arm;
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 6.0f * 0.22360680f, tribo_feedforward_f32_tuned(&rig).slide_error_max_n);
}

static void test_a_slow_tick_and_a_slow_path_lengthen_times(void)
{
    rig.sample_time_s                         = 0.02f;
    const tribo_feedforward_f32_config_t slow = tribo_feedforward_f32_tuned(&rig);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 2.0f, slow.noise_time_s);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.04f, slow.rate_time_s);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.2f, slow.slide_filter_time_s);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.4f, tribo_guard_f32_tuned(&rig).quick_time_s);
    rig.sample_time_s           = 1.0e-3f;
    rig.actuator_pole_rad_per_s = 20.0f; // tau 57.5 ms
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.092f, tribo_feedforward_f32_tuned(&rig).jump_time_s);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.046f, tribo_feedforward_f32_tuned(&rig).rate_time_s);
}

static void test_what_the_rule_gives_is_accepted(void)
{
    const float scale[] = {1e-3f, 1.0f, 1e3f};
    const float time[]  = {1e-4f, 1e-3f, 1e-2f};
    for (int i = 0; i < 9; i++)
    {
        tribo_feedforward_f32_params_t params;
        tribo_guard_f32_params_t       guard;
        setUp();
        rig.input_max_n *= scale[i / 3];
        rig.noise_n                                  = 1e-3f * scale[i / 3];
        rig.sample_time_s                            = time[i % 3];
        const tribo_feedforward_f32_config_t tuned   = tribo_feedforward_f32_tuned(&rig);
        const tribo_guard_f32_config_t       guarded = tribo_guard_f32_tuned(&rig);
        TEST_ASSERT_EQUAL_INT(TRIBO_OK,
                              tribo_feedforward_f32_init(&params, &tuned, &model, rig.input_max_n, rig.sample_time_s));
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_guard_f32_init(&guard, &guarded, rig.sample_time_s));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_papers_rig_has_the_defaults);
    RUN_TEST(test_all_forces_of_a_rig_times_8_are_all_of_these_times_8);
    RUN_TEST(test_noise_widens_what_tells_it_from_travel);
    RUN_TEST(test_a_slow_tick_and_a_slow_path_lengthen_times);
    RUN_TEST(test_what_the_rule_gives_is_accepted);
    return UNITY_END();
}
