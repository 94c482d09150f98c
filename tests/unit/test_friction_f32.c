#include "friction/law_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/friction_f32.h"

#include "same.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define H 1.0e-3f

static tribo_friction_f32_config_t  config;
static tribo_friction_f32_params_t  params;
static tribo_friction_f32_state_t   state;
static tribo_friction_f32_signals_t seen;

static bool shows(const tribo_friction_f32_signals_t *signals, uint8_t relay)
{
    return (signals->relays & relay) != 0u;
}

void setUp(void)
{
    config = tribo_force_loop_f32_paper().compensator.friction;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&params, &config, H));
    tribo_friction_f32_reset(&state);
}

static float step(float u, float F)
{
    return tribo_friction_f32_step(&params, &state, u, F, &seen);
}

// --- the equations -----------------------------------------------------------------------------------------------

static void test_friction_curves_are_as_close_as_their_header_says(void)
{
    // With k_max = k_min = k a step with Q gives k L tanh(n/(k L)), for x = n/(k L) up to atanh(1/k).
    config.k_min             = 1.01f;
    config.k_max             = 1.01f;
    config.positive.slope    = 0.0f;
    config.positive.offset_n = 1.0f;
    config.negative          = config.positive;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&params, &config, H));
    double worst = 0.0;
    for (int i = 1; i < 20000; i++)
    {
        const float n = 2.6f * 1.01f * (float)i / 20000.0f;
        tribo_friction_f32_reset(&state);
        state.relay.latch.held = TRIBO_RELAY_Q2;
        const double f         = (double)step(n, 0.0f);
        const double exact     = fmin(1.0, 1.01 * tanh((double)n / 1.01));
        TEST_ASSERT_TRUE(shows(&seen, TRIBO_RELAY_Q));
        worst = fmax(worst, fabs(f - exact) / exact);
    }
    printf("k = 1.01: k L tanh(n/(k L)) within %.2e of itself\n", worst);
    TEST_ASSERT_DOUBLE_WITHIN(1.2e-6, 0.0, worst);

    // k is read back from f at a small n.
    config.k_min = 2.0f;
    config.k_max = 20.0f;
    for (int i = 0; i <= 1000; i++)
    {
        const double x    = -9.0 + 0.018 * i; // m (v/v0 - 1)
        config.m          = 10.0f;
        config.v0_n_per_s = 1.0f;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&params, &config, H));
        tribo_friction_f32_reset(&state);
        state.relay.latch.held = TRIBO_RELAY_Q2;
        state.n_n              = 0.9f;
        const float  n         = 0.9f + (float)(1e-3 * (x / 10.0 + 1.0));
        const double f         = (double)step(n, 0.0f);
        const double v         = (double)(n - 0.9f) * 1e3;
        const double k         = 11.0 - 9.0 * tanh(10.0 * (v - 1.0));
        // 18 times the header's 2e-6 in k, and df/dk = tanh(n/k) - n/k sech^2(n/k).
        const double slope = tanh((double)n / k) - (double)n / k / pow(cosh((double)n / k), 2.0);
        TEST_ASSERT_DOUBLE_WITHIN(18.0 * 2e-6 * slope + 1.2e-6, fmin(1.0, k * tanh((double)n / k)), f);
    }
}

/// What the mirror of a step must show.
// At a level itself nothing switches yet: all four comparisons are strict. L = 1 N makes the levels exact.
static void test_friction_counts_no_net_force_as_positive(void)
{
    config.negative.offset_n = 0.02f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&params, &config, H));
    (void)step(0.0f, 0.0f);
    TEST_ASSERT_SAME_FLOAT(0.007f, seen.L_n);
}

// -0 - 0 + -0 is -0, which the sign bit would count as negative.
static void test_friction_counts_no_net_force_as_positive_whatever_the_signs_of_its_zeros(void)
{
    const float zeros[]      = {0.0f, -0.0f};
    config.negative.offset_n = 0.02f;
    for (int i = 0; i < 8; i++)
    {
        config.gravity_n = zeros[i % 2];
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&params, &config, H));
        tribo_friction_f32_reset(&state);
        (void)step(zeros[i / 2 % 2], zeros[i / 4]);
        TEST_ASSERT_SAME_FLOAT(0.007f, seen.L_n);
    }
}

