#include ARITH_HEADER
#include "random.h"
#include "runs.h"
#include "tribo/paper_controller.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

static const tribo_biquad_f32_section_t paper[]           = TRIBO_PAPER_CONTROLLER_F32;
static const tribo_biquad_f32_section_t pi[]              = {TRIBO_BIQUAD_F32(2.0, -1.9, 0.0, -1.0, 0.0)};
static const tribo_biquad_f32_section_t two_integrators[] = {TRIBO_BIQUAD_F32(1.0, -0.9, 0.0, -1.0, 0.0),
                                                             TRIBO_BIQUAD_F32(1.0, -0.9, 0.0, -1.0, 0.0)};
static const tribo_biquad_f32_section_t pi_first[]        = {TRIBO_BIQUAD_F32(2.0, -1.9, 0.0, -1.0, 0.0),
                                                             TRIBO_BIQUAD_F32(1.0, -0.2, 0.0, -0.6, 0.0)};
// Zeros outside the unit circle: D > 0, K(1) < 0; the same behind an integrator; a complex pair; one beyond z = -1.
static const tribo_biquad_f32_section_t zero_outside[]    = {TRIBO_BIQUAD_F32(1.0, -1.2, 0.0, -0.99, 0.0)};
static const tribo_biquad_f32_section_t pi_zero_outside[] = {TRIBO_BIQUAD_F32(2.0, -1.9, 0.0, -1.0, 0.0),
                                                             TRIBO_BIQUAD_F32(1.0, -1.2, 0.0, -0.6, 0.0)};
static const tribo_biquad_f32_section_t complex_outside[] = {TRIBO_BIQUAD_F32(1.0, -1.8, 1.3, -1.5, 0.6),
                                                             TRIBO_BIQUAD_F32(0.7, -0.6, 0.0, -0.9999, 0.0)};
static const tribo_biquad_f32_section_t zero_behind[]     = {TRIBO_BIQUAD_F32(1.0, 1.5, 0.0, -0.9, 0.0)};

static tribo_controller_f32_config_t config;
static controller_t                  controller;
static controller_seen_t             seen;

static void init(const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    config = (tribo_controller_f32_config_t){.sections      = sections,
                                             .section_count = count,
                                             .u_min_n       = -0.5f,
                                             .u_max_n       = 1.0f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, controller_init(&controller, &config));
}

void setUp(void)
{
    init(paper, 2);
}

static double step(double e, double feedforward)
{
    seen = controller_step(&controller, e, feedforward);
    return seen.u;
}

typedef struct
{
    double b0, b1, b2, a1, a2, w1, w2;
} double_section_t;

static double double_step(double_section_t *s, double x)
{
    const double y = s->b0 * x + s->w1;
    s->w1 += s->b1 * x - s->a1 * y + s->w2;
    s->w2 += s->b2 * x - s->a2 * y;
    return y;
}

static void init_in_double(double_section_t cascade[2])
{
    for (int i = 0; i < 2; i++)
    {
        cascade[i] = (double_section_t){.b0 = (double)paper[i].b0,
                                        .b1 = (double)paper[i].b1,
                                        .b2 = (double)paper[i].b2,
                                        .a1 = (double)paper[i].a1,
                                        .a2 = (double)paper[i].a2};
    }
}

/// Rounds to a multiple of 2^-28 N, which is the same number in each arithmetic.
static double on_grid(double x)
{
    return round(x * 0x1p28) * 0x1p-28;
}

static void test_controller_is_its_cascade_plus_the_feedforward(void)
{
    double_section_t cascade[2];
    init_in_double(cascade);
    for (int k = 0; k < 1000; k++)
    {
        const double e = 0.01 * sin(k * 0.05);
        const double f = 0.1 * cos(k * 0.01);
        const double v = double_step(&cascade[1], double_step(&cascade[0], e));
        (void)step(e, f);
        TEST_ASSERT_DOUBLE_WITHIN(4.0 * ROUNDING, v, seen.v);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, seen.v + f, seen.u);
        TEST_ASSERT_FALSE(seen.limited);
    }
    TEST_ASSERT_EQUAL_UINT32(0, controller.state.limited_ticks);
}

// 20 mN of ripple at half the sample rate, and a little offset, for a minute: what rounding leaves of the ripple has always the
// same sign, and the slow pole adds it up.
static void test_controller_is_that_of_double_with_ripple_at_half_the_sample_rate(void)
{
    random_t r     = {3};
    double   worst = 0.0;
    for (int i = 0; i < RUNS(4, 1); i++)
    {
        double_section_t cascade[2];
        const double     ripple = random_between(&r, 0.0195, 0.0205);
        const double     offset = i == 0 ? 0.0 : random_between(&r, -2e-5, 2e-5);
        init_in_double(cascade);
        init(paper, 2);
        for (int k = 0; k < RUNS(60000, 5000); k++)
        {
            const double e = on_grid(offset + (k % 2 == 0 ? ripple : -ripple));
            const double v = double_step(&cascade[1], double_step(&cascade[0], e));
            (void)step(e, 0.0);
            worst = fmax(worst, fabs(seen.v - v));
        }
        TEST_ASSERT_EQUAL_UINT32(0, controller.state.limited_ticks);
    }
    printf("v with ripple: within %.1e N of double's\n", worst);
    TEST_ASSERT_TRUE(worst <= RIPPLE_TOLERANCE_N);
}

