#include "tribo/controller_f32.h"
#include "tribo/paper_controller.h"

#include "cascade_f32.h"
#include "random.h"
#include "runs.h"
#include "same.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const tribo_biquad_f32_section_t paper[] = TRIBO_PAPER_CONTROLLER_F32;
static const tribo_biquad_f32_section_t pi[]    = {TRIBO_BIQUAD_F32(2.0, -1.9, 0.0, -1.0, 0.0)};
// A zero outside the unit circle: D > 0, K(1) < 0.
static const tribo_biquad_f32_section_t zero_outside[] = {TRIBO_BIQUAD_F32(1.0, -1.2, 0.0, -0.99, 0.0)};

// A zero beyond z = -1.
static const tribo_biquad_f32_section_t zero_behind[] = {TRIBO_BIQUAD_F32(1.0, 1.5, 0.0, -0.9, 0.0)};

static tribo_controller_f32_config_t  config;
static tribo_controller_f32_params_t  params;
static tribo_controller_f32_state_t   state;
static tribo_controller_f32_signals_t seen;

static void init(const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    config = (tribo_controller_f32_config_t){.sections      = sections,
                                             .section_count = count,
                                             .u_min_n       = -0.5f,
                                             .u_max_n       = 1.0f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_f32_init(&params, &config));
    tribo_controller_f32_reset(&state);
}

void setUp(void)
{
    init(paper, 2);
}

static float step(float e, float feedforward)
{
    return controller_f32_step(&params, &state, e, feedforward, &seen);
}

static void test_controller_takes_the_largest_stable_conditioning(void)
{
    init(paper, 2);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f / (paper[0].b0 * paper[1].b0), params.anti_windup);
    init(pi, 1);
    TEST_ASSERT_SAME_FLOAT(0.5f, params.anti_windup);
    // (1 - c)(z - 0.99) + c (z - 1.2): its root 0.99 + 0.21 c is inside for c < 0.0476, and for c > -9.5
    init(zero_outside, 1);
    TEST_ASSERT_SAME_FLOAT(-1.0f, params.anti_windup);
    // 0.9 - 2.4 c: inside for -0.04 < c < 0.79
    init(zero_behind, 1);
    TEST_ASSERT_SAME_FLOAT(0.5f, params.anti_windup);
}

/// Largest root magnitude of (1 - c) A + c B/D, by the conditioned cascade's own decay in double.
static double conditioned_radius(const tribo_biquad_f32_section_t *s, uint32_t count, double anti_windup)
{
    double w1[TRIBO_BIQUAD_SECTIONS_MAX], w2[TRIBO_BIQUAD_SECTIONS_MAX];
    for (uint32_t i = 0; i < count; i++)
    {
        w1[i] = 1.0 / (i + 1.0);
        w2[i] = 0.3;
    }
    double log_norm = 0.0;
    for (int k = 0; k < 2000; k++)
    {
        double v = 0.0;
        for (uint32_t i = 0; i < count; i++)
        {
            v = (double)s[i].b0 * v + w1[i];
        }
        double in   = -anti_windup * v;
        double norm = 0.0;
        for (uint32_t i = 0; i < count; i++)
        {
            const double out = (double)s[i].b0 * in + w1[i];
            w1[i] += (double)s[i].b1 * in - (double)s[i].a1 * out + w2[i];
            w2[i] += (double)s[i].b2 * in - (double)s[i].a2 * out;
            in = out;
            norm += fabs(w1[i]) + fabs(w2[i]);
        }
        for (uint32_t i = 0; i < count; i++)
        {
            w1[i] /= norm;
            w2[i] /= norm;
        }
        log_norm += k >= 1000 ? log(norm) : 0.0;
    }
    return exp(log_norm / 1000.0);
}

