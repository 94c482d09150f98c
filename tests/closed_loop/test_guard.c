// The guard with both methods on the paper's plant: it stops hunting and leaves other loops alone.

#include "feedforward/learner.h"
#include "plant/truth.h"
#include "rig.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

static rig_t                         rig;
static guard_t                       guard;
static tribo_force_loop_f32_config_t config;

void setUp(void)
{
    config = tribo_force_loop_f32_paper();
}

/// A plant with `scale` times the loop's model breakaway; with the feed-forward's `method`, or null.
static void open_guarded(double scale, const tribo_feedforward_f32_config_t *method)
{
    rig_open(&rig, &config);
    sim_plant_destroy(rig.plant);
    rig.plant_config.truth.friction.breakaway.offset_n *= scale;
    rig.plant_config.truth.friction.breakaway.slope *= scale;
    rig.plant = sim_plant_create(&rig.plant_config, &sim_paper_truth);
    TEST_ASSERT_NOT_NULL(rig.plant);
    if (method != NULL)
    {
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&rig.loop, &config, method));
    }
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, guard_init(&guard, 1e-3));
}

static double tick(double r, double y)
{
    const double        u = loop_step_guarded(&rig.loop, &guard, r, y);
    sim_plant_signals_t unused;
    for (int i = 0; i < RIG_STEPS_A_TICK; i++)
    {
        sim_plant_step(rig.plant, u, &unused);
    }
    return u;
}

/// RMS of r - F over the ticks from `from` to `to` of the benchmark.
static double run(int from, int to)
{
    double sum = 0.0;
    for (int k = from; k < to; k++)
    {
        const double r     = rig_triangle(k);
        const double error = r - rig_force(&rig);
        sum += error * error;
        (void)tick(r, rig_sensor(&rig));
    }
    return sqrt(sum / (to - from));
}

static void test_hunting_of_the_papers_method_at_gain_1_with_half_the_breakaway_ends(void)
{
    config.gain = 1.0f;
    open_guarded(0.5, NULL);
    (void)run(0, 10000);
    int k = 10000;
    for (; k < 20000 && guard.state.cause == TRIBO_GUARD_NONE; k++)
    {
        (void)tick(rig_triangle(k), rig_sensor(&rig));
    }
    printf("hunting seen at %.3f s\n", 1e-3 * k);
    TEST_ASSERT_TRUE(k < 11500);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
    (void)run(k, k + 501);
    TEST_ASSERT_TRUE(loop_share(&rig.loop) <= 0.0);
    (void)run(k + 501, k + 1500);
    TEST_ASSERT_TRUE(run(k + 1500, 40000) < 0.0025); // 0.0019 without compensation, 0.075 without guard
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
    rig_close(&rig);
}

static void test_a_restored_guard_lets_the_loop_hunt_again_and_ends_it_again(void)
{
    config.gain = 1.0f;
    open_guarded(0.5, NULL);
    (void)run(0, 15000);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
    guard_restore(&guard);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
    (void)run(15000, 25000);
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_HUNTING, guard.state.cause);
    rig_close(&rig);
}

/// A feed-forward that is kept from learning what it believes too much, of a plant with `scale` times what it believes.
static void believe(double scale)
{
    tribo_feedforward_f32_config_t method = tribo_feedforward_f32_default();
    method.trust                          = 1.0f;
    open_guarded(scale, &method);
}

/// The learner is certain of the prior, but for what chatter of a feedback tells it while that lasts.
static void tick_without_learning(double r)
{
    const tribo_feedforward_learning_t *const learning = &rig.loop.feedforward.learning;
    tribo_feedforward_learner_t *const        learner  = &rig.loop.memory.state.learner;
    (void)tick(r, rig_sensor(&rig));
    const float V_0 = learner->left > 0u ? tribo_learner_sliding(learning, learner) : 1.0f;
    for (int i = 0; i < 4; i++) // a quarter in a step
    {
        tribo_learner_take(learning, learner, V_0, 0.0f, 1.0f, 0.0f, 0.0f);
    }
}

static void test_a_feed_forward_that_does_not_learn_and_believes_too_much_overshoots(void)
{
    believe(0.4);
    for (int k = 0; k < 10000; k++)
    {
        tick_without_learning(0.5 + 0.1 * sin(12.566370614359172e-3 * k)); // 2 Hz
    }
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_OVERSHOOT, guard.state.cause);
    TEST_ASSERT_TRUE(loop_share(&rig.loop) <= 0.0);
    rig_close(&rig);
}

static void test_a_feed_forward_that_does_harm_notices_it_and_feeds_back(void)
{
    believe(0.5);
    for (int k = 0; k < 60000; k++)
    {
        tick_without_learning(rig_triangle(5 * k));
    }
    TEST_ASSERT_TRUE(rig.loop.memory.state.learner.harms);
    TEST_ASSERT_TRUE(rig.loop.memory.state.learner.length > 4);
    rig_close(&rig);
}

static void test_it_leaves_alone_what_is_right(void)
{
    const tribo_feedforward_f32_config_t method  = tribo_feedforward_f32_default();
    const double                         scale[] = {1.0, 0.5, 0.8, 1.5};
    for (int i = 0; i < 8; i++)
    {
        const bool fed = i % 2 == 0;
        setUp();
        if (!fed && i / 2 == 1)
        {
            continue; // the paper's method hunts
        }
        open_guarded(scale[i / 2], fed ? &method : NULL);
        (void)run(0, 60000);
        TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
        TEST_ASSERT_TRUE(loop_share(&rig.loop) >= 1.0);
        rig_close(&rig);
    }
}

static void test_a_faded_feed_forward_learns_on_without_moving_u(void)
{
    const tribo_feedforward_f32_config_t method = tribo_feedforward_f32_default();
    open_guarded(1.0, &method);
    (void)run(0, 12000);
    guard.state.cause = TRIBO_GUARD_HUNTING;
    (void)run(12000, 13000);
    const double learned = loop_learned_travel(&rig.loop);
    double       last    = 0.0;
    double       most    = 0.0;
    for (int k = 13000; k < 19000; k++) // falls steadily
    {
        const double u = tick(rig_triangle(k), rig_sensor(&rig));
        most           = k > 14000 ? fmax(most, fabs(u - last)) : 0.0;
        last           = u;
    }
    TEST_ASSERT_TRUE(loop_learned_travel(&rig.loop) > learned + 0.05);
    TEST_ASSERT_TRUE(most < 1e-4);
    rig_close(&rig);
}

static void test_bad_inputs_are_not_judged(void)
{
    open_guarded(1.0, NULL);
    for (int k = 0; k < 5000; k++)
    {
        const double y = k % 40 < 20 ? 3.0 : -3.0; // beyond input_max
        (void)loop_step_guarded(&rig.loop, &guard, 0.5, y);
        (void)loop_step_guarded(&rig.loop, &guard, y, 0.5);
    }
    TEST_ASSERT_EQUAL_INT(TRIBO_GUARD_NONE, guard.state.cause);
    TEST_ASSERT_FALSE(guard.state.running);
    rig_close(&rig);
}

#include "runners/test_guard.inc" // main
