#include "controller/anti_windup_f32.h"
#include "friction/arm_q31.h"
#include "tribo/controller_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/paper_controller.h"

#include "cascade_q31.h"
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#define FULL_SCALE 2.0f

static const tribo_biquad_f32_section_t paper[] = TRIBO_PAPER_CONTROLLER_F32;
static const tribo_biquad_f32_section_t pi[]    = {TRIBO_BIQUAD_F32(2.0, -1.9, 0.0, -1.0, 0.0)};

static tribo_controller_f32_config_t  config;
static tribo_controller_q31_params_t  params;
static tribo_controller_q31_state_t   state;
static tribo_controller_q31_signals_t seen;
static tribo_headroom_q31_t           headroom;

static void init(const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    config = (tribo_controller_f32_config_t){.sections      = sections,
                                             .section_count = count,
                                             .u_min_n       = -0.5f,
                                             .u_max_n       = 1.0f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_q31_init(&params, &config, FULL_SCALE, &headroom));
    tribo_controller_q31_reset(&state);
}

void setUp(void)
{
    init(paper, 2);
}

static int32_t q31(double force_n)
{
    return (int32_t)round(force_n / (double)FULL_SCALE * 2147483648.0);
}

static int32_t step(double e, double feedforward)
{
    return controller_q31_step(&params, &state, q31(e), q31(feedforward), &seen);
}

typedef struct
{
    double b0, b1, b2, a1, a2, w1, w2;
} double_section_t;

/// A tick of the paper's controller in double, limited to -0.5 to 1 N.
static double double_step(double_section_t s[2], double e, double anti_windup)
{
    const double y   = s[0].b0 * e + s[0].w1;
    const double v   = s[1].b0 * y + s[1].w1;
    const double u   = fmin(fmax(v, -0.5), 1.0);
    const double c   = (u - v) * anti_windup;
    const double x[] = {e + c, y + s[0].b0 * c, v + s[1].b0 * s[0].b0 * c};
    for (int i = 0; i < 2; i++)
    {
        s[i].w1 += s[i].b1 * x[i] - s[i].a1 * x[i + 1] + s[i].w2;
        s[i].w2 += s[i].b2 * x[i] - s[i].a2 * x[i + 1];
    }
    return u;
}

// What anti-windup takes back is rounded, and the slow pole remembers it.
static void test_controller_is_that_of_double_after_a_limit(void)
{
    const double anti_windup =
        ldexp(params.anti_windup,
              params.anti_windup_shift - 32 + params.cascade.input_scale - params.cascade.section[1].scale);
    double_section_t s[2];
    double           worst = 0.0;
    for (int i = 0; i < 2; i++)
    {
        s[i] = (double_section_t){.b0 = (double)paper[i].b0,
                                  .b1 = (double)paper[i].b1,
                                  .b2 = (double)paper[i].b2,
                                  .a1 = (double)paper[i].a1,
                                  .a2 = (double)paper[i].a2};
    }
    for (int k = 0; k < 4000; k++)
    {
        const double e = k < 2000 ? 0.25 : 0.0;
        const double u = double_step(s, e, anti_windup);
        worst          = fmax(worst, fabs(step(e, 0.0) / 0x1p31 - u / (double)FULL_SCALE));
    }
    printf("u after a limit: within %.2g of full scale of double's\n", worst);
    TEST_ASSERT_TRUE(state.limited_ticks > 1500u && state.limited_ticks < 2500u);
    TEST_ASSERT_TRUE(worst < 9e-8);
}

static tribo_biquad_f32_section_t random_section(random_t *r)
{
    const double p     = random_between(r, 0.0, 0.98);
    const double angle = random_between(r, 0.0, 3.1);
    const double q     = random_between(r, 0.0, 1.3);
    const double turn  = random_between(r, 0.0, 3.1);
    const double b0    = random_between(r, 0.1, 3.0);
    return (tribo_biquad_f32_section_t)
        TRIBO_BIQUAD_F32(b0, b0 * -2.0 * q * cos(turn), b0 * q * q, -2.0 * p * cos(angle), p * p);
}

