#include ARITH_HEADER
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define H 1e-3

static tribo_force_loop_f32_config_t config;
static loop_t                        loop;
static loop_t                        other;
static loop_seen_t                   seen;

void setUp(void)
{
    config = tribo_force_loop_f32_paper();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
}

/// A plant that is nothing but a delay and some stiction, so that signals move like a real loop's.
static double toy_plant_n;

static double reference(int k)
{
    return 0.5 + 0.1 * sin(k * 0.002);
}

static void tick(int k)
{
    seen = loop_step(&loop, reference(k), toy_plant_n);
    toy_plant_n += 0.05 * (0.8 * seen.u - toy_plant_n);
}

static void run(int ticks)
{
    toy_plant_n = 0.0;
    for (int k = 0; k < ticks; k++)
    {
        tick(k);
    }
}

/// A reference that limits u now and then and is a bad input eight times in 6000 ticks, for an input_max_n of 1.9 N.
static double rough_reference(int k)
{
    const double jump = k % 1000 > 980 ? 1.4 : 0.0;
    return k % 700 == 699 ? 1.99 : reference(k) - jump;
}

static double smooth_force(int k)
{
    return 0.5 + 0.0999 * sin(k * 0.002 - 0.001);
}

// --- Fig. 9 ------------------------------------------------------------------------------------------------------

static void check_same(const loop_seen_t *a, const loop_seen_t *b)
{
    TEST_ASSERT_TRUE(a->u == b->u);
    TEST_ASSERT_TRUE(a->v == b->v);
    TEST_ASSERT_EQUAL_INT(a->limited, b->limited);
    TEST_ASSERT_TRUE(a->compensator.F == b->compensator.F);
    TEST_ASSERT_TRUE(a->compensator.friction.n == b->compensator.friction.n);
    TEST_ASSERT_TRUE(a->compensator.friction.L == b->compensator.friction.L);
    TEST_ASSERT_TRUE(a->compensator.friction.v == b->compensator.friction.v);
    TEST_ASSERT_TRUE(a->compensator.friction.f == b->compensator.friction.f);
    TEST_ASSERT_EQUAL_INT(a->compensator.friction.q1, b->compensator.friction.q1);
    TEST_ASSERT_EQUAL_INT(a->compensator.friction.q2, b->compensator.friction.q2);
    TEST_ASSERT_EQUAL_INT(a->compensator.friction.q, b->compensator.friction.q);
}

/// The loop and its parts, one after the other: the same to the last bit. Returns the largest breakaway that it saw.
static double check_is_its_parts_joined(void)
{
    parts_t parts;
    double  largest  = 0.0;
    double  friction = 0.0; // of the tick before
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    parts_reset(&parts);
    for (int k = 0; k < 6000; k++)
    {
        const double r = rough_reference(k);
        const double y = smooth_force(k);
        seen           = loop_step(&loop, r, y);
        TEST_ASSERT_DOUBLE_WITHIN(2.0 * ROUNDING, k % 700 == 699 ? 0.0 : r - y, seen.e);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, (double)config.gain * friction, seen.feedforward);

        const loop_seen_t joined = parts_step(&parts, &loop, seen.e, seen.feedforward);
        check_same(&joined, &seen);
        friction = seen.compensator.friction.f;
        largest  = fmax(largest, seen.compensator.friction.L);
    }
    TEST_ASSERT_TRUE(loop_limited_ticks(&loop) > 10u);
    TEST_ASSERT_EQUAL_UINT32(8, loop_bad_inputs(&loop));
    return largest;
}

