// What the set-up functions take and refuse; what they make of it is tested with the modules that run it.

#include "controller/biquad_f32.h"
#include "controller/biquad_q31.h"
#include "friction/arm_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/paper_controller.h"

#include "cascade_q31.h"
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static tribo_force_loop_f32_config_t config;
static tribo_breakaway_point_f32_t   points[TRIBO_BREAKAWAY_POINTS_MAX];
static float                         full_scale;

void setUp(void)
{
    config     = tribo_force_loop_f32_paper();
    full_scale = 2.0f;
    for (size_t i = 0; i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        points[i] = (tribo_breakaway_point_f32_t){0.05f * (float)i, 0.1f, 0.1f};
    }
}

/// Everything that the set-up of a loop may write.
typedef struct
{
    tribo_force_loop_q31_params_t params;
    tribo_breakaway_point_q31_t   table[TRIBO_BREAKAWAY_POINTS_MAX];
    tribo_headroom_q31_t          headroom;
} written_t;

static tribo_status_t init(written_t *out)
{
    const tribo_force_loop_q31_config_t whole = {.loop         = config,
                                                 .full_scale_n = full_scale,
                                                 .table        = out->table,
                                                 .headroom     = &out->headroom};
    return tribo_force_loop_q31_init(&out->params, &whole);
}

static void check_refused(tribo_status_t status)
{
    static written_t out;
    memset(&out, 0xa5, sizeof out);
    TEST_ASSERT_EQUAL_INT_MESSAGE(status, init(&out), tribo_status_text(status));
    TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out, sizeof out);
}

static void check_taken(void)
{
    static written_t out;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&out));
}

// --- every field -------------------------------------------------------------------------------------------------

static void test_quantize_takes_a_full_scale_from_1e_3_to_1e6(void)
{
    const float bad[] = {0.0f, -2.0f, 0.999e-3f, 1.001e6f, NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        full_scale = bad[i];
        check_refused(TRIBO_ERR_FULL_SCALE);
        tribo_controller_q31_params_t controller;
        tribo_friction_q31_params_t   friction;
        TEST_ASSERT_EQUAL_INT(TRIBO_ERR_FULL_SCALE,
                              tribo_controller_q31_init(&controller, &config.controller, bad[i], NULL));
        TEST_ASSERT_EQUAL_INT(TRIBO_ERR_FULL_SCALE,
                              tribo_friction_q31_init(&friction, NULL, &config.compensator.friction, 1e-3f, bad[i]));
    }
    // Everything scaled along with it, the loop is the same to the last bits.
    static written_t small;
    static written_t large;
    for (int i = 0; i < 2; i++)
    {
        config                                        = tribo_force_loop_f32_paper();
        const float scale                             = i == 0 ? 1.0f / 1024.0f : 262144.0f;
        full_scale                                    = 2.0f * scale;
        config.input_max_n                            = scale;
        config.controller.u_min_n                     = -scale;
        config.controller.u_max_n                     = scale;
        config.compensator.friction.positive.offset_n = 0.007f * scale;
        config.compensator.friction.negative.offset_n = 0.007f * scale;
        config.compensator.friction.v0_n_per_s        = 0.007f * scale;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(i == 0 ? &small : &large));
    }
    TEST_ASSERT_EQUAL_MEMORY(&small.params.controller, &large.params.controller, sizeof small.params.controller);
    TEST_ASSERT_EQUAL_UINT32(small.params.compensator.friction.law[0].offset,
                             large.params.compensator.friction.law[0].offset);
    TEST_ASSERT_UINT32_WITHIN(512,
                              small.params.compensator.friction.exponent_rate,
                              large.params.compensator.friction.exponent_rate);
}