/// What the most that a limit may take does at each node, as the controller computes it: it fits, and no less would do.
static void check_taken_max(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        const int64_t taken = sign * (int64_t)params.taken_max;
        int64_t       c     = (taken * params.anti_windup >> 32) * (INT64_C(1) << params.anti_windup_shift);
        int64_t       most  = llabs(c) > llabs(taken) ? llabs(c) : llabs(taken);
        for (uint32_t i = 0; i < params.cascade.count; i++)
        {
            TEST_ASSERT_TRUE(c >= INT32_MIN && c <= INT32_MAX);
            c    = i == 0u ? (c * params.cascade.section[i].b0 >> 32) * 16 : c * params.cascade.section[i].b0 >> 28;
            most = llabs(c) > most ? llabs(c) : most;
        }
        TEST_ASSERT_TRUE(c >= INT32_MIN && c <= INT32_MAX);
        TEST_ASSERT_TRUE((double)most > (0.9999 - 10.0 / params.taken_max) * 0x1p31);
    }
}

// A slow lag before its lead leaves a small node after a large gain.
static void test_controller_bounds_what_a_limit_takes_at_any_gain(void)
{
    const tribo_biquad_f32_section_t lag_and_lead[] = {
        {-0.00693013705f, -0.00796202105f, -0.00228688191f, 0.0014880657f, 5.41637121e-07f},
        {0.278461784f, 0.000387235748f, 1.33695153e-07f, 1.41458213f, 0.4972938f}};
    config = (tribo_controller_f32_config_t){.sections      = lag_and_lead,
                                             .section_count = 2,
                                             .u_min_n       = -1.0f,
                                             .u_max_n       = 1.0f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_q31_init(&params, &config, 1.0f, NULL));
    TEST_ASSERT_TRUE(params.taken_max < 20000); // of 2^31
    check_taken_max();
}

// Whatever the limits take away and the feedforward adds, no node of the cascade saturates.
static void test_controller_headroom_holds_for_full_scale_inputs_at_its_limits(void)
{
    random_t r    = {77};
    int      runs = 0;
    for (int i = 0; i < RUNS(100, 20); i++)
    {
        tribo_biquad_f32_section_t sections[TRIBO_BIQUAD_SECTIONS_MAX];
        const uint32_t             count = 1u + (uint32_t)i % TRIBO_BIQUAD_SECTIONS_MAX;
        for (uint32_t j = 0; j < count; j++)
        {
            sections[j] = random_section(&r);
        }
        sections[0]                 = i % 3 == 0 ? pi[0] : sections[0];
        config                      = (tribo_controller_f32_config_t){.sections      = sections,
                                                                      .section_count = count,
                                                                      .u_min_n       = -0.5f,
                                                                      .u_max_n       = 1.0f};
        const tribo_status_t status = tribo_controller_q31_init(&params, &config, FULL_SCALE, &headroom);
        if (status != TRIBO_OK)
        {
            continue;
        }
        runs++;
        check_taken_max();
        tribo_controller_q31_reset(&state);
        int32_t e = INT32_MAX;
        int32_t f = INT32_MAX;
        for (int k = 0; k < 3000; k++)
        {
            const uint64_t bits = random_bits(&r);
            e                   = bits % 8u == 0u ? -e : e;
            f                   = bits / 8u % 64u == 0u ? -f : f;
            const int32_t u     = controller_q31_step(&params, &state, e, f, &seen);
            TEST_ASSERT_TRUE(u >= params.u_min && u <= params.u_max);
        }
        TEST_ASSERT_EQUAL_UINT32(0, state.cascade.saturated);
        TEST_ASSERT_TRUE((double)headroom.input < ldexp(1.0, params.cascade.input_scale));
    }
    TEST_ASSERT_TRUE(runs > RUNS(60, 12));
}

// --- headroom ----------------------------------------------------------------------------------------------------

#define MARGIN 1.02 // of the set-up over what it measures

/// L1 norms of all that the cascade of `params` computes, in parts of full scale, in double: from e within full scale and
/// from u - feedforward within `s_peak`.
typedef struct
{
    double input, correction;
    double y[TRIBO_BIQUAD_SECTIONS_MAX];                                        ///< as put out, ...
    double corrected[TRIBO_BIQUAD_SECTIONS_MAX], by[TRIBO_BIQUAD_SECTIONS_MAX]; ///< ... corrected, and by what
    double w1[TRIBO_BIQUAD_SECTIONS_MAX], w2[TRIBO_BIQUAD_SECTIONS_MAX];
} norms_t;

