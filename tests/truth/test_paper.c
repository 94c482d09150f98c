// The paper's model and its variants. Fixed steps and relays: also tests/closed_loop/test_open_loop.c.

#include "plant/truth/paper.h"
#include "rig.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/// The model without some of its parts: the five steps of the paper's section 3 and the lines of Figs. 2 to 8.
typedef struct
{
    const char            *name;
    double                 k_min, k_max;
    sim_paper_parameters_t parameters;
} variant_t;

static const variant_t variants[] = {
    {"unlimited", 6.0, 20.0, {0, SIM_PAPER_CURVE_NEVER}},     // step 1 of section 3: f = n
    {"saturation", 6.0, 20.0, {1, SIM_PAPER_CURVE_NEVER}},    // step 2, Eq. (11), Fig. 7 thin
    {"always_k6", 6.0, 6.0, {1, SIM_PAPER_CURVE_ALWAYS}},     // step 3 with k = 6: always on the curve
    {"constant_k6", 6.0, 6.0, {1, SIM_PAPER_CURVE_RELAYS}},   // step 4 with k = 6, Fig. 7 dotted
    {"constant_k1.1", 1.1, 1.1, {1, SIM_PAPER_CURVE_RELAYS}}, // step 4 with k = 1.1, Fig. 4(a)
    {"no_relays", 6.0, 20.0, {1, SIM_PAPER_CURVE_RISING}},    // k(v), Q = v > 0, Fig. 6 dotted
    {"full", 6.0, 20.0, {1, SIM_PAPER_CURVE_RELAYS}},         // step 5, Eqs. (3) to (9), solid in Figs. 6 to 8
};

#define VARIANTS (sizeof variants / sizeof variants[0])

static rig_t rig;

void setUp(void)
{
    rig_init(&rig, &sim_paper_truth);
}

static void apply(const variant_t *variant)
{
    rig.config.friction.k_min = variant->k_min;
    rig.config.friction.k_max = variant->k_max;
    rig.config.own            = &variant->parameters;
}

static void become(const char *name)
{
    size_t i = 0;
    while (i < VARIANTS && strcmp(variants[i].name, name) != 0)
    {
        i++;
    }
    TEST_ASSERT_TRUE_MESSAGE(i < VARIANTS, name);
    apply(&variants[i]);
}

static void test_step_1_of_section_3_does_not_feel_the_drive(void)
{
    // I w' + b w = 0: an arm at rest stays at rest for any u.
    const rig_ramp_t ramps[] = {{0.6, 1.0}};
    double           force;
    become("unlimited");
    rig_forces(&rig, ramps, 1, &force);
    TEST_ASSERT_TRUE(force == 0.0);
}

static void test_saturation_alone_is_sharp(void)
{
    become("saturation");
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, rig_lift(&rig, 0.12, 1.0));
}

static void test_without_switching_the_transition_is_gradual_from_anywhere(void)
{
    become("always_k6");
    TEST_ASSERT_TRUE(rig_lift(&rig, 0.12, 1.0) > 1e-3);
    TEST_ASSERT_TRUE(rig_lift(&rig, 0.42, 1.0) > 1e-3);
}

static void test_without_relays_the_transition_is_gradual_from_deep_and_shallow(void)
{
    become("no_relays");
    TEST_ASSERT_TRUE(rig_lift(&rig, 0.12, 1.0) > 1e-3);
    TEST_ASSERT_TRUE(rig_lift(&rig, 0.42, 1.0) > 1e-3);
}

static void test_with_relays_it_is_gradual_from_deep_and_sharp_from_shallow(void)
{
    become("full");
    TEST_ASSERT_TRUE(rig_lift(&rig, 0.12, 1.0) > 1e-3);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, rig_lift(&rig, 0.42, 1.0));
}

static void test_constant_k_lifts_the_force_more_the_slower_it_is_and_k_of_v_hardly(void)
{
    become("constant_k6");
    const double constant_fast = rig_lift(&rig, 0.12, 2.0);
    const double constant_slow = rig_lift(&rig, 0.12, 20.0);
    become("full");
    const double full_fast = rig_lift(&rig, 0.12, 2.0);
    const double full_slow = rig_lift(&rig, 0.12, 20.0);
    printf("2 and 20 s: k = 6 %.4f, %.4f N; k(v) %.4f, %.4f N\n", constant_fast, constant_slow, full_fast, full_slow);
    TEST_ASSERT_TRUE(constant_slow > 3.0 * constant_fast);
    TEST_ASSERT_TRUE(full_slow < 2.0 * full_fast);
}

static void test_a_smaller_k_has_a_wider_gap(void)
{
    become("constant_k6");
    const double narrow = rig_lift(&rig, 0.12, 1.0);
    become("constant_k1.1");
    TEST_ASSERT_TRUE(rig_lift(&rig, 0.12, 1.0) > 2.0 * narrow);
}

static void test_every_variant_agrees_with_cvode(void)
{
    for (size_t i = 0; i < VARIANTS; i++)
    {
        apply(&variants[i]);
        if (variants[i].parameters.limited == 0)
        {
            continue; // never moves
        }
        const rig_comparison_t comparison = rig_compare(&rig, RIG_STEP_S, rig_compare_ramps, rig_compare_count, NULL);
        printf("%-14s %.4f %% at %.3f s\n", variants[i].name, 100.0 * comparison.difference, comparison.at_s);
        TEST_ASSERT_TRUE_MESSAGE(comparison.difference <= 0.01, variants[i].name);
    }
}

/// At 0.01 N/s v is held at 0, F' = u': the fixed steps chatter around it, CVODE follows Filippov's solution.
static void test_a_rise_too_slow_for_the_curve_agrees_with_cvode(void)
{
    const rig_ramp_t       ramps[]    = {{0.5, 1.0}, {0.12, 1.0}, {0.25, 13.0}, {0.15, 10.0}};
    cvode_cost_t           cost       = {0};
    const rig_comparison_t comparison = rig_compare(&rig, RIG_STEP_S, ramps, sizeof ramps / sizeof ramps[0], &cost);
    printf("0.01 N/s: %.4f %% at %.3f s, %ld events\n", 100.0 * comparison.difference, comparison.at_s, cost.events);
    TEST_ASSERT_TRUE(comparison.difference <= 0.01);
    TEST_ASSERT_TRUE(cost.events < 100);
}

#include "runners/test_paper.inc" // main