static void test_quantize_checks_pointers(void)
{
    written_t                           out;
    tribo_friction_f32_config_t        *friction   = &config.compensator.friction;
    tribo_controller_f32_config_t       controller = config.controller;
    const tribo_force_loop_q31_config_t whole      = {.loop = config, .full_scale_n = 2.0f};
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_q31_init(NULL, &whole));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_force_loop_q31_init(&out.params, NULL));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_q31_init(&out.params, &whole));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_friction_q31_init(NULL, NULL, friction, 1e-3f, 2.0f));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_friction_q31_init(&out.params.compensator.friction, NULL, NULL, 1e-3f, 2.0f));
    friction->table        = points;
    friction->table_length = 3;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_friction_q31_init(&out.params.compensator.friction, NULL, friction, 1e-3f, 2.0f));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_controller_q31_init(NULL, &controller, 2.0f, NULL));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_controller_q31_init(&out.params.controller, NULL, 2.0f, NULL));
}

static void test_quantize_says_what_the_f32_functions_say(void)
{
    config.sample_time_s = 0.0f;
    check_refused(TRIBO_ERR_SAMPLE_TIME);
    setUp();
    config.gain = 2.1f;
    check_refused(TRIBO_ERR_GAIN);
    setUp();
    config.controller.u_min_n = 0.1f;
    check_refused(TRIBO_ERR_U_MIN);
    setUp();
    config.compensator.friction.k_max = 1001.0f;
    check_refused(TRIBO_ERR_K_MAX);
    setUp();
    config.compensator.arm.inertia = 0.0f;
    check_refused(TRIBO_ERR_INERTIA);
    setUp();
    tribo_friction_q31_params_t friction;
    config.compensator.friction.k_min = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_K_MIN,
                          tribo_friction_q31_init(&friction, NULL, &config.compensator.friction, 1e-3f, 2.0f));
    tribo_controller_q31_params_t controller;
    config.controller.section_count = 0;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SECTION_COUNT,
                          tribo_controller_q31_init(&controller, &config.controller, 2.0f, NULL));
    tribo_biquad_q31_params_t        cascade;
    const tribo_biquad_f32_section_t unstable[] = {TRIBO_BIQUAD_F32(1.0, 0.0, 0.0, -1.01, 0.0)};
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SECTION_UNSTABLE, cascade_q31_init(&cascade, unstable, 1, NULL));
}

static void test_quantize_takes_forces_up_to_full_scale(void)
{
    config.input_max_n        = 2.0f;
    config.controller.u_min_n = -2.0f;
    config.controller.u_max_n = 2.0f;
    written_t out;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&out));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX - 1, out.params.input_max); // the ends of the scale are bad inputs
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, out.params.controller.u_min);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, out.params.controller.u_max);
    config.input_max_n = 2.0001f;
    check_refused(TRIBO_ERR_INPUT_MAX);
    config.input_max_n = 1.9e-6f; // 1e-6 of full scale is 2e-6 N
    check_refused(TRIBO_ERR_INPUT_MAX);
    config.input_max_n = 2.1e-6f;
    check_taken();
    setUp();
    config.controller.u_min_n = -0.9e-6f;
    config.controller.u_max_n = 0.9e-6f;
    check_refused(TRIBO_ERR_U_MAX);
    config.controller.u_max_n = 1.2e-6f;
    check_taken();
    setUp();
    config.compensator.friction.set_level = 0.9e-6f;
    check_refused(TRIBO_ERR_SET_LEVEL);
    config.compensator.friction.set_level   = 1.1e-6f;
    config.compensator.friction.reset_level = 0.9e-6f;
    check_refused(TRIBO_ERR_RESET_LEVEL);
    config.compensator.friction.reset_level = 1.1e-6f;
    check_taken();
    config.compensator.friction.set_level   = 1.0f;
    config.compensator.friction.reset_level = 1.0f;
    check_taken();
    // Of c1 L there must be a bit, or a relay rests unset.
    config.compensator.friction.positive.offset_n = 4.1e-6f; // of 2 N: 4402 bits
    config.compensator.friction.set_level         = 1.0f / 4096.0f;
    check_taken();
    config.compensator.friction.set_level = 1.0f / 8192.0f;
    check_refused(TRIBO_ERR_SET_LEVEL);
    config.compensator.friction.negative.offset_n = 4.1e-6f;
    config.compensator.friction.positive.offset_n = 0.01f;
    check_refused(TRIBO_ERR_SET_LEVEL);
    setUp();
    config.controller.u_min_n = -2.0001f;
    check_refused(TRIBO_ERR_U_MIN);
    setUp();
    config.controller.u_max_n = 2.0001f;
    check_refused(TRIBO_ERR_U_MAX);
    setUp();
    for (int sign = -1; sign <= 1; sign += 2)
    {
        config.compensator.friction.gravity_n = (float)sign * 1.999f;
        check_taken();
        config.compensator.friction.gravity_n = (float)sign * 2.0f;
        check_refused(TRIBO_ERR_GRAVITY);
    }
}