/// Section i as it will run.
static double_section_t running_section(uint32_t i)
{
    const tribo_biquad_q31_section_t *s = &params.cascade.section[i];
    const int before                    = i == 0u ? params.cascade.input_scale : params.cascade.section[i - 1u].scale;
    const int by                        = s->scale - before - 28;
    return (double_section_t){.b0 = ldexp(s->b0, by),
                              .b1 = ldexp(s->c1 + s->b0, by),
                              .b2 = ldexp(s->c2, by - s->shift),
                              .a1 = -ldexp(s->minus_a1, -28),
                              .a2 = -ldexp(s->d2, -28 - s->shift) - ldexp(s->d2_low, -60 - s->shift)};
}

static void add_norms(norms_t *norms, double_section_t *s, uint32_t count, double anti_windup, double e, double u)
{
    double y[TRIBO_BIQUAD_SECTIONS_MAX];
    double v = e;
    for (uint32_t i = 0; i < count; i++)
    {
        y[i] = s[i].b0 * v + s[i].w1;
        v    = y[i];
    }
    double c  = (u - v) * anti_windup;
    double in = e + c;
    norms->input += fabs(in);
    norms->correction += fabs(c);
    for (uint32_t i = 0; i < count; i++)
    {
        c *= s[i].b0;
        const double out = y[i] + c;
        norms->y[i] += fabs(y[i]);
        norms->corrected[i] += fabs(out);
        norms->by[i] += fabs(c);
        s[i].w1 += s[i].b1 * in - s[i].a1 * out + s[i].w2;
        s[i].w2 += s[i].b2 * in - s[i].a2 * out;
        norms->w1[i] += fabs(s[i].w1);
        norms->w2[i] += fabs(s[i].w2);
        in = out;
    }
}

/// The largest part of a response that is still to come.
static double rest_of(const norms_t *norms, const double_section_t *s, uint32_t count)
{
    double rest = 0.0;
    for (uint32_t i = 0; i < count; i++)
    {
        rest = fmax(rest, (fabs(s[i].w1) + fabs(s[i].w2)) / norms->w1[i]);
    }
    return rest;
}

/// False where they have not died away in `ticks`.
static bool find_norms(norms_t *norms, double s_peak, int ticks)
{
    const uint32_t count = params.cascade.count;
    const double   anti_windup =
        ldexp(params.anti_windup,
              params.anti_windup_shift - 32 + params.cascade.input_scale - params.cascade.section[count - 1u].scale);
    double left = 0.0;
    *norms      = (norms_t){.input = 0.0};
    for (int of_s = 0; of_s < 2; of_s++)
    {
        double_section_t s[TRIBO_BIQUAD_SECTIONS_MAX];
        for (uint32_t i = 0; i < count; i++)
        {
            s[i] = running_section(i);
        }
        double rest = 1.0;
        for (int k = 0; k < ticks && rest >= 1e-12; k++)
        {
            const double impulse = k > 0 ? 0.0 : (of_s == 0 ? 1.0 : s_peak);
            add_norms(norms, s, count, anti_windup, of_s == 0 ? impulse : 0.0, of_s == 0 ? 0.0 : impulse);
            if (k % 1000 == 999 || k == ticks - 1)
            {
                rest = rest_of(norms, s, count);
            }
        }
        left = fmax(left, rest);
    }
    return left < 1e-12;
}

static double node_peak(const norms_t *norms, uint32_t i)
{
    return fmax(norms->y[i], fmax(norms->corrected[i], norms->by[i]));
}

/// The least scale from `least` on that takes `peak` below full scale.
static int scale_for(double peak, int least)
{
    int scale = least;
    while (scale < 30 && !(ldexp(peak, -scale) < 1.0))
    {
        scale++;
    }
    return scale;
}

typedef struct
{
    int scale, shift;
} formats_t;

