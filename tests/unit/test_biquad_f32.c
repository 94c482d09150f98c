#include "tribo/biquad_f32.h"

#include "random.h"
#include "runs.h"
#include "same.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static tribo_biquad_f32_params_t  params;
static tribo_biquad_f32_state_t   state;
static tribo_biquad_f32_outputs_t nodes;

void setUp(void)
{
    tribo_biquad_f32_reset(&state);
}

void tearDown(void)
{
}

/// A section (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2), direct form I in double.
typedef struct
{
    double b0, b1, b2, a1, a2;
    double x1, x2, y1, y2;
} direct_t;

static double direct_step(direct_t *s, double x)
{
    const double y = s->b0 * x + s->b1 * s->x1 + s->b2 * s->x2 - s->a1 * s->y1 - s->a2 * s->y2;
    s->x2          = s->x1;
    s->x1          = x;
    s->y2          = s->y1;
    s->y1          = y;
    return y;
}

static void init(const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&params, sections, count));
}

static void test_biquad_is_the_section_of_its_usual_coefficients(void)
{
    const tribo_biquad_f32_section_t section[] = {TRIBO_BIQUAD_F32(0.25, -0.3, 0.2, -1.2, 0.72)};
    direct_t                         direct    = {.b0 = 0.25, .b1 = -0.3, .b2 = 0.2, .a1 = -1.2, .a2 = 0.72};
    random_t                         r         = {1};
    init(section, 1);
    for (int k = 0; k < 1000; k++)
    {
        const float x = (float)random_between(&r, -1.0, 1.0);
        TEST_ASSERT_DOUBLE_WITHIN(2e-6,
                                  direct_step(&direct, (double)x),
                                  (double)tribo_biquad_f32_step(&params, &state, x));
    }
}

static void test_biquad_cascade_runs_its_sections_in_order(void)
{
    const tribo_biquad_f32_section_t section[] = {TRIBO_BIQUAD_F32(1.0, 0.0, 0.0, -0.5, 0.0),
                                                  TRIBO_BIQUAD_F32(2.0, -1.0, 0.0, 0.0, 0.0),
                                                  TRIBO_BIQUAD_F32(0.5, 0.5, 0.25, 0.0, 0.5),
                                                  TRIBO_BIQUAD_F32(-1.0, 0.0, 0.1, 0.2, 0.0)};
    direct_t                         direct[]  = {{.b0 = 1.0, .a1 = -0.5},
                                                  {.b0 = 2.0, .b1 = -1.0},
                                                  {.b0 = 0.5, .b1 = 0.5, .b2 = 0.25, .a2 = 0.5},
                                                  {.b0 = -1.0, .b2 = 0.1, .a1 = 0.2}};
    init(section, 4);
    random_t r = {2};
    for (int k = 0; k < 1000; k++)
    {
        const float x = (float)random_between(&r, -1.0, 1.0);
        double      y = (double)x;
        for (int i = 0; i < 4; i++)
        {
            y = direct_step(&direct[i], y);
        }
        TEST_ASSERT_DOUBLE_WITHIN(4e-6, y, (double)tribo_biquad_f32_step(&params, &state, x));
    }
}