static void test_controller_keeps_u_within_its_limits(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 1.0, step(1.9, 0.0));
    TEST_ASSERT_TRUE(seen.limited);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, -0.5, step(-1.9, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 1.0, step(0.0, 1.9));
    TEST_ASSERT_EQUAL_UINT32(3, controller.state.limited_ticks);
    controller.state.limited_ticks = UINT32_MAX;
    (void)step(1.9, 0.0);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, controller.state.limited_ticks);
}

static void test_controller_is_not_limited_at_its_very_limit(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 1.0, step(0.0, 1.0));
    TEST_ASSERT_FALSE(seen.limited);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, -0.5, step(0.0, -0.5));
    TEST_ASSERT_FALSE(seen.limited);
    (void)step(0.0, 1.0 + 2e-7);
    TEST_ASSERT_TRUE(seen.limited);
    controller_reset(&controller);
    (void)step(0.0, -0.5 - 1e-7);
    TEST_ASSERT_TRUE(seen.limited);
    TEST_ASSERT_EQUAL_UINT32(1, controller.state.limited_ticks);
}

// Hanus: the states go on as if the input had come that gives the limited u.
static void test_controller_conditions_its_states_on_the_limited_output(void)
{
    const double D          = (double)paper[0].b0 * (double)paper[1].b0;
    const double realisable = (1.0 - 0.2) / D; // from rest
    controller_t other      = controller;
    (void)step(1.8, 0.2);
    TEST_ASSERT_TRUE(seen.limited);
    const controller_seen_t just = controller_step(&other, realisable, 0.2);
    TEST_ASSERT_DOUBLE_WITHIN(4.0 * ROUNDING, 1.0, just.u);
    for (int k = 0; k < 1000; k++)
    {
        const double expected = controller_step(&other, 0.01 * sin(k * 0.1), 0.2).v;
        (void)step(0.01 * sin(k * 0.1), 0.2);
        TEST_ASSERT_DOUBLE_WITHIN(2e-6, expected, seen.v);
    }
}

/// The states stand once u has been limited for long, and not far away.
static void check_no_windup(const tribo_biquad_f32_section_t *sections, uint32_t count, double e)
{
    const int half = RUNS(30000, 6000);
    init(sections, count);
    double w1[TRIBO_BIQUAD_SECTIONS_MAX] = {0.0};
    for (int k = 0; k < 2 * half; k++)
    {
        (void)step(e, 0.0);
        for (uint32_t i = 0; i < count && k == half; i++)
        {
            w1[i] = controller_w1(&controller, i);
        }
    }
    for (uint32_t i = 0; i < count; i++)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * (1.0 + fabs(w1[i])), w1[i], controller_w1(&controller, i));
        TEST_ASSERT_TRUE(fabs(w1[i]) < 1.0e3);
    }
    TEST_ASSERT_TRUE(controller.state.limited_ticks > 100u);
}

static void test_controller_does_not_wind_up_whatever_its_zeros(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        check_no_windup(paper, 2, sign * 1.9);
        check_no_windup(pi, 1, sign * 1.9);
        check_no_windup(pi_first, 2, sign * 1.9);
        check_no_windup(two_integrators, 2, sign * 1.9);
        check_no_windup(zero_outside, 1, sign * 1.9);
        check_no_windup(zero_behind, 1, sign * 1.9);
        check_no_windup(pi_zero_outside, 2, sign * 1.9);
        check_no_windup(complex_outside, 2, sign * 1.9);
    }
}

/// A notch of `frequency_hz` with zeros on the unit circle, or with `left` of its poles' damping; times `gain`.
static tribo_biquad_f32_section_t notch(double frequency_hz, double quality, double rate_hz, double left, double gain)
{
    const double w  = 2.0 * 3.14159265358979323846 * frequency_hz / rate_hz;
    const double a  = tan(w / quality / 2.0);
    const double b0 = gain * (1.0 + left * a) / (1.0 + a);
    const double at = (2.0 - 2.0 * cos(w)) / (1.0 + a); // the denominator at z = 1
    return (tribo_biquad_f32_section_t){.b0 = (float)b0,
                                        .b1 = (float)(2.0 * b0 - 2.0 * gain * cos(w) / (1.0 + a)),
                                        .b2 = (float)(gain * at),
                                        .a1 = (float)(2.0 - 2.0 * cos(w) / (1.0 + a)),
                                        .a2 = (float)at};
}

/// Taken, and conditioned by c. The spectral radius of the states while u is limited is 1 for c = 1, by numpy, as the zeros are poles
/// then; for c = -1 it is 0.9979 at 5 kHz and Q = 30.
static void check_conditioned_by(double c, const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    double D = 1.0;
    for (uint32_t i = 0; i < count; i++)
    {
        D *= (double)sections[i].b0;
    }
    init(sections, count);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, c, controller_anti_windup(&controller) * D);
}