static void test_loop_is_controller_and_compensator_joined_as_in_fig_9(void)
{
    static const tribo_biquad_f32_section_t  sections[] = {TRIBO_BIQUAD_F32(1.6, -1.56, 0.0, -0.99999, 0.0),
                                                           TRIBO_BIQUAD_F32(1.0, -0.5, 0.0, -0.6, 0.0),
                                                           TRIBO_BIQUAD_F32(1.0, -0.2, 0.0, -0.5, 0.0),
                                                           TRIBO_BIQUAD_F32(1.0, -0.1, 0.0, -0.2, 0.0)};
    static const tribo_breakaway_point_f32_t table[]    = {{0.0f, 0.9f, 0.91f}, {1.0f, 0.92f, 0.93f}};
    config.input_max_n                                  = 1.9f;
    TEST_ASSERT_TRUE(check_is_its_parts_joined() < 0.8);
    config.compensator.friction.table        = table;
    config.compensator.friction.table_length = 2;
    TEST_ASSERT_TRUE(check_is_its_parts_joined() > 0.9); // of the table, not of the law
    config.compensator.friction.table          = NULL;
    config.compensator.friction.table_length   = 0;
    config.compensator.friction.positive.slope = 1.25f;
    (void)check_is_its_parts_joined();
    config.compensator.friction.positive.slope = 0.3f;
    config.gain                                = 1.5f;
    (void)check_is_its_parts_joined();
    config.gain                = 0.85f;
    config.controller.sections = sections;
    for (uint32_t count = 1; count <= TRIBO_BIQUAD_SECTIONS_MAX; count++)
    {
        config.controller.section_count = count;
        (void)check_is_its_parts_joined();
    }
}

static void test_loop_is_the_same_without_signals(void)
{
    static const tribo_breakaway_point_f32_t table[] = {{0.0f, 0.9f, 0.91f}, {1.0f, 0.92f, 0.93f}};
    static loop_t                            unseen;
    config.input_max_n = 1.9f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&unseen, &config));
    unseen.state                             = loop.state; // padding, too
    config.compensator.friction.table        = table;
    config.compensator.friction.table_length = 2;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&other, &config));
    for (int k = 0; k < 6000; k++)
    {
        const loop_t *by = k / 500 % 4 == 3 ? &other : &loop; // with changes of params
        const double  u  = loop_step_by(&loop, by, rough_reference(k), smooth_force(k)).u;
        TEST_ASSERT_TRUE(u == loop_step_unseen_by(&unseen, by, rough_reference(k), smooth_force(k)));
        TEST_ASSERT_EQUAL_MEMORY(&loop.state, &unseen.state, sizeof loop.state);
    }
    TEST_ASSERT_TRUE(loop_limited_ticks(&unseen) > 10u);
    TEST_ASSERT_EQUAL_UINT32(8, loop_bad_inputs(&unseen));
}

static void test_loop_with_gain_0_does_without_compensation(void)
{
    config.gain = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    toy_plant_n = 0.0;
    for (int k = 0; k < 500; k++)
    {
        tick(k);
        TEST_ASSERT_TRUE(seen.feedforward == 0.0);
        TEST_ASSERT_TRUE(seen.u == seen.v);
    }
    TEST_ASSERT_TRUE(seen.compensator.friction.f > 0.01); // which goes on estimating
}

// The compensator must see u after the limit, or its arm would walk off while u is limited.
static void test_loop_compensator_sees_the_limited_u(void)
{
    config.controller.u_max_n = 0.3f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    for (int k = 0; k < 5000; k++)
    {
        seen = loop_step(&loop, 1.5, 0.0);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.3, seen.u);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, seen.u, seen.compensator.F + seen.compensator.friction.n);
    }
    TEST_ASSERT_EQUAL_UINT32(5000, loop_limited_ticks(&loop));
}

// --- change of params --------------------------------------------------------------------------------------------

/// Runs into the middle of things, changes to `config`, and compares with a loop that goes on under the old params: u must
/// be the same in the tick of the change and move off from there without a jump.
static void check_bumpless(void)
{
    static loop_t unchanged;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&other, &config));
    for (int change_at = 200; change_at < 4000; change_at += RUNS(97, 970))
    {
        loop_reset(&loop);
        run(change_at);
        unchanged              = loop;
        unchanged.state.active = &loop.params;
        const double r         = reference(change_at);
        const double y         = toy_plant_n;

        const double old_u = loop_step_by(&unchanged, &loop, r, y).u;
        seen               = loop_step_by(&loop, &other, r, y);
        TEST_ASSERT_DOUBLE_WITHIN(CHANGE_TOLERANCE_N, old_u, seen.u);
        TEST_ASSERT_EQUAL_PTR(&other.params, loop.state.active);

        const double old_next = loop_step_by(&unchanged, &loop, r, y).u;
        seen                  = loop_step_by(&loop, &other, r, y);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, old_next, seen.u);
        TEST_ASSERT_EQUAL_UINT32(0, loop_saturations(&loop));
    }
}