/// Scale and shift of section i for the peaks times `factor`.
static formats_t formats_for(const norms_t *norms, uint32_t i, double factor)
{
    const double_section_t s      = running_section(i);
    const int              before = i == 0u ? params.cascade.input_scale : params.cascade.section[i - 1u].scale;
    const double           gain   = fmax(fabs(s.b0), fmax(fabs(s.b1), fabs(s.b2)));
    const double           w      = factor * MARGIN * fmax(norms->w1[i], norms->w2[i]);
    formats_t              found  = {.scale = scale_for(factor * MARGIN * node_peak(norms, i), 0), .shift = 30};
    found.scale                   = scale_for(fmax(ldexp(gain, before), w) / 3.999, found.scale);
    const double b2               = ldexp(fabs(s.b2), before - params.cascade.section[i].scale);
    const double w2               = ldexp(factor * MARGIN * norms->w2[i], -params.cascade.section[i].scale);
    while (found.shift > 0 && !(ldexp(fmax(b2, fmax(s.a2, w2)), found.shift) < 3.999))
    {
        found.shift--;
    }
    return found;
}

static bool is_between(int x, int a, int b)
{
    return (x >= a && x <= b) || (x >= b && x <= a);
}

/// What the set-up reports and the formats that it chooses, against norms of what it made. Returns the number of formats that
/// 0.001 % more or less would make others.
static int check_formats(const norms_t *norms)
{
    const double slack = 1e-5; // what is left below DECAYED, and one rounding to float
    int          close = 0;
    TEST_ASSERT_DOUBLE_WITHIN(slack * fmax(1.0, MARGIN * norms->input),
                              fmax(1.0, MARGIN * norms->input),
                              (double)headroom.input);
    const double input = MARGIN * fmax(norms->input, norms->correction);
    TEST_ASSERT_TRUE(is_between(params.cascade.input_scale,
                                scale_for(input * (1.0 - slack), 2),
                                scale_for(input * (1.0 + slack), 2)));
    for (uint32_t i = 0; i < params.cascade.count; i++)
    {
        const tribo_biquad_q31_section_t *s    = &params.cascade.section[i];
        const double                      peak = MARGIN * node_peak(norms, i);
        const formats_t                   low  = formats_for(norms, i, 1.0 - slack);
        const formats_t                   high = formats_for(norms, i, 1.0 + slack);
        TEST_ASSERT_DOUBLE_WITHIN(slack * peak, peak, (double)headroom.output[i]);
        TEST_ASSERT_TRUE(is_between(s->scale, low.scale, high.scale));
        TEST_ASSERT_TRUE(is_between(s->shift, low.shift, high.shift));
        TEST_ASSERT_TRUE(llabs(s->b0) < INT64_C(1) << 30 && llabs((int64_t)s->c1 + s->b0) < INT64_C(1) << 30);
        TEST_ASSERT_TRUE(llabs(s->c2) < INT64_C(1) << 30 && llabs(s->d2) <= INT64_C(1) << 30);
        close += low.scale != high.scale || low.shift != high.shift;
    }
    return close;
}

/// A section of gain `b0` that passes its input on: its poles are its zeros, at z = 0.
static tribo_biquad_f32_section_t gain_of(float b0)
{
    return (tribo_biquad_f32_section_t){b0, 2.0f * b0, b0, 2.0f, 1.0f};
}

static tribo_status_t init_within(float u_max_n)
{
    config.u_min_n = -u_max_n;
    config.u_max_n = 0.5f * u_max_n; // the smaller of the two
    return tribo_controller_q31_init(&params, &config, FULL_SCALE, &headroom);
}