// 0.002 rad/s at 1 kHz, beside a pole at 340 rad/s. In direct form the two float coefficients would move it by percents.
static void test_biquad_keeps_a_slow_pole_to_1e_6_of_its_time_constant(void)
{
    const double                     slow = 2e-6, fast = 0.29; // 1 - p
    const tribo_biquad_f32_section_t section[] = {
        {1.0f, 0.0f, 0.0f, (float)(slow + fast), (float)(slow * fast)},
    };
    init(section, 1);
    (void)tribo_biquad_f32_step(&params, &state, 1.0f);
    float early = 0.0f;
    float late  = 0.0f;
    for (int k = 1; k <= RUNS(600000, 150000); k++)
    {
        const float y = tribo_biquad_f32_step(&params, &state, 0.0f);
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
    (void)tribo_biquad_f32_step(&params, &state, 1.0f);
    float y = 0.0f;
    for (int k = 0; k < RUNS(1000000, 100000); k++)
    {
        y = tribo_biquad_f32_step(&params, &state, 1e-9f);
    }
    TEST_ASSERT_FLOAT_WITHIN(2e-7f, RUNS(1.001f, 1.0001f), y);
}

static void test_biquad_output_and_advance_are_one_step(void)
{
    const tribo_biquad_f32_section_t section[] = {TRIBO_BIQUAD_F32(0.25, -0.3, 0.2, -1.2, 0.72),
                                                  TRIBO_BIQUAD_F32(2.0, -1.0, 0.0, 0.0, 0.0)};
    tribo_biquad_f32_state_t         apart;
    init(section, 2);
    tribo_biquad_f32_reset(&apart);
    for (int k = 0; k < 100; k++)
    {
        const float x = (float)sin(k * 0.1);
        const float y = tribo_biquad_f32_output(&params, &apart, x, &nodes);
        tribo_biquad_f32_advance(&params, &apart, x, &nodes, 0.0f);
        TEST_ASSERT_SAME_FLOAT(tribo_biquad_f32_step(&params, &state, x), y);
    }
}

static void test_biquad_advances_as_if_the_corrected_input_had_come(void)
{
    const tribo_biquad_f32_section_t section[] = {TRIBO_BIQUAD_F32(0.25, -0.3, 0.2, -1.2, 0.72),
                                                  TRIBO_BIQUAD_F32(2.0, -1.0, 0.0, 0.0, 0.0)};
    tribo_biquad_f32_state_t         corrected;
    init(section, 2);
    tribo_biquad_f32_reset(&corrected);
    for (int k = 0; k < 100; k++)
    {
        const float x          = (float)sin(k * 0.1);
        const float correction = (float)cos(k * 0.07);
        (void)tribo_biquad_f32_output(&params, &corrected, x, &nodes);
        tribo_biquad_f32_advance(&params, &corrected, x, &nodes, correction);
        (void)tribo_biquad_f32_step(&params, &state, x + correction);
        for (int i = 0; i < 2; i++)
        {
            TEST_ASSERT_FLOAT_WITHIN(2e-6f, state.section[i].w1, corrected.section[i].w1);
            TEST_ASSERT_FLOAT_WITHIN(2e-6f, state.section[i].w2, corrected.section[i].w2);
        }
    }
}

// --- change of params --------------------------------------------------------------------------------------------

static void test_biquad_change_keeps_the_output_and_its_slope(void)
{
    const tribo_biquad_f32_section_t from_sections[] = {TRIBO_BIQUAD_F32(0.25, -0.3, 0.2, -1.2, 0.72),
                                                        TRIBO_BIQUAD_F32(1.5, -1.0, 0.1, -0.9, 0.1)};
    const tribo_biquad_f32_section_t to_sections[]   = {TRIBO_BIQUAD_F32(0.75, -0.3, 0.1, -1.1, 0.6),
                                                        TRIBO_BIQUAD_F32(2.5, -2.0, 0.3, -0.7, 0.2)};
    tribo_biquad_f32_params_t        to;
    init(from_sections, 2);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&to, to_sections, 2));
    for (int k = 0; k < 50; k++)
    {
        (void)tribo_biquad_f32_step(&params, &state, (float)sin(k * 0.1));
    }
    tribo_biquad_f32_state_t old = state;
    tribo_biquad_f32_change(&params, &to, &state, 0.7f, 0.25f);
    const tribo_biquad_f32_state_t old_before = old;
    const tribo_biquad_f32_state_t new_before = state;
    tribo_biquad_f32_outputs_t     old_nodes;
    (void)tribo_biquad_f32_output(&params, &old, 0.7f, &old_nodes);
    (void)tribo_biquad_f32_output(&to, &state, 0.7f, &nodes);
    tribo_biquad_f32_advance(&params, &old, 0.7f, &old_nodes, 0.0f);
    tribo_biquad_f32_advance(&to, &state, 0.7f, &nodes, 0.0f);
    for (int i = 0; i < 2; i++)
    {
        const float offset = i == 1 ? 0.25f : 0.0f;
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, old_nodes.y[i] + offset, nodes.y[i]);
        // With its input standing, an output changes as its w1 does.
        TEST_ASSERT_FLOAT_WITHIN(1e-6f,
                                 old.section[i].w1 - old_before.section[i].w1,
                                 state.section[i].w1 - new_before.section[i].w1);
    }
}

