// Every truth model by the plant's fixed steps against its own equations by CVODE, to 1 % of force.

#include "rig.h"
#include "unity.h"

#include <stdio.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_every_model_agrees_with_cvode_to_1_percent_of_force(void)
{
    for (size_t i = 0; i < sim_truth_count; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truths[i]);
        sim_reference_cost_t   cost       = {0};
        const rig_comparison_t comparison = rig_compare(&rig, RIG_STEP_S, rig_compare_ramps, rig_compare_count, &cost);
        printf("%-20s %.4f %% of %.3f N, at %.3f s (CVODE: %ld steps, %ld right-hand sides, %ld events)\n",
               rig.truth->name,
               100.0 * comparison.difference,
               comparison.largest_n,
               comparison.at_s,
               cost.steps,
               cost.right_hand_sides,
               cost.events);
        fflush(stdout);
        TEST_ASSERT_TRUE_MESSAGE(comparison.difference <= 0.01, rig.truth->name);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_model_agrees_with_cvode_to_1_percent_of_force);
    return UNITY_END();
}