static void test_controller_formats_are_the_least_that_hold_the_peaks(void)
{
    random_t  r            = {5};
    const int runs         = RUNS(400, 6);
    int       checked      = 0;
    int       close        = 0;
    int       by_corrected = 0;
    int       by_input     = 0;
    for (int i = 0; i < runs; i++)
    {
        tribo_biquad_f32_section_t sections[TRIBO_BIQUAD_SECTIONS_MAX];
        const uint32_t             count = 1u + (uint32_t)i % TRIBO_BIQUAD_SECTIONS_MAX;
        for (uint32_t j = 0; j < count; j++)
        {
            const double b0 = pow(2.0, random_between(&r, -8.0, 8.0));
            sections[j]     = i % 2 == 0 ? random_section(&r) : gain_of((float)b0);
        }
        config               = (tribo_controller_f32_config_t){.sections = sections, .section_count = count};
        const double u_max_n = random_between(&r, 0.1, (double)FULL_SCALE);
        norms_t      norms;
        if (init_within((float)u_max_n) != TRIBO_OK || !find_norms(&norms, u_max_n / (double)FULL_SCALE + 1.0, 1000))
        {
            continue;
        }
        checked++;
        close += check_formats(&norms);
        by_input += norms.input > norms.correction && norms.input > 1.0;
        for (uint32_t j = 0; j < count; j++)
        {
            by_corrected += norms.corrected[j] > 1.01 * fmax(norms.y[j], norms.by[j]);
        }
    }
    printf("formats of %d controllers, %d close to a limit\n", checked, close);
    TEST_ASSERT_TRUE(checked > runs / 2 && close <= checked / 10);
    TEST_ASSERT_TRUE(by_corrected >= RUNS(20, 0) && by_input >= RUNS(20, 0));
}

/// c1 and c2 of d^2 + c1 d + c2: two slow roots, or a slow damped oscillation.
static void random_slow_roots(random_t *r, double *c1, double *c2)
{
    if (random_bits(r) % 2u == 0u)
    {
        const double p = pow(10.0, random_between(r, -4.5, -0.5));
        const double q = pow(10.0, random_between(r, -4.5, -0.5));
        *c1            = p + q;
        *c2            = p * q;
        return;
    }
    const double turn    = pow(10.0, random_between(r, -3.0, 0.3)); // rad a tick
    const double damping = random_between(r, 0.02, 1.0);
    const double radius  = exp(-damping * turn);
    const double angle   = turn * sqrt(1.0 - damping * damping);
    *c1                  = 2.0 - 2.0 * radius * cos(angle);
    *c2                  = 1.0 - 2.0 * radius * cos(angle) + radius * radius;
}

// Where the responses outlast what set-up sums, in double tick by tick: an upper bound, and at most 15 % and the margin above.
static void test_controller_headroom_bounds_slow_responses(void)
{
    random_t  r       = {26};
    const int runs    = RUNS(300, 0);
    int       checked = 0;
    int       slow    = 0;
    double    most    = 0.0;
    for (int i = 0; i < runs; i++)
    {
        tribo_biquad_f32_section_t sections[2];
        const uint32_t             count = 1u + (uint32_t)i % 2u;
        for (uint32_t j = 0; j < count; j++)
        {
            double       a1, a2, z1, z2;
            const double b0 = random_between(&r, 0.1, 3.0);
            random_slow_roots(&r, &a1, &a2);
            random_slow_roots(&r, &z1, &z2);
            sections[j] =
                (tribo_biquad_f32_section_t){(float)b0, (float)(b0 * z1), (float)(b0 * z2), (float)a1, (float)a2};
        }
        config = (tribo_controller_f32_config_t){.sections = sections, .section_count = count};
        norms_t norms;
        if (init_within(1.0f) != TRIBO_OK || !find_norms(&norms, 1.5, 1000000))
        {
            continue;
        }
        checked++;
        norms_t few;
        slow += !find_norms(&few, 1.5, 1024);
        for (uint32_t j = 0; j < count; j++)
        {
            const double ratio = (double)headroom.output[j] / node_peak(&norms, j);
            TEST_ASSERT_TRUE(ratio > 1.0 && ratio < 1.15 * MARGIN);
            most = fmax(most, ratio);
        }
        TEST_ASSERT_TRUE((double)headroom.input > norms.input);
    }
    printf("peaks of %d controllers, %d of them slow: at most %.3f of the sums in double\n", checked, slow, most);
    TEST_ASSERT_TRUE(checked >= runs / 2 && slow >= runs / 4);
}