static void test_controller_takes_a_mains_notch_at_any_sample_rate(void)
{
    static const double rates[] =
        {500, 1000, 2000, 3000, 4000, 5000, 6000, 8000, 10000, 12000, 15000, 16000, 20000, 25000, 30000, 40000};
    static const double        qualities[] = {1.0, 3.0, 10.0, 30.0, 100.0};
    static const double        left[]      = {0.0, 1e-9, 1e-8, 1e-6};
    const int                  all         = RUNS(16 * 5 * 2 * 4, 16 * 2);
    tribo_biquad_f32_section_t s[3];
    for (int k = 0; k < all; k++)
    {
        const double rate_hz = rates[k % 16];
        const double hertz   = k / 16 % 2 == 0 ? 50.0 : 60.0;
        const double quality = qualities[(k / 32 + 3) % 5];
        s[0]                 = notch(hertz, quality, rate_hz, left[k / 160], 1.0);
        s[1]                 = s[0];
        check_conditioned_by(-1.0, s, 1);
        check_conditioned_by(-1.0, s, 2);
        s[0] = notch(hertz, quality, rate_hz, left[k / 160], 1e-3);
        check_conditioned_by(-1.0, s, 1);
        s[0] = notch(hertz, quality, rate_hz, left[k / 160], 300.0);
        check_conditioned_by(-1.0, s, 1);
        s[2] = (tribo_biquad_f32_section_t){.b0 = 0.5f, .b1 = 0.5f, .b2 = (float)(10.0 / rate_hz), .a1 = 1.0f};
        s[2].b1 += s[2].b2;
        check_conditioned_by(0.5, &s[1], 2); // before an integrator
    }
}

// Zeros at z = -1, as Tustin's rule makes them, and at z = 1, each off by a last bit to the inside; slow real zeros are no such zeros.
static void test_controller_is_not_conditioned_by_zeros_that_a_last_bit_puts_inside(void)
{
    const tribo_biquad_f32_section_t behind[] = {{1.0f, 3.5f, 2.9999998f, 1.2f, 0.3f}};
    const tribo_biquad_f32_section_t at_1[]   = {{1.0f, 1.0f, 1e-9f, 1.1f, 0.2f}};
    const tribo_biquad_f32_section_t slow[]   = {{1.0f, 2e-6f, 1e-12f, 2e-5f, 1e-10f}};
    check_conditioned_by(0.5, behind, 1);
    check_conditioned_by(-1.0, at_1, 1);
    check_conditioned_by(1.0, slow, 1);
}

static void test_controller_leaves_its_limit_as_soon_as_the_error_turns(void)
{
    for (int k = 0; k < RUNS(60000, 10000); k++)
    {
        (void)step(1.9, 0.0);
    }
    const double limit = step(1.9, 0.0);
    TEST_ASSERT_TRUE(seen.limited);
    TEST_ASSERT_TRUE(step(-0.01, 0.0) < limit); // in the first tick
    TEST_ASSERT_FALSE(seen.limited);
}

static void test_controller_changes_params_without_a_bump(void)
{
    static controller_t           other;
    tribo_controller_f32_config_t other_config = config;
    other_config.sections                      = pi_first;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, controller_init(&other, &other_config));
    for (int k = 0; k < 2000; k++)
    {
        (void)step(0.002, 0.1);
    }
    const double before = seen.u;
    controller_change(&controller, &other, 0.002, 0.0);
    const double after = step(0.002, 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, before, after); // it had been rising by 1e-5 a tick
    controller_change(&controller, &other, 0.002, -0.05);
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, after - 0.05, step(0.002, 0.1));
}

// Sections with b0 = 1 whose zeros are their poles pass on what they get, an anti-windup's correction too.
static void test_controller_padded_with_unity_sections_gives_the_same_bits(void)
{
    static const tribo_biquad_f32_section_t unity      = TRIBO_BIQUAD_F32(1.0, 0.0, 0.0, 0.0, 0.0);
    const tribo_biquad_f32_section_t        sections[] = {paper[0], paper[1], unity, unity};
    static controller_t                     padded;
    tribo_controller_f32_config_t           other_config = config;
    other_config.sections                                = sections;
    for (uint32_t count = 3; count <= TRIBO_BIQUAD_SECTIONS_MAX; count++)
    {
        random_t r                 = {9};
        other_config.section_count = count;
        controller_reset(&controller);
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, controller_init(&padded, &other_config));
        for (int k = 0; k < 5000; k++)
        {
            const double            e        = random_between(&r, -0.6, 0.6);
            const controller_seen_t expected = controller_step(&padded, e, 0.1);
            TEST_ASSERT_TRUE(expected.u == step(e, 0.1));
            TEST_ASSERT_TRUE(expected.v == seen.v);
            TEST_ASSERT_EQUAL_INT(expected.limited, seen.limited);
        }
        TEST_ASSERT_TRUE(controller.state.limited_ticks > 100u && controller.state.limited_ticks < 4900u);
        TEST_ASSERT_EQUAL_UINT32(controller.state.limited_ticks, padded.state.limited_ticks);
    }
}

#include "runners/test_controller.inc" // main