static void test_quantize_takes_a_breakaway_from_1e_6_of_full_scale_to_almost_all_of_it(void)
{
    tribo_breakaway_f32_t *const laws[]    = {&config.compensator.friction.positive,
                                              &config.compensator.friction.negative};
    const tribo_status_t         refused[] = {TRIBO_ERR_BREAKAWAY_OFFSET, TRIBO_ERR_BREAKAWAY_NEGATIVE_OFFSET};
    for (size_t i = 0; i < 2; i++)
    {
        laws[i]->offset_n = 1.99f;
        check_taken();
        laws[i]->offset_n = 2.0f;
        check_refused(refused[i]);
        laws[i]->offset_n = 2.01e-6f;
        check_taken();
        laws[i]->offset_n = 1.99e-6f;
        check_refused(refused[i]);
        laws[i]->offset_n = 0.007f;
        laws[i]->slope    = 10.0f;
        check_taken();
        laws[i]->slope = 0.0f;
        check_taken();
    }
}

static void test_quantize_checks_the_table_and_copies_it(void)
{
    tribo_friction_f32_config_t *friction = &config.compensator.friction;
    friction->table                       = points;
    friction->table_length                = TRIBO_BREAKAWAY_POINTS_MAX;
    static written_t out;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&out));
    TEST_ASSERT_EQUAL_PTR(out.table, out.params.compensator.friction.table);
    TEST_ASSERT_EQUAL_INT(TRIBO_BREAKAWAY_POINTS_MAX, out.params.compensator.friction.table_length);
    for (size_t i = 0; i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1.0, (double)points[i].force_n / 2.0 * 2147483648.0, (double)out.table[i].force);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, (double)points[i].positive_n / 2.0 * 2147483648.0, out.table[i].positive);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, (double)points[i].negative_n / 2.0 * 2147483648.0, out.table[i].negative);
    }
    friction->positive.offset_n = NAN; // not read
    check_taken();

    points[31].force_n = 2.0f; // not below full scale
    check_refused(TRIBO_ERR_TABLE_FORCE);
    friction->table_length = 31;
    check_taken();
    points[1].force_n = FLT_MIN; // strictly rising in float, not in Q31
    check_refused(TRIBO_ERR_TABLE_FORCE);
    points[1].force_n    = 0.05f;
    points[7].positive_n = 2.0f;
    check_refused(TRIBO_ERR_TABLE_POSITIVE);
    points[7].positive_n = 1.5e-6f;
    check_refused(TRIBO_ERR_TABLE_POSITIVE);
    points[7].positive_n = 0.1f;
    points[7].negative_n = 2.0f;
    check_refused(TRIBO_ERR_TABLE_NEGATIVE);
    points[7].negative_n = 4.1e-6f; // 4402 bits
    friction->set_level  = 1.0f / 8192.0f;
    check_refused(TRIBO_ERR_SET_LEVEL);
    friction->set_level = 1.0f / 4096.0f;
    check_taken();
    points[7].positive_n = 4.1e-6f / 2.0f;
    check_refused(TRIBO_ERR_SET_LEVEL);
}