static void test_biquad_change_to_the_same_params_changes_nothing(void)
{
    const tribo_biquad_f32_section_t sections[] = {TRIBO_BIQUAD_F32(0.25, -0.3, 0.2, -1.2, 0.72),
                                                   TRIBO_BIQUAD_F32(1.5, -1.0, 0.1, -0.9, 0.1)};
    init(sections, 2);
    for (int k = 0; k < 50; k++)
    {
        (void)tribo_biquad_f32_step(&params, &state, (float)sin(k * 0.1));
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
        TEST_ASSERT_FLOAT_WITHIN(2e-6f,
                                 tribo_biquad_f32_step(&params, &plain, x),
                                 tribo_biquad_f32_step(&params, &state, x));
    }
}

static void test_biquad_change_takes_another_number_of_sections(void)
{
    const tribo_biquad_f32_section_t sections[] = {TRIBO_BIQUAD_F32(0.25, -0.3, 0.2, -1.2, 0.72),
                                                   TRIBO_BIQUAD_F32(1.5, -1.0, 0.1, -0.9, 0.1),
                                                   TRIBO_BIQUAD_F32(0.5, 0.5, 0.0, -0.5, 0.0)};
    for (uint32_t from_count = 1; from_count <= 3u; from_count++)
    {
        for (uint32_t to_count = 1; to_count <= 3u; to_count++)
        {
            tribo_biquad_f32_params_t to;
            init(sections, from_count);
            TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&to, sections, to_count));
            tribo_biquad_f32_reset(&state);
            for (int k = 0; k < 50; k++)
            {
                (void)tribo_biquad_f32_step(&params, &state, (float)sin(k * 0.1));
            }
            tribo_biquad_f32_state_t old = state;
            tribo_biquad_f32_change(&params, &to, &state, 0.7f, 0.0f);
            const float before = tribo_biquad_f32_step(&params, &old, 0.7f);
            const float after  = tribo_biquad_f32_output(&to, &state, 0.7f, &nodes);
            float       in     = 0.7f; // to the last section
            for (uint32_t i = 0; i + 1u < to_count; i++)
            {
                in = to.section[i].b0 * in + state.section[i].w1;
            }
            tribo_biquad_f32_advance(&to, &state, 0.7f, &nodes, 0.0f);
            TEST_ASSERT_FLOAT_WITHIN(2e-6f, before, after);
            if (to_count > from_count)
            {
                // The last section is new: it stands still for one more sample.
                TEST_ASSERT_FLOAT_WITHIN(1e-6f,
                                         after,
                                         state.section[to_count - 1u].w1 + to.section[to_count - 1u].b0 * in);
            }
        }
    }
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_biquad_takes_a_bad_input_for_zero_and_counts_it(void)
{
    const tribo_biquad_f32_section_t section[] = {TRIBO_BIQUAD_F32(0.25, -0.3, 0.2, -1.2, 0.72)};
    const float                      bad[]     = {NAN, -NAN, INFINITY, -INFINITY, FLT_MAX, 1.01e7f, -1.01e7f};
    tribo_biquad_f32_state_t         zeros;
    init(section, 1);
    tribo_biquad_f32_reset(&zeros);
    for (uint32_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        (void)tribo_biquad_f32_step(&params, &state, 1.0f);
        (void)tribo_biquad_f32_step(&params, &zeros, 1.0f);
        TEST_ASSERT_SAME_FLOAT(tribo_biquad_f32_step(&params, &zeros, 0.0f),
                               tribo_biquad_f32_step(&params, &state, bad[i]));
        TEST_ASSERT_EQUAL_UINT32(i + 1u, state.bad_inputs);
    }
}