// --- bad inputs --------------------------------------------------------------------------------------------------

static void test_friction_holds_n_over_a_bad_input_counts_it_and_goes_on(void)
{
    const float bad[] = {NAN, -NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1.001e6f, -1.001e6f};
    (void)step(0.6f, 0.5f);
    const float held = seen.n_n;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        TEST_ASSERT_SAME_FLOAT(held, step(bad[i], 0.5f));
        TEST_ASSERT_SAME_FLOAT(0.0f, seen.v_n_per_s);
        TEST_ASSERT_SAME_FLOAT(0.157f, seen.L_n);
        TEST_ASSERT_SAME_FLOAT(0.007f, step(0.6f, bad[i])); // a bad F counts as 0 in L
        TEST_ASSERT_SAME_FLOAT(held, seen.n_n);
        TEST_ASSERT_EQUAL_UINT32(2u * (i + 1u), state.bad_inputs);
    }
    TEST_ASSERT_SAME_FLOAT(held, step(0.6f, 0.5f));
}

static void test_friction_takes_denormals_and_the_largest_forces(void)
{
    TEST_ASSERT_SAME_FLOAT(FLT_TRUE_MIN, step(FLT_TRUE_MIN, 0.0f));
    TEST_ASSERT_SAME_FLOAT(300000.007f, step(1.0e6f, -1.0e6f));
    TEST_ASSERT_SAME_FLOAT(-300000.007f, step(-1.0e6f, 1.0e6f));
    TEST_ASSERT_EQUAL_UINT32(0, state.bad_inputs);
}

static void test_friction_counter_stops_at_its_end(void)
{
    state.bad_inputs = UINT32_MAX - 1u;
    (void)step(NAN, 0.0f);
    (void)step(NAN, 0.0f);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, state.bad_inputs);
}

// --- set-up ------------------------------------------------------------------------------------------------------

typedef struct
{
    tribo_status_t status;
    size_t         field;
    float          lowest, highest; // the ends of the allowed range, both allowed
} range_t;

#define FIELD(name) offsetof(tribo_friction_f32_config_t, name)

static float *field(size_t offset)
{
    return (float *)(void *)((char *)&config + offset);
}

static void check_refused(tribo_status_t status, float h)
{
    tribo_friction_f32_params_t out;
    memset(&out, 0xa5, sizeof out);
    TEST_ASSERT_EQUAL_INT(status, tribo_friction_f32_init(&out, &config, h));
    TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out, sizeof out);
}

static void test_friction_init_takes_each_field_to_the_ends_of_its_range_and_no_further(void)
{
    const range_t ranges[] = {
        {TRIBO_ERR_K_MAX, FIELD(k_max), 6.0f, 1000.0f},
        {TRIBO_ERR_K_MIN, FIELD(k_min), 1.01f, 20.0f},
        {TRIBO_ERR_M, FIELD(m), 0.0f, 100.0f},
        {TRIBO_ERR_V0, FIELD(v0_n_per_s), 1.0e-6f, 1.0e6f},
        {TRIBO_ERR_BREAKAWAY_OFFSET, FIELD(positive.offset_n), 1.0e-6f, 1.0e6f},
        {TRIBO_ERR_BREAKAWAY_SLOPE, FIELD(positive.slope), 0.0f, 10.0f},
        {TRIBO_ERR_BREAKAWAY_NEGATIVE_OFFSET, FIELD(negative.offset_n), 1.0e-6f, 1.0e6f},
        {TRIBO_ERR_BREAKAWAY_NEGATIVE_SLOPE, FIELD(negative.slope), 0.0f, 10.0f},
        {TRIBO_ERR_SET_LEVEL, FIELD(set_level), 1.0e-6f, 1.0f},
        {TRIBO_ERR_RESET_LEVEL, FIELD(reset_level), 1.0e-6f, 1.0f},
        {TRIBO_ERR_PULSE_WIDTH, FIELD(pulse_width_s), 0.0005f, 0.06349f},
        {TRIBO_ERR_GRAVITY, FIELD(gravity_n), -1.0e6f, 1.0e6f},
    };
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++)
    {
        const float good = *field(ranges[i].field);
        const float in[] = {ranges[i].lowest, ranges[i].highest};
        // Half a per mille outside: the pulse width is a quotient, whose last digit rounds.
        const float below = ranges[i].lowest - fmaxf(fabsf(ranges[i].lowest) * 5e-4f, FLT_TRUE_MIN);
        const float out[] = {below, ranges[i].highest * 1.0005f, NAN, INFINITY, -INFINITY};
        for (size_t j = 0; j < 2; j++)
        {
            *field(ranges[i].field) = in[j];
            TEST_ASSERT_EQUAL_INT_MESSAGE(TRIBO_OK,
                                          tribo_friction_f32_init(&params, &config, H),
                                          tribo_status_text(ranges[i].status));
        }
        for (size_t j = 0; j < sizeof out / sizeof out[0]; j++)
        {
            *field(ranges[i].field) = out[j];
            // k_max below k_min is told as k_min's range.
            const bool k_crossed = ranges[i].status == TRIBO_ERR_K_MAX && out[j] > 1.01f && out[j] < 1000.0f;
            check_refused(k_crossed ? TRIBO_ERR_K_MIN : ranges[i].status, H);
        }
        *field(ranges[i].field) = good;
    }
}