// Cascades whose slow modes all but cancel: what the bound loses in rounding must not take it below the sums.
static void test_controller_headroom_bounds_modes_that_almost_cancel(void)
{
    static const struct
    {
        tribo_biquad_f32_section_t sections[4];
    } cascades[] = {{{{23.723875f, 0.674665809f, 0.00417932263f, 0.539615452f, 0.0477859974f},
                      {7.91872549f, 0.00445514498f, 4.65988222e-07f, 0.0447748415f, 7.5732155e-06f},
                      {0.0173889231f, 1.62027627e-05f, 7.17376436e-10f, 0.0159217846f, 2.3274643e-07f},
                      {3.63375354f, 5.88738489f, 4.52957487f, 0.938799739f, 0.000163414472f}}},
                    {{{0.0347032845f, 0.000202778843f, 6.63558666e-08f, 0.201438084f, 0.00024438111f},
                      {1.62434101f, 0.151850849f, 8.12772196e-05f, 0.00594887091f, 3.29088039e-07f},
                      {0.011357449f, 1.27770375e-06f, 5.1186283e-10f, 0.349335462f, 0.105578601f},
                      {1.51710916f, 0.315731168f, 0.00753469858f, 0.000992023619f, 1.21776518e-08f}}}};
    for (int i = 0; i < RUNS(2, 0); i++)
    {
        config = (tribo_controller_f32_config_t){.sections = cascades[i].sections, .section_count = 4};
        norms_t norms;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, init_within(1.0f));
        TEST_ASSERT_TRUE(find_norms(&norms, 1.5, 3000000));
        for (uint32_t j = 0; j < 4u; j++)
        {
            const double ratio = (double)headroom.output[j] / node_peak(&norms, j);
            printf("cascade %d, node %u: %.3f of the sum in double\n", i, (unsigned)j, ratio);
            TEST_ASSERT_TRUE(ratio > 1.0 && ratio < 1.2);
        }
        TEST_ASSERT_TRUE((double)headroom.input > norms.input);
    }
}

static int pauses;

static void count_pause(void)
{
    pauses++;
}

static void test_controller_set_up_pauses(void)
{
    const tribo_biquad_f32_section_t slow[]    = {{1.0f, 0.5001f, 0.5e-4f, 0.5002f, 1.0e-4f}};
    const tribo_biquad_f32_section_t outside[] = {{1.0f, -0.5f, 0.1f, 0.4f, 0.02f}}; // its zeros
    tribo_controller_f32_params_t    f32;
    config = (tribo_controller_f32_config_t){.sections      = slow,
                                             .section_count = 1,
                                             .u_min_n       = -1.0f,
                                             .u_max_n       = 1.0f,
                                             .pause         = count_pause};
    pauses = 0;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_q31_init(&params, &config, FULL_SCALE, NULL));
    TEST_ASSERT_TRUE(pauses > 500);
    config.sections = outside;
    pauses          = 0;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_controller_f32_init(&f32, &config));
    TEST_ASSERT_TRUE(pauses > 1);
}

// Coefficients up to 4 of their nodes: a gain of 2 b0 between scales is what fills them, not the peak.
static void test_controller_coefficients_stay_within_4(void)
{
    int by_coefficient = 0;
    for (float b0 = 64.0f; b0 < 256.0f; b0 *= RUNS(1.01f, 1.05f))
    {
        const tribo_biquad_f32_section_t sections[] = {gain_of(0.9f), gain_of(b0)};
        norms_t                          norms;
        config = (tribo_controller_f32_config_t){.sections = sections, .section_count = 2};
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, init_within(1.0f));
        TEST_ASSERT_TRUE(find_norms(&norms, 1.5, 100));
        (void)check_formats(&norms);
        by_coefficient += ldexp(MARGIN * node_peak(&norms, 1), 1 - params.cascade.section[1].scale) < 1.0;
    }
    TEST_ASSERT_TRUE(by_coefficient > 0);
}