static void test_loop_changes_gain_without_a_bump(void)
{
    config.gain = 0.3f;
    check_bumpless();
    TEST_ASSERT_TRUE(0.55 * seen.compensator.friction.f > 0.01); // what the bump would have been
}

static void test_loop_changes_friction_and_arm_without_a_bump(void)
{
    config.compensator.friction.positive.slope = 0.2f;
    config.compensator.friction.negative.slope = 0.4f;
    config.compensator.friction.gravity_n      = 0.003f;
    config.compensator.arm.stiffness           = 5.0f;
    config.compensator.friction.pulse_width_s  = 0.005f;
    check_bumpless();
}

static void test_loop_changes_the_controller_without_a_bump(void)
{
    static const tribo_biquad_f32_section_t softer[] = {TRIBO_BIQUAD_F32(1.0, -0.5, 0.0, -0.6, 0.0),
                                                        TRIBO_BIQUAD_F32(0.4, -0.39, 0.0, -0.99999, 0.0)};
    config.controller.sections                       = softer;
    check_bumpless();
}

static void test_loop_change_to_equal_params_goes_on_as_before(void)
{
    static loop_t unchanged;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&other, &config));
    run(1500);
    unchanged              = loop;
    unchanged.state.active = &unchanged.params;
    for (int k = 0; k < 1000; k++)
    {
        const double expected = loop_step(&unchanged, reference(k), 0.5).u;
        TEST_ASSERT_DOUBLE_WITHIN(10.0 * CHANGE_TOLERANCE_N,
                                  expected,
                                  loop_step_by(&loop, &other, reference(k), 0.5).u);
    }
}

static void test_loop_new_limits_hold_in_the_tick_of_the_change(void)
{
    run(1500);
    TEST_ASSERT_TRUE(seen.u > 0.2);
    config.controller.u_max_n = 0.1f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&other, &config));
    seen = loop_step_by(&loop, &other, 0.5, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.1, seen.u);
    TEST_ASSERT_TRUE(seen.limited);
}

/// Changes params every so many ticks and compares the compensator with one that has never seen but the new ones. Returns the
/// number of ticks with an armed relay.
static int check_compensator_sees_the_new_params_alone(int every)
{
    static compensator_t alone;
    random_t             r     = {3};
    int                  armed = 0;
    config.controller.u_min_n  = -1.99f; // to_force() is exact below the end of the scale
    config.controller.u_max_n  = 1.99f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, compensator_init(&alone, &config.compensator, H));
    config.gain                                   = 0.3f;
    config.controller.u_max_n                     = 1.1f;
    config.compensator.friction.positive.offset_n = 0.07f;
    config.compensator.friction.set_level         = 0.3f;
    config.compensator.friction.reset_level       = 0.4f;
    config.compensator.friction.pulse_width_s     = 0.011f;
    config.compensator.arm.damping                = 0.02f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&other, &config));
    for (int k = 0; k < RUNS(20000, 4000); k++)
    {
        const loop_t *by  = k / every % 2 == 0 ? &loop : &other;
        const double  r_n = 0.5 + 0.2 * sin(k * 0.01) + random_between(&r, -0.02, 0.02);
        const double  y_n = 0.5 + 0.19 * sin(k * 0.01 - 0.1);
        const double  u   = loop_step_by(&loop, by, k % 100 < 10 ? -r_n : r_n, y_n).u;
        alone.params      = by->params.compensator;
        (void)compensator_step(&alone, u);
        TEST_ASSERT_EQUAL_MEMORY(&alone.state, &loop.state.compensator, sizeof alone.state);
        armed += loop.state.compensator.friction.relay.latch.held % 4u != 0u;
    }
    return armed;
}

// A change of params looks at what friction was under the old ones: nothing of that look may stay.
static void test_loop_leaves_its_compensator_to_the_new_params_alone(void)
{
    TEST_ASSERT_TRUE(check_compensator_sees_the_new_params_alone(3) > RUNS(500, 50));
}