static void test_biquad_starts_again_when_its_state_is_lost(void)
{
    // Accepted, but the gains of two sections multiply to 1e22.
    const tribo_biquad_f32_section_t section[] = {{1.0f, 1.0e5f, 1.0e5f, 1.0e-3f, 1.0e-6f},
                                                  {1.0f, 1.0e5f, 1.0e5f, 1.0e-3f, 1.0e-6f}};
    init(section, 2);
    for (int k = 0; k < 20000; k++)
    {
        const float y = tribo_biquad_f32_step(&params, &state, 1.0e7f);
        TEST_ASSERT_TRUE(fabsf(y) <= 1.0e15f);
    }
    TEST_ASSERT_TRUE(state.bad_inputs > 0u);

    const float lost[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < 3; i++)
    {
        tribo_biquad_f32_reset(&state);
        state.section[0].w2 = lost[i];
        TEST_ASSERT_TRUE(fabsf(tribo_biquad_f32_step(&params, &state, 0.0f)) <= 1.0e15f);
        TEST_ASSERT_TRUE(fabsf(tribo_biquad_f32_step(&params, &state, 0.0f)) <= 1.0e15f);
        TEST_ASSERT_TRUE(fabsf(tribo_biquad_f32_step(&params, &state, 0.0f)) <= 1.0e15f);
        tribo_biquad_f32_state_t rest;
        tribo_biquad_f32_reset(&rest);
        TEST_ASSERT_EQUAL_MEMORY(rest.section, state.section, sizeof rest.section); // what was carried is gone as well
        TEST_ASSERT_SAME_FLOAT(1.0f, tribo_biquad_f32_step(&params, &state, 1.0f));
        TEST_ASSERT_EQUAL_UINT32(1, state.bad_inputs);
    }

    // The last output that is not, and the next.
    for (uint32_t count = 1; count <= 2u; count++)
    {
        init(section, count);
        tribo_biquad_f32_reset(&state);
        state.section[count - 1u].w1 = 1.0e15f;
        TEST_ASSERT_SAME_FLOAT(1.0e15f, tribo_biquad_f32_step(&params, &state, 0.0f));
        TEST_ASSERT_EQUAL_UINT32(0, state.bad_inputs);
        tribo_biquad_f32_reset(&state);
        state.section[count - 1u].w1 = -1.0e15f - 0x1p26f;
        TEST_ASSERT_SAME_FLOAT(0.0f, tribo_biquad_f32_step(&params, &state, 0.0f));
        TEST_ASSERT_EQUAL_UINT32(1, state.bad_inputs);
    }
}

// --- set-up ------------------------------------------------------------------------------------------------------

static void check_refused(tribo_status_t status, const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    tribo_biquad_f32_params_t out;
    tribo_biquad_f32_params_t untouched;
    memset(&out, 0xa5, sizeof out);
    memset(&untouched, 0xa5, sizeof untouched);
    TEST_ASSERT_EQUAL_INT(status, tribo_biquad_f32_init(&out, sections, count));
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &out, sizeof out);
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
            TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&params, &section, 1));
            accepted++;
        }
        else
        {
            check_refused(TRIBO_ERR_SECTION_UNSTABLE, &section, 1);
        }
    }
    TEST_ASSERT_TRUE(accepted > 1000);
    const tribo_biquad_f32_section_t integrator = {1.0f, 0.0f, 0.0f, 0.5f, 0.0f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&params, &integrator, 1));
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
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_biquad_f32_init(NULL, sections, 1));
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
            TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&params, sections, 2));
            *fields[j] = good;
        }
    }
    sections[0].b0 = 1.0e6f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_biquad_f32_init(&params, sections, 4));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_biquad_is_the_section_of_its_usual_coefficients);
    RUN_TEST(test_biquad_cascade_runs_its_sections_in_order);
    RUN_TEST(test_biquad_keeps_a_slow_pole_to_1e_6_of_its_time_constant);
    RUN_TEST(test_biquad_integrates_what_is_far_below_its_last_digit);
    RUN_TEST(test_biquad_output_and_advance_are_one_step);
    RUN_TEST(test_biquad_advances_as_if_the_corrected_input_had_come);
    RUN_TEST(test_biquad_change_keeps_the_output_and_its_slope);
    RUN_TEST(test_biquad_change_to_the_same_params_changes_nothing);
    RUN_TEST(test_biquad_change_takes_another_number_of_sections);
    RUN_TEST(test_biquad_takes_a_bad_input_for_zero_and_counts_it);
    RUN_TEST(test_biquad_starts_again_when_its_state_is_lost);
    RUN_TEST(test_biquad_init_accepts_exactly_the_stable_sections);
    RUN_TEST(test_biquad_init_checks_count_pointers_and_coefficients);
    return UNITY_END();
}
