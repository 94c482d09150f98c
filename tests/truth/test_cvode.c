// Every truth model: the plant's fixed steps against its equations by CVODE, to 1 % of force.

#include "rig.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

static void compare(const rig_t *rig, const rig_ramp_t *ramps, unsigned count)
{
    cvode_cost_t           cost       = {0};
    const rig_comparison_t comparison = rig_compare(rig, RIG_STEP_S, ramps, count, &cost);
    printf("%-16s %7.4f %% of %.3f N, at %6.3f s (CVODE: %ld steps, %ld right-hand sides, %ld events)\n",
           rig->truth->name,
           100.0 * comparison.difference,
           comparison.largest_n,
           comparison.at_s,
           cost.steps,
           cost.right_hand_sides,
           cost.events);
    TEST_ASSERT_TRUE_MESSAGE(comparison.difference <= 0.01, rig->truth->name);
}

static void test_every_model_agrees_with_cvode_to_1_percent_of_force(void)
{
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        compare(&rig, rig_compare_ramps, rig_compare_count);
    }
}

/// 0.01 N/s, as slow as the paper's waveforms.
static void test_every_model_agrees_on_slow_ramps(void)
{
    static const rig_ramp_t ramps[] = {{0.5, 1.0}, {0.12, 1.0}, {0.27, 15.0}, {0.17, 10.0}};
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        compare(&rig, ramps, sizeof ramps / sizeof ramps[0]);
    }
}

/// 0.5 N within 5 ms, as after steps of the reference.
static void test_every_model_agrees_on_jumps(void)
{
    static const rig_ramp_t ramps[] =
        {{0.5, 0.005}, {0.5, 0.195}, {0.1, 0.005}, {0.1, 0.195}, {0.45, 0.005}, {0.45, 0.195}};
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        compare(&rig, ramps, sizeof ramps / sizeof ramps[0]);
    }
}

/// Unequal directions, gravity, breakaway from a table.
static void test_every_model_agrees_with_asymmetry_gravity_and_a_table(void)
{
    static common_breakaway_point_t points[] = {{0.0, 0.010, 0.005}, {0.2, 0.060, 0.080}, {0.5, 0.150, 0.170}};
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        memcpy(rig.config.friction.breakaway.table, points, sizeof points);
        rig.config.friction.breakaway.table_count = 3;
        rig.config.friction.gravity_n             = 0.004;
        compare(&rig, rig_compare_ramps, rig_compare_count);
    }
}

/// Sliding friction below breakaway, where a model has that parameter.
static void test_models_with_a_stribeck_effect_agree(void)
{
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        if (rig_has(&rig, "sliding_ratio"))
        {
            rig_set(&rig, "sliding_ratio", 0.9);
            compare(&rig, rig_compare_ramps, rig_compare_count);
        }
    }
}

/// A value other than the default: 0.8 of it, 0.05 for 0; another word of a choice.
static double other_value(const common_key_t *key)
{
    switch (key->type)
    {
    case COMMON_KEY_CHOICE:
        return key->standard == 0.0 ? 1.0 : key->standard - 1.0;
    case COMMON_KEY_WHOLE:
        return key->standard + 1.0;
    default:
        return key->standard == 0.0 ? 0.05 : 0.8 * key->standard;
    }
}

/// Both forms of a law must use each parameter in the same way.
static void test_every_parameter_agrees(void)
{
    static const rig_ramp_t ramps[] = {{0.5, 0.4}, {0.5, 0.1}, {0.1, 0.2}, {0.45, 0.005}, {0.45, 0.1}, {-0.2, 0.3}};
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        for (const common_key_t *key = sim_truth_models[i]->keys; key != NULL && key->name != NULL; key++)
        {
            rig_t rig;
            rig_init(&rig, sim_truth_models[i]);
            rig_set(&rig, key->name, other_value(key));
            printf("%s %g: ", key->name, other_value(key));
            compare(&rig, ramps, sizeof ramps / sizeof ramps[0]);
        }
    }
}

static void keep_last(void *context, const rig_sample_t *sample)
{
    *(double *)context = sample->force_n;
}

static void test_both_of_cvodes_methods_give_the_same(void)
{
    const rig_ramp_t ramps[]  = {{0.5, 0.5}, {0.1, 0.5}};
    cvode_options_t  options  = cvode_defaults;
    double           stiff    = 0.0;
    double           nonstiff = 0.0;
    rig_t            rig;
    rig_init(&rig, &sim_paper_truth);
    rig_run_reference(&rig, &options, 1e-3, ramps, 2, keep_last, &stiff, NULL);
    options.adams      = true;
    options.max_step_s = 1e-3;
    rig_run_reference(&rig, &options, 1e-3, ramps, 2, keep_last, &nonstiff, NULL);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, stiff, nonstiff);
    TEST_ASSERT_TRUE(stiff > 0.1);
}

#include "runners/test_cvode.inc" // main