// In Q31 u and gravity are beyond full scale together, which is counted: once, for the new params.
static void test_loop_counts_a_saturation_of_the_new_params_alone(void)
{
    config.compensator.friction.gravity_n = -1.9f;
    (void)check_compensator_sees_the_new_params_alone(1);
    TEST_ASSERT_TRUE((loop_saturations(&loop) > 0u) == NET_FORCE_SATURATES);
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_loop_takes_inputs_up_to_their_very_maximum(void)
{
    config.input_max_n = 1.5f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    for (int sign = -1; sign <= 1; sign += 2)
    {
        TEST_ASSERT_TRUE(loop_step(&loop, sign * 1.5, 0.0).e == sign * 1.5);
        TEST_ASSERT_TRUE(loop_step(&loop, 0.0, sign * 1.5).e == -sign * 1.5);
    }
    TEST_ASSERT_EQUAL_UINT32(0, loop_bad_inputs(&loop));
    TEST_ASSERT_TRUE(loop_step(&loop, 1.5 + 1e-6, 0.0).e == 0.0);
    TEST_ASSERT_TRUE(loop_step(&loop, 0.0, -1.5 - 1e-6).e == 0.0);
    TEST_ASSERT_EQUAL_UINT32(2, loop_bad_inputs(&loop));
}

static void test_loop_coasts_over_a_bad_input_counts_it_and_recovers(void)
{
    static loop_t coasting;
    const double  bad[]   = {1.5 + 1e-6, -1.5 - 1e-6, 1.999, -1.999, (double)INFINITY, -(double)INFINITY};
    uint32_t      counted = 0;
    config.input_max_n    = 1.5f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    run(1500);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        for (int which = 0; which < 3; which++)
        {
            coasting              = loop;
            coasting.state.active = &coasting.params;
            const double expected = loop_step(&coasting, 0.5, 0.5).u;
            seen                  = loop_step(&loop, which != 1 ? bad[i] : 0.5, which != 0 ? bad[i] : 0.5);
            TEST_ASSERT_TRUE(expected == seen.u); // e = 0
            TEST_ASSERT_TRUE(seen.e == 0.0);
            counted++;
            TEST_ASSERT_EQUAL_UINT32(counted, loop_bad_inputs(&loop));
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.25, loop_step(&loop, 0.5, 0.25).e);
    TEST_ASSERT_EQUAL_UINT32(counted, loop_bad_inputs(&loop));
    loop.state.bad_inputs = UINT32_MAX;
    (void)loop_step(&loop, 1.999, 0.0);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, loop_bad_inputs(&loop));
}

/// A hundred ticks with a bad r or y, at rest: all are counted and u stays.
static void check_holds_u(double bad, bool at_r, const tribo_feedforward_f32_config_t *feedforward)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&loop, &config, feedforward));
    double y = 0.0;
    double u = 0.0;
    for (int k = 0; k < 4000; k++)
    {
        u = loop_step(&loop, 0.5, y).u;
        y += 0.05 * (u - y);
    }
    TEST_ASSERT_EQUAL_UINT32(0, loop_bad_inputs(&loop));
    for (int k = 0; k < 100; k++)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, u, loop_step(&loop, at_r ? bad : 0.5, at_r ? y : bad).u);
    }
    TEST_ASSERT_EQUAL_UINT32(100, loop_bad_inputs(&loop));
}

// The defaults of a scenario.
static void test_loop_coasts_over_what_is_beyond_full_scale_where_that_is_input_max(void)
{
    const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 1e9, -1e9, 2.000001, -2.000001};
    const tribo_feedforward_f32_config_t feedforward = tribo_feedforward_f32_default();
    config.gain                                      = 0.0f;
    config.input_max_n                               = (float)FULL_SCALE_N;
    for (size_t i = 0; i < 4u * (sizeof bad / sizeof bad[0]); i++)
    {
        check_holds_u(bad[i / 4u], i % 2u != 0u, i / 2u % 2u != 0u ? &feedforward : NULL);
    }
}

static void test_loop_takes_full_scale_where_that_is_input_max(void)
{
    config.input_max_n = (float)FULL_SCALE_N;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    for (int sign = -1; sign <= 1; sign += 2)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, sign * FULL_SCALE_N, loop_step(&loop, sign * FULL_SCALE_N, 0.0).e);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, -sign * FULL_SCALE_N, loop_step(&loop, 0.0, sign * FULL_SCALE_N).e);
    }
    TEST_ASSERT_EQUAL_UINT32(0, loop_bad_inputs(&loop));
}