static void test_quantize_refuses_a_rate_law_finer_than_a_bit_a_tick(void)
{
    full_scale                             = 1.0e6f;
    config.compensator.friction.positive   = (tribo_breakaway_f32_t){.offset_n = 100.0f, .slope = 0.3f};
    config.compensator.friction.negative   = config.compensator.friction.positive;
    config.compensator.friction.v0_n_per_s = 0.007f;
    check_refused(TRIBO_ERR_V0);
    config.compensator.friction.v0_n_per_s = 1.0f;
    check_taken();
    config.compensator.friction.m = 0.0f;
    check_taken();
    config.compensator.friction.v0_n_per_s    = 1.0e-6f;
    config.sample_time_s                      = 1.0e-6f;
    config.controller.section_count           = 1; // of the paper's: no longer its controller
    config.compensator.friction.m             = 100.0f;
    config.compensator.friction.pulse_width_s = 3.0e-6f;
    full_scale                                = 1.0e6f;
    config.compensator.arm                    = (tribo_arm_f32_config_t){1.0f, 1.0e3f, 1.0e6f};
    check_refused(TRIBO_ERR_V0);
}

// --- cascades ----------------------------------------------------------------------------------------------------

static tribo_status_t plain(const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    static tribo_biquad_q31_params_t out;
    tribo_headroom_q31_t             headroom;
    memset(&out, 0xa5, sizeof out);
    memset(&headroom, 0xa5, sizeof headroom);
    const tribo_headroom_q31_t before = headroom;
    const tribo_status_t       status = cascade_q31_init(&out, sections, count, &headroom);
    if (status != TRIBO_OK)
    {
        TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out, sizeof out);
        TEST_ASSERT_EQUAL_MEMORY(&before, &headroom, sizeof headroom);
    }
    return status;
}

static void test_quantize_refuses_peaks_without_a_bound_or_beyond_2_to_the_24(void)
{
    const tribo_biquad_f32_section_t integrator[] = {{1.0f, 0.5f, 0.1f, 1.0f, 0.0f}};
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_HEADROOM, plain(integrator, 1));
    const tribo_biquad_f32_section_t too_slow[] = {{1.0f, 0.5f, 0.1f, 0.5f, 1.0e-8f}};
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_HEADROOM, plain(too_slow, 1));
    tribo_biquad_f32_section_t gain[] = {{1.0e6f, 2.0e6f, 1.0e6f, 2.0f, 1.0f}, {16.0f, 32.0f, 16.0f, 2.0f, 1.0f}};
    gain[0].b1                        = 1.0e6f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, plain(gain, 1));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_HEADROOM, plain(gain, 2));
    const tribo_biquad_f32_section_t lost[] = {{1.0e6f, 0.0f, 0.0f, 0.3f, 0.01f},
                                               {1.0e6f, 0.0f, 0.0f, 0.3f, 0.01f},
                                               {1.0e6f, 0.0f, 0.0f, 0.3f, 0.01f}};
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_HEADROOM, plain(lost, 3));

    // A controller whose anti-windup has to divide by next to nothing.
    static const tribo_biquad_f32_section_t faint[] = {{1.0e-6f, 1.0e-6f, 0.5e-6f, 1.0f, 0.5f},
                                                       {1.0e-6f, 1.0e-6f, 0.5e-6f, 1.0f, 0.5f}};
    config.controller.sections                      = faint;
    config.controller.section_count                 = 2;
    check_refused(TRIBO_ERR_HEADROOM);
}

