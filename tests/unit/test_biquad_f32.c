// What only the f32 arithmetic has. What both promise: tests/contract/test_biquad.c.

#include "cascade_f32.h"
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static tribo_biquad_f32_params_t params;
static tribo_biquad_f32_state_t  state;

void setUp(void)
{
    tribo_biquad_f32_reset(&state);
}

static void init(const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&params, sections, count, NULL));
}

// 0.002 rad/s at 1 kHz, beside a pole at 340 rad/s. In direct form the two float coefficients would move it by percents.
static void test_biquad_keeps_a_slow_pole_to_1e_6_of_its_time_constant(void)
{
    const double                     slow = 2e-6, fast = 0.29; // 1 - p
    const tribo_biquad_f32_section_t section[] = {
        {1.0f, 0.0f, 0.0f, (float)(slow + fast), (float)(slow * fast)},
    };
    init(section, 1);
    (void)cascade_f32_step(&params, &state, 1.0f);
    float early = 0.0f;
    float late  = 0.0f;
    for (int k = 1; k <= RUNS(600000, 150000); k++)
    {
        const float y = cascade_f32_step(&params, &state, 0.0f);
        early         = k == 100000 ? y : early;
        late          = y;
    }
    const double rate = -log((double)late / (double)early) / RUNS(500000.0, 50000.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, rate / -log1p(-slow));
}

static void test_biquad_integrates_what_is_far_below_its_last_digit(void)
{
    const tribo_biquad_f32_section_t integrator[] = {TRIBO_BIQUAD_F32(0.0, 1.0, 0.0, -1.0, 0.0)};
    // d^2 + d: the pole at z = 1 and its pad at z = 0
    init(integrator, 1);
    (void)cascade_f32_step(&params, &state, 1.0f);
    float y = 0.0f;
    for (int k = 0; k < RUNS(1000000, 100000); k++)
    {
        y = cascade_f32_step(&params, &state, 1e-9f);
    }
    TEST_ASSERT_FLOAT_WITHIN(2e-7f, RUNS(1.001f, 1.0001f), y);
}

// --- change of params --------------------------------------------------------------------------------------------

static void test_biquad_change_to_the_same_params_changes_nothing(void)
{
    const tribo_biquad_f32_section_t sections[] = {TRIBO_BIQUAD_F32(0.25, -0.3, 0.2, -1.2, 0.72),
                                                   TRIBO_BIQUAD_F32(1.5, -1.0, 0.1, -0.9, 0.1)};
    init(sections, 2);
    for (int k = 0; k < 50; k++)
    {
        (void)cascade_f32_step(&params, &state, (float)sin(k * 0.1));
    }
    state.section[0].w2_carry = 1.0e-3f; // as if much had been rounded off: it must not get lost
    state.section[0].w2 -= 1.0e-3f;
    tribo_biquad_f32_state_t plain = state;
    plain.section[0].w2 += 1.0e-3f;
    plain.section[0].w2_carry = 0.0f;
    tribo_biquad_f32_change(&params, &params, &state, 0.7f, 0.0f);
    for (int k = 0; k < 200; k++)
    {
        const float x = (float)cos(k * 0.1);
        TEST_ASSERT_FLOAT_WITHIN(2e-6f, cascade_f32_step(&params, &plain, x), cascade_f32_step(&params, &state, x));
    }
}

static void test_biquad_restart_puts_the_cascade_to_rest_and_is_counted(void)
{
    const tribo_biquad_f32_section_t sections[] = {TRIBO_BIQUAD_F32(0.25, -0.3, 0.2, -1.2, 0.72),
                                                   TRIBO_BIQUAD_F32(1.5, -1.0, 0.1, -0.9, 0.1),
                                                   TRIBO_BIQUAD_F32(1.0, 0.2, 0.1, -0.4, 0.1),
                                                   TRIBO_BIQUAD_F32(1.0, 0.1, 0.1, -0.2, 0.1)};
    tribo_biquad_f32_state_t         rest;
    init(sections, 4);
    (void)cascade_f32_step(&params, &state, NAN);
    tribo_biquad_f32_reset(&rest);
    biquad_f32_restart(&state);
    TEST_ASSERT_EQUAL_MEMORY(rest.section, state.section, sizeof rest.section); // what was carried is gone as well
    TEST_ASSERT_EQUAL_UINT32(1, state.bad_inputs);
    state.bad_inputs = UINT32_MAX;
    biquad_f32_restart(&state);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, state.bad_inputs);
}