static void test_loop_reset_leaves_nothing_of_what_was(void)
{
    config.gain = 2.0f; // shows a single bit of friction
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    memset(&loop.state, 0x5a, sizeof loop.state);
    loop_reset(&loop);
    TEST_ASSERT_NULL(loop.state.active);
    TEST_ASSERT_EQUAL_UINT32(0, loop_bad_inputs(&loop));
    TEST_ASSERT_EQUAL_UINT32(0, loop_limited_ticks(&loop));
    seen = loop_step(&loop, 0.0, 0.0);
    TEST_ASSERT_TRUE(seen.u == 0.0 && seen.feedforward == 0.0 && seen.compensator.F == 0.0);
    TEST_ASSERT_FALSE(seen.compensator.friction.q1 || seen.compensator.friction.q2);
}

static void test_loop_params_and_state_of_one_axis_are_small(void)
{
    const size_t pointers = TRIBO_EITHER(8u, 5u) * (sizeof(void *) - 4u); // 4 bytes each on the targets
    const size_t bytes    = sizeof loop.params + sizeof loop.state - pointers;
    printf("params and state of one axis, the guard's in it: %u bytes\n", (unsigned)bytes);
    TEST_ASSERT_TRUE(bytes <= TRIBO_EITHER(416u, 512u));
}

/// One section of a PI, kp + ki h/2 (z + 1)/(z - 1), its second pole and zero at z = 0; computed here in double.
static tribo_biquad_f32_section_t section_of_pi(double kp, double ki_per_s)
{
    const double                     half  = 0.5 * ki_per_s * H;
    const tribo_biquad_f32_section_t ideal = TRIBO_BIQUAD_F32(kp + half, half - kp, 0.0, -1.0, 0.0);
    return ideal;
}

static void test_loop_with_a_pi_by_gains_is_the_loop_with_its_section(void)
{
    static const struct
    {
        float kp, ki_per_s;
    } gains[] = {{0.5f, 27.0f}, {2.0f, 0.5f}, {0.3f, 600.0f}};
    for (size_t i = 0; i < sizeof gains / sizeof gains[0]; i++)
    {
        const tribo_biquad_f32_section_t section = section_of_pi((double)gains[i].kp, (double)gains[i].ki_per_s);

        config                          = tribo_force_loop_f32_paper();
        config.controller.sections      = &section;
        config.controller.section_count = 1;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&other, &config));
        config.controller.sections      = NULL;
        config.controller.section_count = 0;
        config.pi                       = (tribo_pi_t){gains[i].kp, gains[i].ki_per_s};
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
        double y = 0.0;
        for (int k = 0; k < 3000; k++)
        {
            const double u = loop_step(&loop, reference(k), y).u;
            TEST_ASSERT_DOUBLE_WITHIN(2e-6, loop_step(&other, reference(k), y).u, u);
            y += 0.05 * (0.8 * u - y);
        }
    }
}

static void test_loop_with_a_gain_alone_multiplies_by_it(void)
{
    config.controller.section_count = 0;
    config.pi                       = (tribo_pi_t){.kp = 0.7f};
    config.gain                     = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    for (int k = 0; k < 1000; k++)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.7 * reference(k), loop_step(&loop, reference(k), 0.0).u);
    }
}

static void refuse_pi(tribo_status_t status, float kp, float ki_per_s)
{
    config.pi = (tribo_pi_t){kp, ki_per_s};
    TEST_ASSERT_EQUAL_INT(status, loop_init(&loop, &config));
}

static void test_loop_names_what_is_wrong_with_its_controller(void)
{
    refuse_pi(TRIBO_ERR_CONTROLLER, 0.5f, 27.0f); // sections as well
    config.controller.section_count = 0;
    refuse_pi(TRIBO_ERR_SECTION_COUNT, 0.0f, 0.0f); // neither
    refuse_pi(TRIBO_ERR_PI, 0.0f, 1.0f);
    refuse_pi(TRIBO_ERR_PI, 1.1e5f, 1.0f);
    refuse_pi(TRIBO_ERR_PI, NAN, 0.0f);
    refuse_pi(TRIBO_ERR_PI, 0.5f, -1.0f);
    refuse_pi(TRIBO_ERR_PI, 0.5f, NAN);
    refuse_pi(TRIBO_ERR_PI, 0.5f, 1.1e5f);
    refuse_pi(TRIBO_ERR_PI, 0.5f, 1001.0f); // its zero would be outside of the unit circle
    refuse_pi(TRIBO_OK, 0.5f, 999.0f);
}

#include "runners/test_force_loop.inc" // main