// A tail beyond the summed ticks is bounded: from above, and not loosely.
static void test_quantize_bounds_the_tail_of_a_slow_pole(void)
{
    const float distances[] = {1.0e-4f, 2.0e-5f, 5.0e-6f, 2.0e-6f, 5.0e-7f, 1.0e-7f};
    for (size_t i = 0; i < RUNS(sizeof distances / sizeof distances[0], 2u); i++)
    {
        const double                     slow      = (double)distances[i];
        const tribo_biquad_f32_section_t section[] = {
            {1.0f, 0.0f, distances[i], (float)(0.5 + slow), (float)(0.5 * slow)},
        };
        tribo_biquad_q31_params_t out;
        tribo_headroom_q31_t      headroom;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, cascade_q31_init(&out, section, 1, &headroom));
        // H(d) = 1 + ((-a1) d + b2 - a2)/(d^2 + a1 d + a2): residues at -slow and -0.5, summed as geometric series.
        const double at_slow = ((0.5 + slow) * slow + 0.5 * slow) / (0.5 - slow);
        const double at_fast = ((0.5 + slow) * 0.5 + 0.5 * slow) / (slow - 0.5);
        const double exact   = 1.0 + fabs(at_slow) / slow + fabs(at_fast) / 0.5;
        TEST_ASSERT_TRUE((double)headroom.output[0] > exact);
        TEST_ASSERT_TRUE((double)headroom.output[0] < 1.06 * exact);
        printf("pole %g from 1: bound %g, sum of the modes %g\n", slow, (double)headroom.output[0], exact);
    }
}

// One pole gains on the other for longer than is summed, or shows only once the other has decayed.
static void test_quantize_bounds_the_tail_of_two_slow_poles(void)
{
    static const struct
    {
        double p, q; // distances from z = 1
        double A, B; // residues of one sign, each of which is a geometric series
    } cases[] = {{2.0e-5, 2.5e-7, 0.01, 4.0e-4}, {5.0e-3, 1.0e-6, 5.0, 1.0e-4}};
    for (size_t i = 0; i < 2; i++)
    {
        const double                     p = cases[i].p, q = cases[i].q, A = cases[i].A, B = cases[i].B;
        const tribo_biquad_f32_section_t section[] = {
            {1.0f, (float)(A + B + p + q), (float)(A * q + B * p + p * q), (float)(p + q), (float)(p * q)}};
        const double              exact = 1.0 + A / p + B / q;
        tribo_biquad_q31_params_t out;
        tribo_headroom_q31_t      headroom;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, cascade_q31_init(&out, section, 1, &headroom));
        TEST_ASSERT_TRUE((double)headroom.output[0] > exact);
        TEST_ASSERT_TRUE((double)headroom.output[0] < 1.06 * exact);
    }
}

static void test_quantize_takes_integrators_in_a_controller(void)
{
    static const tribo_biquad_f32_section_t pid[] = {{12.0f, 4.0f, 0.5f, 0.8f, 0.0f}};
    config.controller.sections                    = pid;
    config.controller.section_count               = 1;
    static written_t out;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(&out));
    TEST_ASSERT_EQUAL_INT32(0, out.params.controller.cascade.section[0].d2);
    TEST_ASSERT_TRUE(out.headroom.output[0] > 1.0f);
    TEST_ASSERT_TRUE(out.headroom.output[1] == out.headroom.output[0]); // of the section that passes its input on
    TEST_ASSERT_TRUE(out.headroom.output[2] == 0.0f && out.headroom.output[3] == 0.0f);
}

// Stable in float; the nearest Q31 numbers are not.
static void test_quantize_checks_the_numbers_that_will_run(void)
{
    config.controller.section_count                 = 1;
    static const tribo_biquad_f32_section_t close[] = {{1.0f, 0.9f, 0.5f, 1.6e-9f, 1.0e-9f}};
    config.controller.sections                      = close;
    check_refused(TRIBO_ERR_SECTION_UNSTABLE);
}

