// Params that no init has made, because its status was ignored, and states that no start has seen: all zero. Nothing moves, whatever comes in.
// The sanitizers of host-debug watch.

#include ARITH_HEADER

#include "tribo/axis_q31.h"
#include "tribo/joint_q31.h"
#include "unity.h"

#include <string.h>

static const double inputs[] = {0.0, 1e-9, 0.5, -0.5, 1e9, -1e9, (double)NAN};

#define INPUTS (sizeof inputs / sizeof inputs[0])

static loop_t                        loop, never;
static tribo_force_loop_f32_config_t config;

void setUp(void)
{
    config = tribo_force_loop_f32_paper();
    memset(&loop, 0, sizeof loop);
    memset(&never, 0, sizeof never);
}

void tearDown(void)
{
}

/// Each pair of inputs twice, because the first tick changes the state that the second one meets.
static void play_none(TRIBO(force_loop, state_t) * state)
{
    for (uint32_t i = 0; i < 2 * INPUTS * INPUTS; i++)
    {
        const tribo_force_t r      = to_force(inputs[i % INPUTS]);
        const tribo_force_t y      = to_force(inputs[i / INPUTS % INPUTS]);
        tribo_force_t       excess = 1;
        TEST_ASSERT_TRUE(TRIBO(force_loop, step)(&never.params, state, r, y, NULL) == 0);
        const tribo_force_t e = TRIBO(force_loop, error)(&never.params, state, r, y);
        TEST_ASSERT_TRUE(TRIBO(force_loop, command)(&never.params, state, e, &excess) == 0);
        TEST_ASSERT_TRUE(TRIBO(force_loop, command)(&never.params, state, r, &excess) == 0);
    }
}

static void play_loop(uint32_t ticks)
{
    for (uint32_t k = 0; k < ticks; k++)
    {
        const double u = loop_step(&loop, 0.5 * sin(0.02 * k), 0.45 * sin(0.02 * k - 0.1)).u;
        TEST_ASSERT_TRUE(u >= (double)config.controller.u_min_n && u <= (double)config.controller.u_max_n);
    }
}

static void test_a_loop_of_no_params_puts_out_nothing(void)
{
    play_none(&never.state);
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(force_loop, start)(&never.state, &never.params, false));
    play_none(&never.state);
    never.state.memory = &never.memory.state.tick;
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(force_loop, start)(&never.state, &never.params, true));
    play_none(&never.state);
}

static void test_a_running_loop_goes_to_no_params_and_back(void)
{
    TEST_ASSERT_EQUAL(TRIBO_OK, loop_init(&loop, &config));
    play_loop(700);
    play_none(&loop.state);
    play_loop(700);
    const tribo_feedforward_f32_config_t standard = tribo_feedforward_f32_default();
    TEST_ASSERT_EQUAL(TRIBO_OK, loop_init_feedforward(&loop, &config, &standard));
    play_loop(700);
    play_none(&loop.state);
    play_loop(700);
}

static void test_a_loop_that_no_start_has_seen_stays_within_its_limits(void)
{
    TEST_ASSERT_EQUAL(TRIBO_OK, loop_init(&loop, &config));
    memset(&loop.state, 0, sizeof loop.state);
    play_loop(700);
    const tribo_feedforward_f32_config_t standard = tribo_feedforward_f32_default();
    TEST_ASSERT_EQUAL(TRIBO_OK, loop_init_feedforward(&loop, &config, &standard));
    memset(&loop.state, 0, sizeof loop.state);
    play_loop(100);
    loop.state.memory = &loop.memory.state.tick;
    memset(&loop.memory, 0, sizeof loop.memory);
    play_loop(700);
}