// 2^24 is the most that a node may need: u within 1 N of 2 N gives s within 1.5, and 1.5/D at the input.
static void test_controller_takes_peaks_up_to_2_to_the_24_and_no_further(void)
{
    const float most = (float)(1.5 * MARGIN / 0x1p24); // D
    for (int beyond = 0; beyond < 2; beyond++)
    {
        const tribo_biquad_f32_section_t sections[] = {gain_of(1.0e-3f),
                                                       gain_of(1.0e3f * most * (beyond != 0 ? 0.99f : 1.01f))};
        config = (tribo_controller_f32_config_t){.sections = sections, .section_count = 2};
        TEST_ASSERT_EQUAL_INT(beyond != 0 ? TRIBO_ERR_HEADROOM : TRIBO_OK, init_within(1.0f));
    }
    TEST_ASSERT_EQUAL_INT(24, params.cascade.input_scale); // of the one that was taken
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_controller_takes_whatever_an_input_can_be(void)
{
    const int32_t inputs[] = {INT32_MIN, -INT32_MAX, -1, 0, 1, INT32_MAX};
    random_t      r        = {1};
    for (int k = 0; k < 20000; k++)
    {
        const int32_t e = inputs[random_bits(&r) % 6u];
        const int32_t f = inputs[random_bits(&r) % 6u];
        const int32_t u = controller_q31_step(&params, &state, e, f, &seen);
        TEST_ASSERT_TRUE(u >= params.u_min && u <= params.u_max);
    }
}

// What is taken from v is 2^31 then, which does not fit: as signed numbers it would change its sign.
static void test_controller_corrects_towards_a_limit_of_0_from_the_very_end(void)
{
    params                       = (tribo_controller_q31_params_t){.u_min             = 0,
                                                                   .u_max             = INT32_MAX,
                                                                   .anti_windup       = 3 << 29, // 3/4
                                                                   .anti_windup_shift = 1,
                                                                   .taken_max         = INT32_MAX};
    params.cascade.count         = 2;
    params.cascade.input_scale   = 2;
    params.cascade.section[0].b0 = 1 << 28; // and no more: w1 is then the corrected output
    state.cascade.section[1].w1  = -(INT64_C(1) << 59);
    TEST_ASSERT_EQUAL_INT32(0, controller_q31_step(&params, &state, 0, 0, &seen));
    TEST_ASSERT_TRUE(seen.limited);
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, seen.v);
    TEST_ASSERT_EQUAL_UINT32(1, state.cascade.saturated);
    TEST_ASSERT_INT32_WITHIN(16, INT32_MAX / 4 * 3, (int32_t)(state.cascade.section[0].w1 >> 28));
}

// c/D = 3/2, or 3/4 before a gain of 2: beyond full scale, where it must not change its sign.
static void test_controller_bounds_a_correction_and_counts(void)
{
    for (int i = 0; i < 4; i++)
    {
        const int32_t sign           = i % 2 == 0 ? 1 : -1;
        const bool    by_gain        = i / 2 == 1;
        params                       = (tribo_controller_q31_params_t){.anti_windup       = 3 << 29,
                                                                       .anti_windup_shift = by_gain ? 1 : 2,
                                                                       .taken_max         = INT32_MAX / 3 * 2};
        params.cascade.count         = 2;
        params.cascade.input_scale   = 2;
        params.cascade.section[0].b0 = by_gain ? 1 << 29 : 1 << 28; // and no more: w1 is then the corrected output
        tribo_controller_q31_reset(&state);
        TEST_ASSERT_EQUAL_INT32(0, controller_q31_step(&params, &state, 0, -sign * INT32_MAX, &seen));
        TEST_ASSERT_TRUE(seen.limited);
        TEST_ASSERT_INT32_WITHIN(32, sign * INT32_MAX, (int32_t)(state.cascade.section[0].w1 >> 28));
        TEST_ASSERT_EQUAL_UINT32(1, state.cascade.saturated);
    }
}

static void test_controller_takes_the_very_most_without_counting(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        params                     = (tribo_controller_q31_params_t){.taken_max = 1000, .anti_windup_shift = 1};
        params.cascade.count       = 2;
        params.cascade.input_scale = 2;
        (void)controller_q31_step(&params, &state, 0, sign * 1000, &seen);
        TEST_ASSERT_TRUE(seen.limited);
        TEST_ASSERT_EQUAL_UINT32(sign < 0 ? 0 : 1, state.cascade.saturated);
        (void)controller_q31_step(&params, &state, 0, sign * 1001, &seen);
        TEST_ASSERT_EQUAL_UINT32(sign < 0 ? 1 : 2, state.cascade.saturated);
    }
}