static void test_quantize_takes_poles_near_z_minus_1(void)
{
    // d^2 + a1 d + a2 with both poles at -0.9
    const tribo_biquad_f32_section_t section[] = {{1.0f, 1.9f, 0.9f, 3.8f, 3.61f}};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, plain(section, 1));
}

static void test_quantize_takes_the_papers_loop_at_many_sample_times_and_full_scales(void)
{
    const float                             sample_times[] = {20e-6f, 50e-6f, 100e-6f, 1e-3f, 2e-3f, 5e-3f, 10e-3f};
    static const tribo_biquad_f32_section_t pi[]           = {TRIBO_BIQUAD_F32(2.0, -1.9, 0.0, -1.0, 0.0)};
    config.controller.sections                             = pi;
    config.controller.section_count                        = 1;
    for (size_t i = 0; i < sizeof sample_times / sizeof sample_times[0]; i++)
    {
        for (full_scale = 2.0f; full_scale < 300.0f; full_scale *= 3.7f)
        {
            config.sample_time_s                      = sample_times[i];
            config.compensator.friction.pulse_width_s = 3.0f * sample_times[i];
            check_taken();
        }
    }
}

static void test_quantize_rounds_both_signs_alike(void)
{
    random_t r = {8};
    for (int i = 0; i < RUNS(200, 20); i++)
    {
        // Poles at z = 0: the gain at rest is b2, the peak the sum of three samples.
        const tribo_biquad_f32_section_t plus[]  = {{(float)random_between(&r, 1e-4, 1.0),
                                                     (float)random_between(&r, 1e-4, 1.0),
                                                     (float)random_between(&r, 1e-4, 1.0),
                                                     2.0f,
                                                     1.0f}};
        const tribo_biquad_f32_section_t minus[] = {{-plus[0].b0, -plus[0].b1, -plus[0].b2, 2.0f, 1.0f}};
        tribo_biquad_q31_params_t        a       = {.count = 0};
        tribo_biquad_q31_params_t        b       = {.count = 0};
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, cascade_q31_init(&a, plus, 1, NULL));
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, cascade_q31_init(&b, minus, 1, NULL));
        TEST_ASSERT_EQUAL_INT32(a.section[0].b0, -b.section[0].b0);
        TEST_ASSERT_EQUAL_INT32(a.section[0].c1, -b.section[0].c1);
        TEST_ASSERT_EQUAL_INT32(a.section[0].c2, -b.section[0].c2);
        TEST_ASSERT_DOUBLE_WITHIN(0.5,
                                  ldexp((double)plus[0].b0, 28 - a.section[0].scale + a.input_scale),
                                  (double)a.section[0].b0);
    }
}

// However slow the pole of a large gain at rest is, d2 is its a2 to the last of the 24 bits that a float has.
static void test_quantize_keeps_every_bit_of_a_slow_pole(void)
{
    tribo_biquad_f32_section_t slow[] = TRIBO_PAPER_CONTROLLER_F32;
    random_t                   r      = {9};
    int                        runs   = 0;
    for (int i = 0; i < 40; i++)
    {
        slow[1].a2 = (float)pow(10.0, random_between(&r, -6.5, -3.0));
        tribo_controller_q31_params_t       q31;
        const tribo_controller_f32_config_t of_slow = {.sections      = slow,
                                                       .section_count = 2,
                                                       .u_min_n       = -2.0f,
                                                       .u_max_n       = 2.0f};
        if (tribo_controller_q31_init(&q31, &of_slow, 2.0f, NULL) == TRIBO_OK)
        {
            const tribo_biquad_q31_section_t *s = &q31.cascade.section[1];
            TEST_ASSERT_EQUAL_INT64(-(int64_t)ldexp((double)slow[1].a2, 60 + s->shift),
                                    (int64_t)s->d2 * (INT64_C(1) << 32) + s->d2_low);
            runs += s->d2_low != 0;
        }
    }
    TEST_ASSERT_TRUE(runs > 30);
}

#include "runners/test_quantize_q31.inc" // main
