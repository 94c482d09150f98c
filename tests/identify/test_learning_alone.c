// Breakaway learned beside the paper's compensator and beside none, from u and y of the running loop alone.

#include "learn.h"
#include "plant/truth.h"
#include "rig.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define TICKS 50000 // four reversals and the slide after the last

static rig_t   rig;
static learn_t learn;

static double truth(double force)
{
    return 0.007 + 0.3 * force;
}

typedef struct
{
    double up, down;           ///< learned L over the true breakaway
    double slid_up, slid_down; ///< friction that the arm had in its last slides, likewise
    double relative_variance_up, relative_variance_down;
} learned_t;

/// The triangle with a belief of `times` the breakaway, on the paper's arm or on one whose friction is L(F) at any speed.
static learned_t run(double times, float gain, bool creeps, const char *log)
{
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    tribo_breakaway_f32_t         belief = {.offset_n = (float)(0.007 * times), .slope = (float)(0.3 * times)};
    config.gain                          = gain;
    config.compensator.friction.positive = belief;
    config.compensator.friction.negative = belief;
    rig_open(&rig, &config);
    if (!creeps)
    {
        sim_plant_destroy(rig.plant);
        rig.plant_config.truth.own = sim_scenario_config(rig.scenario)->plant.own[SIM_TRUTH_coulomb];
        rig.plant                  = sim_plant_create(&rig.plant_config, &sim_coulomb_truth);
        TEST_ASSERT_NOT_NULL(rig.plant);
    }
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, learn_init(&learn, belief));
    FILE *file = log != NULL ? fopen(log, "w") : NULL;
    TEST_ASSERT_TRUE(log == NULL || file != NULL);
    double slid[2] = {0.0};
    for (int k = 0; k < TICKS; k++)
    {
        const double r = rig_triangle(k), F = rig_force(&rig), y = rig_sensor(&rig);
        const double u = rig_tick(&rig, &rig.loop, r, y);
        learn_step(&learn, u, y);
        if (k >= TICKS - 20000 && r > 0.45 && r < 0.55) // the middle of the last slope each way, 5 s each
        {
            const bool rises = rig_triangle(k + 1) > r;
            slid[rises ? 0 : 1] += (rises ? u - F : F - u) / truth(F) / 5000.0;
        }
        if (file != NULL)
        {
            (void)fprintf(file, k == 0 ? "t_s,u_N,F_N\n%.3f,%.9g,%.9g\n" : "%.3f,%.9g,%.9g\n", k * 1e-3, u, y);
        }
    }
    TEST_ASSERT_TRUE(file == NULL || fclose(file) == 0);
    double    relative_variance[2];
    learned_t is = {.slid_up = slid[0], .slid_down = slid[1]};
    is.up        = learn_L(&learn, TRIBO_BREAKAWAY_POSITIVE, 0.5, &relative_variance[0]) / truth(0.5);
    is.down      = learn_L(&learn, TRIBO_BREAKAWAY_NEGATIVE, 0.5, &relative_variance[1]) / truth(0.5);
    printf("%s arm, belief %.1f, gain %.2f: learned L+ %.3f, L- %.3f (relative variance %.3f, %.3f); friction in the "
           "slides %.3f, "
           "%.3f\n",
           creeps ? "paper's" : "Coulomb",
           times,
           (double)gain,
           is.up,
           is.down,
           relative_variance[0],
           relative_variance[1],
           is.slid_up,
           is.slid_down);
    is.relative_variance_up   = relative_variance[0];
    is.relative_variance_down = relative_variance[1];
    return is;
}

#define KNOWN 0.1 // a larger relative variance says that L is not known yet

static void check_within_5_percent(double expected, double actual)
{
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * expected, expected, actual);
}

static const double beliefs[] = {0.7, 1.3};
static const float  gains[]   = {0.0f, 0.5f};

static void test_breakaway_30_percent_off_is_learned_within_5_after_four_reversals(void)
{
    for (int i = 0; i < 4; i++)
    {
        const learned_t is = run(beliefs[i % 2], gains[i / 2], false, i == 0 ? getenv("TRIBO_LEARNING_LOG") : NULL);
        check_within_5_percent(1.0, is.up);
        check_within_5_percent(1.0, is.down);
        TEST_ASSERT_TRUE(is.relative_variance_up < KNOWN && is.relative_variance_down < KNOWN);
        rig_close(&rig);
    }
    const learned_t is = run(0.7, 0.85f, false, NULL);
    check_within_5_percent(1.0, is.up);
    check_within_5_percent(1.0, is.down);
    rig_close(&rig);
}

static tribo_breakaway_f32_t line_through(uint32_t direction)
{
    double       relative_variance;
    const double low   = learn_L(&learn, direction, 0.4, &relative_variance),
                 high  = learn_L(&learn, direction, 0.6, &relative_variance);
    const double slope = (high - low) / 0.2;
    return (tribo_breakaway_f32_t){.offset_n = (float)fmax(low - 0.4 * slope, 1e-3), .slope = (float)slope};
}

/// What was learned goes into the paper's compensator of the running loop, at its usual gain.
static void test_learned_breakaway_is_swapped_into_the_papers_compensator(void)
{
    static loop_t                 next;
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    (void)run(1.3, 0.5f, true, NULL);
    config.compensator.friction.positive = line_through(TRIBO_BREAKAWAY_POSITIVE);
    config.compensator.friction.negative = line_through(TRIBO_BREAKAWAY_NEGATIVE);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&next, &config));
    double squares = 0.0, before = rig.seen.u, bump = 0.0;
    for (int k = TICKS; k < TICKS + 40000; k++)
    {
        const double r = rig_triangle(k);
        squares += k >= TICKS + 20000 ? pow(r - rig_force(&rig), 2.0) : 0.0;
        const double u = rig_tick(&rig, &next, r, rig_sensor(&rig));
        bump           = k == TICKS ? fabs(u - before) : bump;
    }
    const double rms = sqrt(squares / 20000.0);
    printf("after the swap: u moves by %.2e N, RMS of r - F %.6f N\n", bump, rms);
    TEST_ASSERT_TRUE(bump < 1e-3);
    TEST_ASSERT_TRUE(rms < 0.0015); // 0.00107 with the true breakaway, 0.00386 without compensation
    rig_close(&rig);
}

/// The paper's arm creeps at less than L in a slope of 0.02 N/s: what is learned is the friction that it has there.
static void test_friction_of_the_slides_is_learned_within_5_percent_where_the_arm_creeps(void)
{
    for (int i = 0; i < 4; i++)
    {
        const learned_t is = run(beliefs[i % 2], gains[i / 2], true, NULL);
        check_within_5_percent(is.slid_up, is.up);
        check_within_5_percent(is.slid_down, is.down);
        rig_close(&rig);
    }
}

#include "runners/test_learning_alone.inc" // main
