// Load-dependent servo model: the published coefficients, scaled to the arm's base, set breakaway with the load.

#include "rig.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

static rig_t rig;

typedef struct
{
    const sim_truth_ops_t *truth;
    double                 base, load; ///< as published
} row_t;

static const row_t rows[] = {{&sim_servo_mx106_truth, 0.1134, 0.108},
                             {&sim_servo_mx64_truth, 0.1022, 0.0758},
                             {&sim_servo_xl330_truth, 0.00888, 0.1217},
                             {&sim_servo_erob80_truth, 4.83, 0.148}};

/// u - F at which the arm moves up from F: 0.007 + load (u + F).
static void test_breakaway_is_the_base_and_a_part_of_the_load(void)
{
    for (unsigned i = 0; i < 4; i++)
    {
        rig_init(&rig, rows[i].truth);
        TEST_ASSERT_EQUAL_DOUBLE(rows[i].base, rig.own[0]);
        TEST_ASSERT_EQUAL_DOUBLE(rows[i].load, rig.own[1]);
        rig_ramp_t ramps[] = {{0.6, 3.0}, {0.0, 0.5}, {0.0, 1.0}};
        double     forces[3];
        rig_forces(&rig, ramps, 1, forces);
        const double force = forces[0];
        const double up    = (0.007 + 2.0 * rows[i].load * force) / (1.0 - rows[i].load);
        const double down  = (0.007 + 2.0 * rows[i].load * force) / (1.0 + rows[i].load);
        printf("%s: at %.3f N %.4f up, %.4f N down\n", rows[i].truth->name, force, up, down);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.6, force + up);

        // It stands just short of breakaway downwards, and moves beyond it.
        ramps[1].to_n = force - 0.97 * down;
        rig_forces(&rig, ramps, 2, forces);
        const double stood = forces[1];
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, force, stood);
        ramps[1].to_n = force - 1.1 * down;
        rig_forces(&rig, ramps, 2, forces);
        TEST_ASSERT_TRUE(forces[1] < stood - 0.02 * down);
    }
}

static void test_it_stands_to_the_last_bit_inside_breakaway(void)
{
    rig_init(&rig, &sim_servo_mx106_truth);
    TEST_ASSERT_TRUE(rig_drift(&rig, 0.1) == 0.0);
}

static void test_the_scale_makes_newtons_of_newton_metres(void)
{
    rig_init(&rig, &sim_servo_mx106_truth);
    rig_set(&rig, "load", 0.0);
    rig_set(&rig, "scale_N_per_N_m", 0.5);
    const rig_ramp_t ramps[] = {{0.3, 30.0}};
    double           force;
    rig_forces(&rig, ramps, 1, &force);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.3 - 0.5 * 0.1134 - 0.0288 * 0.01 / 3.84, force);
}

#include "runners/test_servo.inc" // main