static void test_parts_of_no_params_give_nothing(void)
{
    static friction_t    friction;
    static compensator_t compensator;
    TRIBO(friction, signals_t) seen;
    TRIBO(compensator, signals_t) all;
    TRIBO(arm, params_t) arm                = {0};
    TRIBO(arm, state_t) at                  = {0};
    TRIBO(guard, params_t) guard            = {0};
    TRIBO(guard, state_t) guard_state       = {0};
    const TRIBO(friction, params_t) no      = {0};
    const TRIBO(compensator, params_t) none = {0};
    for (uint32_t lived_in = 0; lived_in < 2; lived_in++)
    {
        memset(&friction, 0, sizeof friction);
        memset(&compensator, 0, sizeof compensator);
        if (lived_in != 0)
        {
            TEST_ASSERT_EQUAL(TRIBO_OK, friction_init(&friction, &config.compensator.friction, 1e-3));
            TEST_ASSERT_EQUAL(TRIBO_OK, compensator_init(&compensator, &config.compensator, 1e-3));
        }
        for (uint32_t i = 0; i < 2 * INPUTS * INPUTS; i++)
        {
            const tribo_force_t u = to_force(inputs[i % INPUTS]);
            const tribo_force_t F = to_force(inputs[i / INPUTS % INPUTS]);
            if (lived_in != 0)
            {
                (void)friction_step(&friction, 0.4 * sin(0.9 * i), 0.1);
                (void)compensator_step(&compensator, 0.4 * sin(0.9 * i));
            }
            memset(&seen, 0x55, sizeof seen);
            TEST_ASSERT_TRUE(TRIBO(friction, step)(&no, &friction.state, u, F, &seen) == 0);
            TEST_ASSERT_TRUE(seen.TRIBO_N(f) == 0 && seen.TRIBO_N(L) == 0);
            TEST_ASSERT_TRUE(TRIBO(compensator, step)(&none, &compensator.state, u, &all) == 0);
            TEST_ASSERT_TRUE(isfinite((double)TRIBO(arm, step)(&arm, &at, 0)));
            (void)TRIBO(guard, step)(&guard, &guard_state, u, F, u, true);
            TEST_ASSERT_TRUE(guard_state.fade == 0);
        }
    }
    TEST_ASSERT_EQUAL(0, tribo_relay_latch_step(&(tribo_relay_latch_t){0}, 0));
}

static void test_methods_of_no_params_learn_and_estimate_nothing(void)
{
    const TRIBO(feedforward, params_t) none     = {0};
    TRIBO(force_estimate, t) estimate           = {0};
    TRIBO(feedforward, memory_t) *const memory  = &never.memory;
    const tribo_force_t                 quarter = to_force(0.25);
    TEST_ASSERT_FALSE(TRIBO(feedforward, learn)(&never.params, memory));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, TRIBO(feedforward, learned)(&never.params, &memory->state, 0, quarter).L_n);
    TRIBO(sensorless, motion)(memory, quarter, quarter);
    TRIBO(feedforward, restore)(&memory->state);
    for (uint32_t i = 0; i < INPUTS; i++)
    {
        TRIBO(force_estimate,
              step)(&never.params, &none, &estimate, TRIBO_EITHER(0.1f, 429496729u), to_force(inputs[i]));
        TEST_ASSERT_TRUE(estimate.force == 0);
    }
}

static void test_an_axis_and_a_joint_that_are_not_made_put_out_nothing(void)
{
    static TRIBO(axis, t) axis;
    static TRIBO(axis, params_t) next;
    static TRIBO(axis, blob_t) blob;
    static TRIBO(joint, t) joint;
    tribo_axis_report_t  report;
    tribo_joint_report_t of_joint;
    for (uint32_t i = 0; i < INPUTS * INPUTS; i++)
    {
        const tribo_force_t a = to_force(inputs[i % INPUTS]);
        const tribo_force_t b = to_force(inputs[i / INPUTS]);
        TEST_ASSERT_TRUE(TRIBO(axis, step)(&axis, a, b) == 0);
        TEST_ASSERT_TRUE(TRIBO(axis, error)(&axis, a, b) == 0);
        TEST_ASSERT_TRUE(TRIBO(axis, command)(&axis, a) == 0);
        TEST_ASSERT_TRUE(TRIBO(axis, excess)(&axis) == 0);
        TEST_ASSERT_TRUE(TRIBO(joint, step)(&joint, a, b, a) == 0);
    }
#if TRIBO_IS_Q31
    TEST_ASSERT_FALSE(tribo_axis_q31_learn(&axis));
#endif
    TRIBO(axis, report)(&axis, &report);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, report.breakaway_n[0]);
    TRIBO(axis, restore)(&axis);
    TRIBO(axis, export)(&axis, &blob);
    TEST_ASSERT_EQUAL(TRIBO_ERR_AXIS_ORDER, TRIBO(axis, change)(&axis, &next));
    TEST_ASSERT_EQUAL(TRIBO_ERR_AXIS_ORDER, TRIBO(axis, import)(&axis, &blob));
    TRIBO(joint, load)(&joint, to_force(0.5));
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, gain)(&joint, 0.5f));
    TRIBO(joint, restore)(&joint);
    TRIBO(joint, report)(&joint, &of_joint);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, of_joint.friction);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, TRIBO(joint, force)(&joint).force);
    TEST_ASSERT_TRUE(TRIBO(joint, step)(&joint, 1, 0, 0) == 0);
}

#include "runners/test_never_made.inc" // main