static void test_friction_init_checks_sample_time_and_pointers(void)
{
    const float bad[] = {0.0f, 0.9e-6f, 0.11f, -H, NAN, INFINITY};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        check_refused(TRIBO_ERR_SAMPLE_TIME, bad[i]);
    }
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_friction_f32_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_friction_f32_init(&params, NULL, H));
}

static void test_friction_init_checks_the_table(void)
{
    tribo_breakaway_point_f32_t points[TRIBO_BREAKAWAY_POINTS_MAX + 1u];
    for (size_t i = 0; i <= TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        points[i] = (tribo_breakaway_point_f32_t){0.1f * (float)i, 0.1f, 0.1f};
    }
    for (uint32_t without_table = 1; without_table <= 3u; without_table++)
    {
        config.table_length = without_table;
        check_refused(TRIBO_ERR_TABLE_LENGTH, H);
    }
    config.table_length = 0;
    config.table        = points;
    check_refused(TRIBO_ERR_TABLE_LENGTH, H);
    config.table_length = TRIBO_BREAKAWAY_POINTS_MAX + 1u;
    check_refused(TRIBO_ERR_TABLE_LENGTH, H);
    config.table_length = TRIBO_BREAKAWAY_POINTS_MAX;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&params, &config, H));

    const float bad_force[] = {0.1f, 0.05f, NAN, INFINITY}; // of point 2; point 1 is at 0.1
    for (size_t i = 0; i < sizeof bad_force / sizeof bad_force[0]; i++)
    {
        points[2].force_n = bad_force[i];
        check_refused(TRIBO_ERR_TABLE_FORCE, H);
    }
    points[2].force_n = 0.2f;
    points[0].force_n = -0.1f;
    check_refused(TRIBO_ERR_TABLE_FORCE, H);
    points[0].force_n = 0.0f;

    const float bad_breakaway[] = {0.0f, -0.1f, 0.9e-6f, 1.1e6f, NAN};
    for (size_t i = 0; i < sizeof bad_breakaway / sizeof bad_breakaway[0]; i++)
    {
        points[3].positive_n = bad_breakaway[i];
        check_refused(TRIBO_ERR_TABLE_POSITIVE, H);
        points[3].positive_n = 0.1f;
        points[3].negative_n = bad_breakaway[i];
        check_refused(TRIBO_ERR_TABLE_NEGATIVE, H);
        points[3].negative_n = 0.1f;
    }
    // With a table the affine laws are not read.
    config.positive.offset_n = NAN;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&params, &config, H));
}

static void test_friction_init_rounds_the_pulse_width_to_samples(void)
{
    const float sample_times[] = {1.0e-3f, 1.0e-4f, 5.0e-5f, 0.7e-3f, 0.833e-3f, 4.0e-3f};
    const int   samples[]      = {3, 30, 60, 4, 4, 1};
    for (size_t i = 0; i < sizeof samples / sizeof samples[0]; i++)
    {
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&params, &config, sample_times[i]));
        TEST_ASSERT_EQUAL_INT(samples[i], params.pulse_width);
    }
}

#include "runners/test_friction_f32.inc" // main