static tribo_biquad_f32_section_t random_section(random_t *r)
{
    // Poles inside the unit circle; zeros anywhere within 1.5.
    const double p     = random_between(r, 0.0, 0.98);
    const double angle = random_between(r, 0.0, 3.1);
    const double q     = random_between(r, 0.0, 1.5);
    const double turn  = random_between(r, 0.0, 3.1);
    const double b0    = random_between(r, 0.1, 3.0);
    return (tribo_biquad_f32_section_t)
        TRIBO_BIQUAD_F32(b0, b0 * -2.0 * q * cos(turn), b0 * q * q, -2.0 * p * cos(angle), p * p);
}

static void test_controller_keeps_a_conditioning_only_while_it_is_stable(void)
{
    float c = 0.5f;
    init(pi, 1); // (1 - c)(z - 1) + c (z - 0.95): its root 1 - 0.05 c
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_f32_prepare(&params, &config, &c));
    TEST_ASSERT_SAME_FLOAT(0.25f, params.anti_windup);
    TEST_ASSERT_SAME_FLOAT(0.5f, c);
    c = -1.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_f32_prepare(&params, &config, &c));
    TEST_ASSERT_SAME_FLOAT(0.5f, params.anti_windup);
    TEST_ASSERT_SAME_FLOAT(1.0f, c);
}

static void test_controller_finds_an_anti_windup_for_any_stable_cascade(void)
{
    const uint64_t seed   = 23;
    random_t       r      = {seed};
    int            full   = 0;
    int            partly = 0;
    printf("seed %llu\n", (unsigned long long)seed);
    for (int i = 0; i < RUNS(200, 30); i++)
    {
        tribo_biquad_f32_section_t sections[TRIBO_BIQUAD_SECTIONS_MAX];
        const uint32_t             count = 1u + (uint32_t)(random_bits(&r) % TRIBO_BIQUAD_SECTIONS_MAX);
        double                     D     = 1.0;
        for (uint32_t j = 0; j < count; j++)
        {
            sections[j] = random_section(&r);
            D *= (double)sections[j].b0;
        }
        init(sections, count);
        TEST_ASSERT_TRUE(conditioned_radius(sections, count, (double)params.anti_windup) < 1.0);
        const bool is_full = fabs((double)params.anti_windup * D - 1.0) < 1e-3;
        full += is_full;
        partly += !is_full;
    }
    TEST_ASSERT_TRUE(full > RUNS(20, 3));
    TEST_ASSERT_TRUE(partly > RUNS(20, 3));
}

static void test_controller_change_takes_bad_numbers_for_zero(void)
{
    (void)step(0.1f, 0.0f);
    tribo_controller_f32_state_t zeros = state;
    tribo_biquad_f32_change(&params.cascade, &params.cascade, &zeros.cascade, 0.0f, 0.0f);
    tribo_biquad_f32_change(&params.cascade, &params.cascade, &state.cascade, NAN, INFINITY);
    TEST_ASSERT_EQUAL_MEMORY(&zeros, &state, sizeof state);
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_controller_starts_again_when_its_state_is_lost(void)
{
    const tribo_biquad_f32_section_t first[] = {TRIBO_BIQUAD_F32(2.0, -1.9, 0.0, -1.0, 0.0)};
    const float                      lost[]  = {NAN, INFINITY, -INFINITY, 3.0e15f, -3.0e15f};
    for (uint32_t count = 1; count <= 2u; count++)
    {
        init(count == 1u ? first : paper, count);
        for (uint32_t i = 0; i < sizeof lost / sizeof lost[0]; i++)
        {
            tribo_controller_f32_reset(&state);
            state.cascade.section[0].w1 = lost[i];
            TEST_ASSERT_SAME_FLOAT(0.3f, step(0.1f, 0.3f));
            TEST_ASSERT_FALSE(seen.limited);
            TEST_ASSERT_SAME_FLOAT(0.0f, seen.v_n);
            TEST_ASSERT_EQUAL_UINT32(1, state.cascade.bad_inputs);
            tribo_controller_f32_state_t rest;
            tribo_controller_f32_reset(&rest);
            TEST_ASSERT_EQUAL_MEMORY(rest.cascade.section, state.cascade.section, sizeof rest.cascade.section);
            const float u = step(0.01f, 0.3f);
            tribo_controller_f32_reset(&state);
            TEST_ASSERT_SAME_FLOAT(step(0.01f, 0.3f), u);
        }
        state.cascade.section[0].w1 = NAN;
        TEST_ASSERT_SAME_FLOAT(1.0f, step(0.1f, 2.0f));
        TEST_ASSERT_TRUE(seen.limited);
        TEST_ASSERT_SAME_FLOAT(1.0f, seen.u_n);
        state.cascade.section[0].w1 = NAN;
        TEST_ASSERT_SAME_FLOAT(-0.5f, step(0.1f, -2.0f));
        TEST_ASSERT_TRUE(seen.limited);
    }
}

static void test_controller_reset_clears_its_counters(void)
{
    memset(&state, 0x5a, sizeof state);
    tribo_controller_f32_reset(&state);
    TEST_ASSERT_EQUAL_UINT32(0, state.limited_ticks);
    TEST_ASSERT_EQUAL_UINT32(0, state.cascade.bad_inputs);
}

// --- set-up ------------------------------------------------------------------------------------------------------

static void check_refused(tribo_status_t status)
{
    tribo_controller_f32_params_t out;
    memset(&out, 0xa5, sizeof out);
    TEST_ASSERT_EQUAL_INT(status, tribo_controller_f32_init(&out, &config));
    TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out, sizeof out);
}