// --- set-up ------------------------------------------------------------------------------------------------------

static void check_refused(tribo_status_t status, const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    tribo_biquad_f32_params_t out;
    memset(&out, 0xa5, sizeof out);
    TEST_ASSERT_EQUAL_INT(status, tribo_biquad_f32_init(&out, sections, count, NULL));
    TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out, sizeof out);
}

static void test_biquad_init_accepts_exactly_the_stable_sections(void)
{
    const uint64_t seed     = 1987;
    random_t       r        = {seed};
    int            accepted = 0;
    printf("seed %llu\n", (unsigned long long)seed);
    for (int i = 0; i < 20000; i++)
    {
        const float  a1   = (float)random_between(&r, -0.5, 4.5);
        const float  a2   = (float)random_between(&r, -0.5, 4.5);
        const double disc = (double)a1 * (double)a1 / 4.0 - (double)a2;
        // Roots of d^2 + a1 d + a2, then z = 1 + d.
        const double radius =
            disc >= 0.0 ? fmax(fabs(1.0 - (double)a1 / 2.0 + sqrt(disc)), fabs(1.0 - (double)a1 / 2.0 - sqrt(disc)))
                        : hypot(1.0 - (double)a1 / 2.0, sqrt(-disc));
        if (fabs(radius - 1.0) < 1e-6)
        {
            continue;
        }
        const tribo_biquad_f32_section_t section = {1.0f, 0.0f, 0.0f, a1, a2};
        if (radius < 1.0)
        {
            TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&params, &section, 1, NULL));
            accepted++;
        }
        else
        {
            const bool in_range = a1 <= 4.0f && a2 <= 4.0f;
            check_refused(in_range ? TRIBO_ERR_SECTION_UNSTABLE : TRIBO_ERR_SECTION_COEFFICIENT, &section, 1);
        }
    }
    TEST_ASSERT_TRUE(accepted > 1000);
    const tribo_biquad_f32_section_t integrator = {1.0f, 0.0f, 0.0f, 0.5f, 0.0f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&params, &integrator, 1, NULL));
    const tribo_biquad_f32_section_t twice = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    check_refused(TRIBO_ERR_SECTION_UNSTABLE, &twice, 1);
    const tribo_biquad_f32_section_t alternating = {1.0f, 0.0f, 0.0f, 2.0f, 0.0f}; // a pole at z = -1
    check_refused(TRIBO_ERR_SECTION_UNSTABLE, &alternating, 1);
}

static void test_biquad_init_checks_count_pointers_and_coefficients(void)
{
    tribo_biquad_f32_section_t sections[TRIBO_BIQUAD_SECTIONS_MAX + 1u];
    for (size_t i = 0; i <= TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        sections[i] = (tribo_biquad_f32_section_t)TRIBO_BIQUAD_F32(1.0, 0.0, 0.0, 0.0, 0.0);
    }
    check_refused(TRIBO_ERR_SECTION_COUNT, sections, 0);
    check_refused(TRIBO_ERR_SECTION_COUNT, sections, TRIBO_BIQUAD_SECTIONS_MAX + 1u);
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_biquad_f32_init(NULL, sections, 1, NULL));
    check_refused(TRIBO_ERR_NULL, NULL, 1);

    const float bad[] = {NAN, INFINITY, -INFINITY, 1.001e6f, -1.001e6f};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        float *const fields[] = {&sections[2].b0, &sections[2].b1, &sections[2].b2, &sections[2].a1, &sections[2].a2};
        for (size_t j = 0; j < sizeof fields / sizeof fields[0]; j++)
        {
            const float good = *fields[j];
            *fields[j]       = bad[i];
            check_refused(TRIBO_ERR_SECTION_COEFFICIENT, sections, 3);
            TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&params, sections, 2, NULL));
            *fields[j] = good;
        }
    }
    sections[0].b0 = 1.0e6f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&params, sections, 4, NULL));
}

#include "runners/test_biquad_f32.inc" // main
