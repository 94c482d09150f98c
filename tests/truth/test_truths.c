// The list of truth models: names, rows of parameters, and the duties of every model.

#include "rig.h"
#include "scenario/config.h"
#include "scenario/keys.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static common_scenario_t *scenario;

void setUp(void)
{
    scenario = sim_scenario_create();
    TEST_ASSERT_NOT_NULL(scenario);
}

void tearDown(void)
{
    common_scenario_destroy(scenario);
}

static void test_a_scenario_chooses_each_model_by_its_own_name(void)
{
    TEST_ASSERT_EQUAL_PTR(&sim_paper_truth, sim_truth_models[sim_scenario_config(scenario)->plant.model]);
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        char           assignment[64];
        common_error_t error;
        (void)snprintf(assignment, sizeof assignment, "plant.model=%s", sim_truth_models[i]->name);
        TEST_ASSERT_TRUE_MESSAGE(common_scenario_set(scenario, assignment, &error), assignment);
        TEST_ASSERT_EQUAL_size_t(i, sim_scenario_config(scenario)->plant.model);
    }
}

static size_t size_of(const common_key_t *key)
{
    switch (key->type)
    {
    case COMMON_KEY_NUMBER:
        return sizeof(double);
    case COMMON_KEY_WHOLE:
        return sizeof(uint64_t);
    case COMMON_KEY_CHOICE:
        return sizeof(int);
    default:
        TEST_FAIL_MESSAGE(key->name);
        return 0;
    }
}

static void check_row(const common_key_t *row, bool used[])
{
    const bool is_number = row->type != COMMON_KEY_CHOICE;
    TEST_ASSERT_TRUE_MESSAGE(strlen(row->text) > 0 && strlen(row->unit) > 0, row->name);
    TEST_ASSERT_TRUE_MESSAGE(!is_number || row->min < row->max, row->name);
    TEST_ASSERT_TRUE_MESSAGE(!is_number || (row->standard >= row->min && row->standard <= row->max), row->name);
    for (size_t byte = row->offset; byte < row->offset + size_of(row); byte++)
    {
        TEST_ASSERT_TRUE_MESSAGE(byte < sizeof(double[SIM_TRUTH_DOUBLES_MAX]), row->name);
        TEST_ASSERT_FALSE_MESSAGE(used[byte], row->name);
        used[byte] = true;
    }
}

/// Rows are unique and do not overlap in the struct.
static void test_rows_of_parameters_are_sound(void)
{
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        const sim_truth_ops_t *truth                                       = sim_truth_models[i];
        bool                   used[sizeof(double[SIM_TRUTH_DOUBLES_MAX])] = {false};
        for (const common_key_t *row = truth->keys; row != NULL && row->name != NULL; row++)
        {
            TEST_ASSERT_EQUAL_PTR_MESSAGE(row, common_key_in(truth->keys, row->name, strlen(row->name)), row->name);
            check_row(row, used);
        }
    }
}

/// Scenarios and the other tests of this folder start from the same defaults.
static void test_a_scenarios_defaults_are_those_of_the_rows(void)
{
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(sim_scenario_config(scenario)->plant.own[i],
                                         rig.own,
                                         sizeof rig.own,
                                         rig.truth->name);
    }
}

/// A rise in 6 s: each model slides with about the arm's friction at that force, so that they are comparable.
static void test_all_models_slide_with_breakaway_of_the_load(void)
{
    static const rig_ramp_t ramps[] = {{0.6, 6.0}};
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        double force;
        rig_forces(&rig, ramps, 1, &force);
        printf("%-18s F %.4f N, u - F %.4f N, L(F) %.4f N\n", rig.truth->name, force, 0.6 - force, 0.007 + 0.3 * force);
        if (strncmp(rig.truth->name, "servo_", 6) != 0)
        {
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.12 * (0.6 - force), 0.007 + 0.3 * force, 0.6 - force, rig.truth->name);
        }
    }
}

static double noisy(unsigned long i)
{
    // A multiplicative generator; the amplitude goes up to 100 N.
    const unsigned long x = (i * 2654435761ul + 12345ul) & 0xffffffffu;
    return ((double)x / 2147483648.0 - 1.0) * (i % 1000 < 900 ? 1.0 : 100.0);
}

static void test_no_input_makes_a_model_diverge(void)
{
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        const sim_truth_ops_t *truth = rig.truth;
        void                  *model = truth->create(&rig.config, RIG_STEP_S);
        TEST_ASSERT_NOT_NULL(model);
        sim_truth_signals_t signals = {0};
        for (unsigned long k = 0; k < 20000; k++)
        {
            const double force = truth->step(model, noisy(k), &signals);
            TEST_ASSERT_TRUE_MESSAGE(fabs(force) < 200.0 && isfinite(signals.f_n), truth->name);
        }
        truth->destroy(model);
    }
}

/// With equal directions a mirrored input gives the mirrored force, to the last bit. Bristles are random.
static void test_models_are_mirror_images_of_themselves(void)
{
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        const sim_truth_ops_t *truth = rig.truth;
        if (strcmp(truth->name, "bristle") == 0)
        {
            continue;
        }
        void               *model   = truth->create(&rig.config, RIG_STEP_S);
        void               *mirror  = truth->create(&rig.config, RIG_STEP_S);
        sim_truth_signals_t signals = {0};
        for (unsigned long k = 1; k < 20000; k++)
        {
            const double u = 0.4 * sin(0.003 * (double)k) + 0.1 * sin(0.05 * (double)k);
            TEST_ASSERT_TRUE_MESSAGE(truth->step(model, u, &signals) == -truth->step(mirror, -u, &signals),
                                     truth->name);
        }
        truth->destroy(model);
        truth->destroy(mirror);
    }
}

#include "runners/test_truths.inc" // main