static void test_controller_puts_a_lost_state_to_rest(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        tribo_controller_q31_reset(&state);
        for (int i = 0; i < 2; i++)
        {
            state.cascade.section[i].w1 = sign * (INT64_C(1) << 60);
        }
        TEST_ASSERT_EQUAL_INT32(0, step(0.0, 0.0));
        TEST_ASSERT_FALSE(seen.limited);
        TEST_ASSERT_EQUAL_UINT32(2, state.cascade.saturated);
    }
}

static void test_controller_sums_what_is_beyond_full_scale_alone(void)
{
    const double D = (double)paper[0].b0 * (double)paper[1].b0;
    const double u = step(1.9, -1.9) / 2147483648.0 * (double)FULL_SCALE;
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, seen.v); // 1.9 D
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 1.9 * D - 1.9, u);
    TEST_ASSERT_FALSE(seen.limited);
}

// Against 64 bits: v of all sizes, at the limits to the bit and where only v, not v + feedforward, is beyond full scale.
static void test_controller_limits_exactly_the_sum(void)
{
    const int32_t ends[] = {INT32_MIN, -INT32_MAX, -1, 0, 1, INT32_MAX};
    random_t      r      = {4};
    for (uint32_t scale = 0; scale <= 24u; scale++)
    {
        params                          = (tribo_controller_q31_params_t){.anti_windup_shift = 1};
        params.cascade.count            = 2;
        params.cascade.input_scale      = 2; // an e of whole fours comes through to the bit
        params.cascade.section[0].b0    = INT32_C(1) << 28;
        params.cascade.section[1].b0    = INT32_C(1) << (scale == 0u ? 29 : 28);
        params.cascade.section[1].scale = (uint8_t)scale;
        params.cascade.output_scale     = (uint8_t)scale;
        for (int k = 0; k < 2000; k++)
        {
            const bool widest   = random_bits(&r) % 4u == 0u;
            params.u_min        = widest ? -INT32_MAX : -(int32_t)(random_bits(&r) % 2147483647u);
            params.u_max        = widest ? INT32_MAX : (int32_t)(random_bits(&r) % 2147483647u);
            const int32_t limit = random_bits(&r) % 2u == 0u ? params.u_min : params.u_max;
            const int32_t node  = (int32_t)(uint32_t)random_bits(&r) >> (random_bits(&r) % 2u == 0u ? scale : 0u) >> 2;
            const int32_t e     = node * 4;
            const int64_t v     = (int64_t)(scale == 0u ? node * 2 : node) * (INT32_C(1) << scale);
            const int64_t to_meet = limit - v + (int64_t)(random_bits(&r) % 3u) - 1;
            const bool    meets   = to_meet >= INT32_MIN && to_meet <= INT32_MAX;
            const int32_t added   = meets ? (int32_t)to_meet : ends[random_bits(&r) % 6u];
            const int64_t sum     = v + added;
            const int64_t u       = sum < params.u_min ? params.u_min : (sum > params.u_max ? params.u_max : sum);
            tribo_controller_q31_reset(&state);
            TEST_ASSERT_EQUAL_INT64(u, controller_q31_step(&params, &state, e, added, &seen));
            TEST_ASSERT_EQUAL_INT(u != sum, seen.limited);
            TEST_ASSERT_EQUAL_UINT32(u != sum, state.limited_ticks);
            TEST_ASSERT_EQUAL_INT64(v > INT32_MAX ? INT32_MAX : (v < INT32_MIN ? INT32_MIN : v), seen.v);
        }
    }
}

// What is logged is what is put out, at a limit and within.
static void test_controller_signals_hold_the_u_that_it_returns(void)
{
    uint32_t at_a_limit = 0;
    for (int k = 0; k < 200; k++)
    {
        seen.u          = 0x5a5a5a5a;
        const int32_t u = step(0.001 * sin(k * 0.1), 0.8 * sin(k * 0.1));
        TEST_ASSERT_EQUAL_INT32(u, seen.u);
        at_a_limit += seen.limited;
    }
    TEST_ASSERT_TRUE(at_a_limit > 10u && at_a_limit < 190u);
}

#include "runners/test_controller_q31.inc" // main