static void test_controller_init_checks_every_field(void)
{
    const tribo_controller_f32_config_t good = config;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_controller_f32_init(NULL, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_controller_f32_init(&params, NULL));
    config.sections = NULL;
    check_refused(TRIBO_ERR_NULL);
    config               = good;
    config.section_count = 0;
    check_refused(TRIBO_ERR_SECTION_COUNT);
    config = good;

    const float bad_min[] = {0.01f, -1.01e6f, NAN, -INFINITY};
    const float bad_max[] = {-0.01f, 1.01e6f, NAN, INFINITY};
    for (size_t i = 0; i < 4; i++)
    {
        config.u_min_n = bad_min[i];
        check_refused(TRIBO_ERR_U_MIN);
        config         = good;
        config.u_max_n = bad_max[i];
        check_refused(TRIBO_ERR_U_MAX);
        config = good;
    }
    config.u_min_n = 0.0f;
    config.u_max_n = 0.0f;
    check_refused(TRIBO_ERR_U_MAX);
    config.u_max_n = 1.0e6f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_f32_init(&params, &config));
    config.u_min_n = -1.0e6f;
    config.u_max_n = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_f32_init(&params, &config));
}

static void test_controller_init_refuses_cascades_that_it_cannot_run(void)
{
    const float small[] = {0.0f, 0.9e-6f, -0.9e-6f};
    for (size_t i = 0; i < 3; i++)
    {
        const tribo_biquad_f32_section_t strictly_proper[] = {{small[i], 0.1f, 0.1f, 0.5f, 0.1f}};
        config.sections                                    = strictly_proper;
        config.section_count                               = 1;
        check_refused(TRIBO_ERR_SECTION_FEEDTHROUGH);
    }
    const tribo_biquad_f32_section_t unstable[] = {TRIBO_BIQUAD_F32(1.0, 0.0, 0.0, -1.01, 0.0)};
    config.sections                             = unstable;
    check_refused(TRIBO_ERR_SECTION_UNSTABLE);

    const tribo_biquad_f32_section_t two_integrators_cancelled[] = {TRIBO_BIQUAD_F32(1.0, -1.0, 0.0, -1.0, 0.0)};
    config.sections                                              = two_integrators_cancelled;
    check_refused(TRIBO_ERR_ANTI_WINDUP); // an integrator that its own zero hides from the output
}

#include "runners/test_controller_f32.inc" // main
