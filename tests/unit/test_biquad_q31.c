// What only the Q31 arithmetic has. What both promise: tests/contract/test_biquad.c.

#include "cascade_q31.h"
#include "tribo/paper_controller.h"

#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define LONG_RUN RUNS(10000000, 20000)

#define W_MAX ((INT64_C(1) << 61) - 1)

static tribo_biquad_q31_params_t  params;
static tribo_biquad_q31_state_t   state;
static tribo_biquad_q31_outputs_t nodes;
static tribo_headroom_q31_t       headroom;

void setUp(void)
{
    tribo_biquad_q31_reset(&state);
}

/// `count` sections that give nothing and forget nothing but what they gave: a1 = 1.
static tribo_biquad_q31_params_t blank(uint32_t count)
{
    tribo_biquad_q31_params_t made = {.count = (uint8_t)count, .input_scale = 2};
    for (uint32_t i = 0; i < count; i++)
    {
        made.section[i].minus_a1 = -(INT32_C(1) << 28);
    }
    return made;
}

/// The end of the range on the side of `sign`.
static int32_t end_of(int sign)
{
    return sign < 0 ? -INT32_MAX : INT32_MAX;
}

static void init(const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, cascade_q31_init(&params, sections, count, &headroom));
    tribo_biquad_q31_reset(&state);
}

/// The cascade in double, with the numbers that `params` really has.
typedef struct
{
    struct
    {
        double b0, b1, b2, a1, a2, w1, w2, y;
    } section[TRIBO_BIQUAD_SECTIONS_MAX];
    uint32_t count;
} exact_t;

static exact_t exact_of(const tribo_biquad_q31_params_t *p)
{
    exact_t x      = {.count = p->count};
    int     before = p->input_scale;
    for (uint32_t i = 0; i < p->count; i++)
    {
        const tribo_biquad_q31_section_t *s  = &p->section[i];
        const int                         by = s->scale - before;
        x.section[i].b0                      = ldexp(s->b0, by - 28);
        x.section[i].b1                      = ldexp(s->c1 + s->b0, by - 28);
        x.section[i].b2                      = ldexp(s->c2, by - 28 - s->shift);
        x.section[i].a1                      = -ldexp(s->minus_a1, -28);
        x.section[i].a2                      = -ldexp(s->d2, -28 - s->shift) - ldexp(s->d2_low, -60 - s->shift);
        before                               = s->scale;
    }
    return x;
}

static double exact_step(exact_t *x, double in)
{
    for (uint32_t i = 0; i < x->count; i++)
    {
        const double out = x->section[i].b0 * in + x->section[i].w1;
        x->section[i].w1 += x->section[i].b1 * in - x->section[i].a1 * out + x->section[i].w2;
        x->section[i].w2 += x->section[i].b2 * in - x->section[i].a2 * out;
        x->section[i].y = out;
        in              = out;
    }
    return in;
}

static int32_t node[TRIBO_BIQUAD_SECTIONS_MAX]; // outputs of the sections in the last tick

/// Between the halves of a tick: y = w1 + b0 x of each section, where nothing saturates.
static void note_nodes(void)
{
    int32_t x = nodes.x;
    for (uint32_t i = 0; i < params.count; i++)
    {
        x       = (int32_t)((state.section[i].w1 + (int64_t)params.section[i].b0 * x) >> 28);
        node[i] = x;
    }
}

/// One step without the narrowing at its end.
static double wide_step(int32_t x)
{
    const int64_t y = cascade_q31_output(&params, &state, x, &nodes);
    note_nodes();
    biquad_q31_advance(&params, &state, &nodes, 0);
    return (double)y;
}

static tribo_biquad_f32_section_t section_from_roots(double gain, double q, double turn, double p, double angle)
{
    // In d = z - 1 a pair r e^+-ja gives d^2 + 2 (1 - r cos a) d + (1 - 2 r cos a + r^2).
    const double b1 = 2.0 * (1.0 - q * cos(turn));
    const double b2 = 1.0 - 2.0 * q * cos(turn) + q * q;
    return (tribo_biquad_f32_section_t){(float)gain,
                                        (float)(gain * b1),
                                        (float)(gain * b2),
                                        (float)(2.0 * (1.0 - p * cos(angle))),
                                        (float)(1.0 - 2.0 * p * cos(angle) + p * p)};
}

static tribo_biquad_f32_section_t random_section(random_t *r)
{
    return section_from_roots(random_between(r, 0.1, 3.0),
                              random_between(r, 0.0, 1.5),
                              random_between(r, 0.0, 3.1),
                              random_between(r, 0.0, 0.97),
                              random_between(r, 0.0, 3.1));
}

// --- the equation ------------------------------------------------------------------------------------------------

static void test_biquad_is_its_equation_to_a_few_bits_of_its_node(void)
{
    random_t r = {7};
    for (int i = 0; i < 30; i++)
    {
        tribo_biquad_f32_section_t sections[TRIBO_BIQUAD_SECTIONS_MAX];
        const uint32_t             count = 1u + (uint32_t)i % TRIBO_BIQUAD_SECTIONS_MAX;
        for (uint32_t j = 0; j < count; j++)
        {
            sections[j] = random_section(&r);
        }
        init(sections, count);
        exact_t      exact = exact_of(&params);
        const double unit  = ldexp(1.0, params.section[count - 1u].scale);
        for (int k = 0; k < 500; k++)
        {
            const int32_t x        = (int32_t)random_between(&r, -2147483647.0, 2147483647.0);
            const double  expected = exact_step(&exact, (double)x);
            // Each node rounds once; later sections amplify what earlier ones rounded.
            TEST_ASSERT_DOUBLE_WITHIN(3000.0 * unit, expected, wide_step(x));
        }
        TEST_ASSERT_EQUAL_UINT32(0, state.saturated);
    }
}

static void test_biquad_one_section_is_exact_to_its_rounding(void)
{
    const tribo_biquad_f32_section_t fir[] = {{0.25f, 0.25f, 0.125f, 2.0f, 1.0f}}; // both poles at z = 0
    init(fir, 1);
    // 0.25 d^2 + 0.25 d + 0.125 is 0.25 - 0.25 z^-1 + 0.125 z^-2.
    TEST_ASSERT_EQUAL_INT32(250, cascade_q31_step(&params, &state, 1000));
    TEST_ASSERT_EQUAL_INT32(0, cascade_q31_step(&params, &state, 1000));
    TEST_ASSERT_EQUAL_INT32(125, cascade_q31_step(&params, &state, 1000));
    TEST_ASSERT_EQUAL_INT32(125, cascade_q31_step(&params, &state, 1000));
}

/// Signal to noise in dB of a Butterworth low pass at `fc` of the sample rate, for a sine of half full scale at fc/2.
static double signal_to_noise_db(double fc)
{
    const double k = tan(acos(-1.0) * fc);
    const double a = 1.0 + sqrt(2.0) * k + k * k;
    // Tustin in d = z - 1: (k^2 (d + 2)^2) / (d^2 a + d (2 sqrt(2) k + 4 k^2) + 4 k^2)
    const tribo_biquad_f32_section_t section[] = {{(float)(k * k / a),
                                                   (float)(4.0 * k * k / a),
                                                   (float)(4.0 * k * k / a),
                                                   (float)((2.0 * sqrt(2.0) * k + 4.0 * k * k) / a),
                                                   (float)(4.0 * k * k / a)}};
    init(section, 1);
    exact_t   exact   = exact_of(&params);
    double    signal  = 0.0;
    double    noise   = 0.0;
    const int settle  = (int)(3.0 / fc);
    const int measure = LONG_RUN > 1000000 ? 300000 : 2000;
    for (int i = 0; i < settle + measure; i++)
    {
        const int32_t x     = (int32_t)round(1073741824.0 * sin(acos(-1.0) * fc * i));
        const double  ideal = exact_step(&exact, (double)x);
        const double  error = (double)cascade_q31_step(&params, &state, x) - ideal;
        signal += i >= settle ? ideal * ideal : 0.0;
        noise += i >= settle ? error * error : 0.0;
    }
    TEST_ASSERT_EQUAL_UINT32(0, state.saturated);
    const double snr = 10.0 * log10(signal / noise);
    printf("fc/fs %g: %.1f dB\n", fc, snr);
    return snr;
}

static void test_biquad_signal_to_noise_at_low_corner_frequencies(void)
{
    TEST_ASSERT_TRUE(signal_to_noise_db(0.1) >= 175.0);
    TEST_ASSERT_TRUE(signal_to_noise_db(0.01) >= 160.0);
    TEST_ASSERT_TRUE(signal_to_noise_db(0.001) >= 140.0);
    TEST_ASSERT_TRUE(LONG_RUN < 1000000 || signal_to_noise_db(0.0001) >= 140.0);
}

// 1/3 of full scale and less than a bit a tick into a slow low pass: nothing may be lost.
static void test_biquad_gain_at_rest_is_exact_for_as_long_as_it_runs(void)
{
    const tribo_biquad_f32_section_t slow[]   = {{0.0f, 0.0f, 3.0e-6f, 0.3f, 3.0e-6f}}; // gain 1, pole 1e-5
    const int32_t                    inputs[] = {715827883, 3, -1, -1234567};
    init(slow, 1);
    const exact_t exact = exact_of(&params);
    const double  gain  = exact.section[0].b2 / exact.section[0].a2;
    for (size_t i = 0; i < sizeof inputs / sizeof inputs[0]; i++)
    {
        tribo_biquad_q31_reset(&state);
        double sum = 0.0;
        for (int k = 0; k < LONG_RUN / 4; k++)
        {
            const int32_t y = cascade_q31_step(&params, &state, inputs[i]);
            sum += k >= LONG_RUN / 4 - 100000 ? y : 0;
        }
        // The mean, as the output's last bits may toggle.
        TEST_ASSERT_TRUE(LONG_RUN < 1000000 ||
                         fabs(sum / 100000.0 - gain * inputs[i]) <= ldexp(1.0, params.section[0].scale));
    }
    TEST_ASSERT_EQUAL_UINT32(0, state.saturated);
}

// Bits of the input below its node's last are not lost either.
static void test_biquad_carries_what_the_input_scale_drops(void)
{
    params               = blank(1);
    params.section[0].b0 = INT32_C(1) << 28;
    params.section[0].c1 = -(INT32_C(1) << 28);
    params.input_scale   = 4;
    int64_t sum          = 0;
    int64_t came         = 0;
    for (int k = 0; k < LONG_RUN; k++)
    {
        const int32_t x = k % 2 == 0 ? 7 : k % 37 - 11;
        (void)cascade_q31_output(&params, &state, x, &nodes);
        came += x;
        sum += nodes.x;
        TEST_ASSERT_EQUAL_INT64(came, sum * 16 + (state.carry >> 28));
        biquad_q31_advance(&params, &state, &nodes, 0);
    }
}

static void test_biquad_integrates_as_a_counter_does(void)
{
    // y = w1, w1 += 2^-28 x: an integrator by hand, a tick's change far below the last bit.
    params                     = blank(1);
    params.section[0].c1       = 1;
    params.section[0].minus_a1 = 0;
    for (int k = 0; k < LONG_RUN; k++)
    {
        (void)cascade_q31_step(&params, &state, 4 * 12345);
    }
    const int64_t half = INT64_C(1) << 27; // with which w1 starts
    TEST_ASSERT_EQUAL_INT64((int64_t)LONG_RUN * 12345 + half, state.section[0].w1);
}

// The second section halves 1: what it rounds off is its own, not that of the first, and comes out in every other tick.
static void test_biquad_sections_keep_their_own_rests(void)
{
    params               = blank(2);
    params.section[0].b0 = INT32_C(1) << 28;
    params.section[1].b0 = INT32_C(1) << 27;
    tribo_biquad_q31_reset(&state);
    int32_t sum = 0;
    for (int k = 0; k < 1000; k++)
    {
        sum += cascade_q31_step(&params, &state, 4); // 1 at the input node
    }
    TEST_ASSERT_EQUAL_INT32(500, sum);
}

static void test_biquad_output_stays_in_the_symmetric_range(void)
{
    {
        params                  = blank(2);
        params.section[0].b0    = INT32_C(1) << 29;
        params.section[1].b0    = INT32_C(1) << 28;
        params.section[0].scale = 1;
        params.section[1].scale = 1;
        params.output_scale     = 1;
        tribo_biquad_q31_reset(&state);
        TEST_ASSERT_EQUAL_INT32(-INT32_MAX, cascade_q31_step(&params, &state, INT32_MIN));
        TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
        tribo_biquad_q31_reset(&state);
        TEST_ASSERT_EQUAL_INT32(-INT32_MAX + 3, cascade_q31_step(&params, &state, -INT32_MAX + 3));
        TEST_ASSERT_EQUAL_INT32(INT32_MAX - 3, cascade_q31_step(&params, &state, INT32_MAX - 3));
        TEST_ASSERT_EQUAL_UINT32(0, state.saturated);

        // The last node's last value that fits, and the next.
        for (int sign = -1; sign <= 1; sign += 2)
        {
            const int64_t last = INT32_MAX / 2;
            for (int64_t beyond = 0; beyond <= 1; beyond++)
            {
                tribo_biquad_q31_reset(&state);
                state.section[1].w1 = sign * (last + beyond) * (INT64_C(1) << 28);
                const int64_t y     = beyond != 0 ? end_of(sign) : sign * last * 2;
                TEST_ASSERT_EQUAL_INT64(y, cascade_q31_step(&params, &state, 0));
                TEST_ASSERT_EQUAL_UINT32(beyond, state.saturated);
            }
        }
    }
}

// --- limit cycles ------------------------------------------------------------------------------------------------

/// Largest held output after the input has been 0 for long.
static int32_t left_over(int decay, int watched)
{
    for (int k = 0; k < decay; k++)
    {
        (void)wide_step(0);
    }
    int32_t worst = 0;
    for (int k = 0; k < watched; k++)
    {
        (void)wide_step(0);
        const int32_t y = node[params.count - 1u];
        worst           = y > worst ? y : (-y > worst ? -y : worst);
    }
    return worst;
}

static void test_biquad_comes_to_rest_at_zero_input(void)
{
    random_t r     = {2024};
    int32_t  worst = 0;
    for (int i = 0; i < RUNS(20, 4); i++)
    {
        const double                     p         = 1.0 - pow(10.0, random_between(&r, -2.0, 0.0));
        const tribo_biquad_f32_section_t section[] = {
            section_from_roots(random_between(&r, 0.01, 2.0), 0.9, 1.0, p, random_between(&r, 0.0, 3.1))};
        init(section, 1);
        for (int k = 0; k < 100; k++)
        {
            (void)wide_step((int32_t)random_between(&r, -2147483647.0, 2147483647.0));
        }
        const int32_t left = left_over(60000, 3000);
        worst              = left > worst ? left : worst;
    }
    printf("largest zero-input limit cycle of any section: %d LSB\n", (int)worst);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(64, worst);
}

/// Half the L1 norm of (1 - z^-1)^2/A(z): what y of poles p e^+-ja can be when all that comes in is a rounding of half a bit a
/// tick. Rounding has two zeros at z = 1, as what it drops is carried.
static double rounding_peak(double p, double a)
{
    const double c   = 2.0 * p * cos(a);
    double       sum = 0.0;
    double       y1  = 0.0;
    double       y2  = 0.0;
    for (int k = 0; k < 3000; k++)
    {
        const double y = (k == 0 || k == 2 ? 1.0 : (k == 1 ? -2.0 : 0.0)) + c * y1 - p * p * y2;
        sum += fabs(y);
        y2 = y1;
        y1 = y;
    }
    return sum / 2.0;
}

// Radii from 0.9 to 0.99, where limit cycles are. Beyond 2.7 rad (0.43 of the sample rate) they reach hundreds of bits.
static void test_biquad_limit_cycles_are_what_rounding_makes_of_the_poles(void)
{
    random_t  r          = {5};
    const int runs       = LONG_RUN > 1000000 ? 1000 : 2;
    int32_t   worst      = 0;
    int32_t   worst_high = 0;
    for (int i = 0; i < runs; i++)
    {
        const double                     p         = 1.0 - pow(10.0, random_between(&r, -2.0, -1.0));
        const double                     angle     = random_between(&r, 0.0, 3.14);
        const tribo_biquad_f32_section_t section[] = {
            section_from_roots(random_between(&r, 0.01, 2.0), 0.9, 1.0, p, angle)};
        init(section, 1);
        for (int k = 0; k < 100; k++)
        {
            (void)wide_step((int32_t)random_between(&r, -2147483647.0, 2147483647.0));
        }
        const int32_t  left = left_over(4500, 1500);
        int32_t *const most = angle <= 2.7 ? &worst : &worst_high;
        *most               = left > *most ? left : *most;
        TEST_ASSERT_TRUE(left <= rounding_peak(p, angle) + 1.0);
    }
    printf("largest zero-input limit cycle up to 2.7 rad: %d LSB, beyond: %d LSB\n", (int)worst, (int)worst_high);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(64, worst);
    TEST_ASSERT_TRUE(LONG_RUN < 1000000 || worst_high > 64);
}

static void test_biquad_of_the_papers_controller_comes_to_rest_within_a_bit(void)
{
    const tribo_biquad_f32_section_t paper[] = TRIBO_PAPER_CONTROLLER_F32;
    init(paper, 2);
    for (int k = 0; k < 50; k++)
    {
        (void)wide_step(k % 3 == 0 ? 20000 : -7000);
    }
    // Its slow pole takes 5e5 ticks for each factor of e.
    const int32_t left = left_over(LONG_RUN, 10000);
    printf("zero-input limit cycle of the paper's controller: %d LSB\n", (int)left);
    TEST_ASSERT_TRUE(LONG_RUN < 1000000 || left <= 1);
}

// --- headroom ----------------------------------------------------------------------------------------------------

#define HISTORY 1500

/// Plays the worst input for node i: the signs of its impulse response backwards. Returns its peak in full scales.
static double play_worst_case(uint32_t i)
{
    static bool negative[HISTORY]; // not the response itself, for which the smallest target has no room
    exact_t     exact = exact_of(&params);
    for (int k = 0; k < HISTORY; k++)
    {
        (void)exact_step(&exact, k == 0 ? 1.0 : 0.0);
        negative[k] = exact.section[i].y < 0.0;
    }
    tribo_biquad_q31_reset(&state);
    double peak = 0.0;
    for (int k = HISTORY; k-- > 0;)
    {
        (void)wide_step(negative[k] ? -INT32_MAX : INT32_MAX);
        peak = fmax(peak, fabs((double)node[i]));
    }
    return ldexp(peak, params.section[i].scale - 31);
}

static void test_biquad_headroom_holds_the_worst_input_and_no_more_than_that(void)
{
    random_t     r     = {99};
    const double slack = 1.06; // two margins of 2 %, and the tail
    for (int i = 0; i < RUNS(40, 8); i++)
    {
        tribo_biquad_f32_section_t sections[TRIBO_BIQUAD_SECTIONS_MAX];
        const uint32_t             count = 1u + (uint32_t)i % TRIBO_BIQUAD_SECTIONS_MAX;
        for (uint32_t j = 0; j < count; j++)
        {
            sections[j] = random_section(&r);
        }
        init(sections, count);
        for (uint32_t at = 0; at < count; at++)
        {
            const double peak = play_worst_case(at);
            TEST_ASSERT_EQUAL_UINT32(0, state.saturated);
            TEST_ASSERT_TRUE(peak <= (double)headroom.output[at]);
            TEST_ASSERT_TRUE(peak * slack >= (double)headroom.output[at]);
            TEST_ASSERT_TRUE((double)headroom.output[at] < ldexp(1.0, params.section[at].scale));
        }
        tribo_biquad_q31_reset(&state);
        for (int k = 0; k < 5000; k++)
        {
            (void)wide_step((random_bits(&r) & 1u) != 0u ? INT32_MAX : -INT32_MAX);
        }
        TEST_ASSERT_EQUAL_UINT32(0, state.saturated);
    }
}

// b1 = 1.2345e-8 is 13.25 units of 2^-30, and runs as 13: 2 % less.
static void test_biquad_headroom_is_that_of_the_numbers_that_run(void)
{
    const tribo_biquad_f32_section_t section[] = {{0.0f, 1.2345e-8f, 0.0f, 1.0f, 0.5f}};
    init(section, 1);
    exact_t exact = exact_of(&params);
    double  peak  = 0.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 13.0 * 0x1p-30, exact.section[0].b1);
    for (int k = 0; k < 200; k++)
    {
        peak += fabs(exact_step(&exact, k == 0 ? 1.0 : 0.0));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * peak, 1.02 * peak, (double)headroom.output[0]);
}

// Poles are zeros, at z = 0.5: y is 2^20 times `gain` of x, and the set-up adds 2 %.
static void test_biquad_takes_a_peak_up_to_2_to_the_24_and_no_further(void)
{
    for (int beyond = 0; beyond < 2; beyond++)
    {
        const float                      gain      = 0x1p4f / 1.02f * (beyond != 0 ? 1.001f : 0.999f);
        const tribo_biquad_f32_section_t section[] = {{0x1p10f, 0x1p10f, 0x1p8f, 1.0f, 0.25f},
                                                      {0x1p10f, 0x1p10f, 0x1p8f, 1.0f, 0.25f},
                                                      {gain, gain, 0.25f * gain, 1.0f, 0.25f}};
        const tribo_status_t             expected  = beyond != 0 ? TRIBO_ERR_HEADROOM : TRIBO_OK;
        TEST_ASSERT_EQUAL_INT(expected, cascade_q31_init(&params, section, 3, &headroom));
    }
    TEST_ASSERT_EQUAL_INT(24, params.section[2].scale); // of the one that was taken
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_biquad_step_saturates_its_output_and_counts(void)
{
    const tribo_biquad_f32_section_t twice[] = {{2.0f, 4.0f, 2.0f, 2.0f, 1.0f}};
    init(twice, 1);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cascade_q31_step(&params, &state, 1200000000));
    TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, cascade_q31_step(&params, &state, INT32_MIN));
    TEST_ASSERT_EQUAL_UINT32(2, state.saturated);
    const int32_t y = cascade_q31_step(&params, &state, 100);
    TEST_ASSERT_INT32_WITHIN(8, 200, y); // nothing of it stays
}

static void test_biquad_restarts_each_section_that_is_beyond_its_node(void)
{
    const int32_t full = (INT32_C(1) << 30) - 1; // a gain of almost 4 ...
    for (uint32_t at = 0; at < 3u; at++)
    {
        for (int sign = -1; sign <= 1; sign += 2)
        {
            params = blank(at < 2u ? 2 : 3);
            for (uint32_t i = 0; i < params.count; i++)
            {
                params.section[i].b0 = i == at ? full : INT32_C(1) << 26; // ... where the others have 1/4
                params.section[i].c1 = -params.section[i].b0;
            }
            tribo_biquad_q31_reset(&state);
            state.section[at > 0u ? at - 1u : 0u].w1 = (int64_t)end_of(sign) * (INT64_C(1) << 27);
            state.section[at].w2                     = 1;
            const int64_t last                       = cascade_q31_output(&params, &state, end_of(sign), &nodes);
            TEST_ASSERT_EQUAL_INT64(0, at < 2u ? nodes.y[at] : last);
            TEST_ASSERT_EQUAL_INT64(INT64_C(1) << 27, state.section[at].w1);
            TEST_ASSERT_EQUAL_INT64(0, state.section[at].w2);
            TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
            TEST_ASSERT_TRUE(at == 0u || state.section[at - 1u].w1 != INT64_C(1) << 27);
        }
    }
}

static void lose(int sign)
{
    for (uint32_t i = 0; i < params.count; i++)
    {
        state.section[i].w1 = sign < 0 ? INT64_MIN : INT64_MAX;
        state.section[i].w2 = sign < 0 ? INT64_MIN : INT64_MAX;
    }
}

static void test_biquad_keeps_a_lost_state_in_range_and_recovers(void)
{
    const tribo_biquad_f32_section_t section[] = {{0.5f, 0.1f, 0.05f, 0.5f, 0.1f}, {1.0f, 0.2f, 0.05f, 0.9f, 0.3f}};
    for (uint32_t count = 1; count <= 2u; count++)
    {
        init(section, count);
        for (int sign = -1; sign <= 1; sign += 2)
        {
            tribo_biquad_q31_reset(&state);
            lose(sign);
            (void)cascade_q31_step(&params, &state, end_of(sign));
            TEST_ASSERT_TRUE(state.saturated > 0u);
            for (uint32_t i = 0; i < count; i++)
            {
                TEST_ASSERT_TRUE(state.section[i].w2 >= -W_MAX && state.section[i].w2 <= W_MAX);
            }
            state.section[0].w2    = sign < 0 ? -W_MAX : W_MAX;
            nodes.y[0]             = end_of(-sign);
            nodes.x                = end_of(sign);
            const uint32_t counted = state.saturated;
            biquad_q31_advance(&params, &state, &nodes, 0);
            TEST_ASSERT_EQUAL_INT64(0, state.section[0].w2);
            TEST_ASSERT_TRUE(state.saturated > counted);
            for (int k = 0; k < 5000; k++)
            {
                (void)wide_step(0);
            }
            TEST_ASSERT_INT32_WITHIN(64, 0, node[count - 1u]);
        }
    }
}

static void test_biquad_advances_as_if_the_corrected_input_had_come(void)
{
    random_t                   r          = {3};
    tribo_biquad_f32_section_t sections[] = {random_section(&r), random_section(&r)};
    init(sections, 2);
    tribo_biquad_q31_state_t corrected = state;
    for (int k = 0; k < 200; k++)
    {
        const int32_t x = (int32_t)random_between(&r, -1e8, 1e8);
        const int32_t c = (int32_t)random_between(&r, -1e8, 1e8) >> params.input_scale;
        (void)cascade_q31_output(&params, &corrected, x, &nodes);
        biquad_q31_advance(&params, &corrected, &nodes, c);
        (void)wide_step((int32_t)((int64_t)x + (int64_t)c * (1 << params.input_scale)));
        for (uint32_t i = 0; i < 2u; i++)
        {
            TEST_ASSERT_DOUBLE_WITHIN(0x1p36, (double)state.section[i].w1, (double)corrected.section[i].w1);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0, corrected.saturated);
    for (int sign = -1; sign <= 1; sign += 2)
    {
        corrected.saturated = 0;
        (void)cascade_q31_output(&params, &corrected, end_of(sign), &nodes);
        biquad_q31_advance(&params, &corrected, &nodes, end_of(sign));
        TEST_ASSERT_TRUE(corrected.saturated > 0u);
    }
}

// --- change of params --------------------------------------------------------------------------------------------

static void test_biquad_change_keeps_the_output_and_its_slope(void)
{
    random_t r           = {17};
    int      unsaturated = 0;
    for (int i = 0; i < RUNS(200, 40); i++)
    {
        tribo_biquad_f32_section_t from_sections[TRIBO_BIQUAD_SECTIONS_MAX];
        tribo_biquad_f32_section_t to_sections[TRIBO_BIQUAD_SECTIONS_MAX];
        tribo_biquad_q31_params_t  to;
        const uint32_t             from_count = 1u + (uint32_t)(random_bits(&r) % 4u);
        const uint32_t             to_count   = 1u + (uint32_t)(random_bits(&r) % 4u);
        for (uint32_t j = 0; j < TRIBO_BIQUAD_SECTIONS_MAX; j++)
        {
            from_sections[j] = random_section(&r);
            to_sections[j]   = random_section(&r);
        }
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, cascade_q31_init(&to, to_sections, to_count, NULL));
        init(from_sections, from_count);
        for (int k = 0; k < 50; k++)
        {
            (void)wide_step((int32_t)(1e8 * sin(k * 0.1)));
        }
        tribo_biquad_q31_state_t       old    = state;
        const int32_t                  offset = i % 2 == 0 ? 0 : 100000;
        const tribo_biquad_q31_state_t before = old;
        tribo_biquad_q31_change(&params, &to, &state, 70000000, offset);
        if (state.saturated != before.saturated)
        {
            continue; // a node of `to` has not the room for what stood in one of `from`, and has said so
        }
        unsaturated++;
        tribo_biquad_q31_outputs_t old_nodes;
        const int64_t              expected = cascade_q31_output(&params, &old, 70000000, &old_nodes) + offset;
        const int64_t              found    = cascade_q31_output(&to, &state, 70000000, &nodes);
        // To the last bits of the coarser node, which a section's gain of b0 may follow.
        const double unit = ldexp(1.0, to.section[to_count - 1u].scale) * (double)(8 << to.input_scale) +
                            ldexp(1.0, params.section[from_count - 1u].scale);
        TEST_ASSERT_DOUBLE_WITHIN(64.0 * unit, (double)expected, (double)found);

        if (from_count == to_count && offset == 0)
        {
            // Its input standing, each output moves as its w1 does.
            const double was = (double)old.section[0].w1;
            const double is  = (double)state.section[0].w1;
            biquad_q31_advance(&params, &old, &old_nodes, 0);
            biquad_q31_advance(&to, &state, &nodes, 0);
            const double slope = ldexp((double)old.section[0].w1 - was, params.section[0].scale - 28);
            const double now   = ldexp((double)state.section[0].w1 - is, to.section[0].scale - 28);
            TEST_ASSERT_DOUBLE_WITHIN(ldexp(1.0, 10 + to.section[0].scale + params.section[0].scale + to.input_scale),
                                      slope,
                                      now);
        }
    }
    TEST_ASSERT_TRUE(unsaturated > RUNS(150, 30));
}

static void test_biquad_change_clamps_what_the_new_params_cannot_hold(void)
{
    params = (tribo_biquad_q31_params_t){.section = {{.b0 = 1, .c1 = -1, .scale = 4}}, .count = 1, .input_scale = 2};
    const tribo_biquad_q31_params_t to = {.section = {{.b0 = 1, .c1 = -1, .shift = 31}}, .count = 1, .input_scale = 2};
    for (int sign = -1; sign <= 1; sign += 2)
    {
        tribo_biquad_q31_reset(&state);
        state.section[0].w1 = sign * ((INT64_C(1) << 59) - (INT64_C(1) << 28));
        state.section[0].w2 = sign * (INT64_C(1) << 60);
        tribo_biquad_q31_change(&params, &to, &state, 0, 0);
        TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
        TEST_ASSERT_EQUAL_INT32(end_of(sign), (int32_t)(state.section[0].w1 >> 28));
        TEST_ASSERT_TRUE(sign * state.section[0].w2 > (INT64_C(1) << 60));
    }
    // A node can be at the very end, which is beyond the symmetric range.
    tribo_biquad_q31_reset(&state);
    state.section[0].w1 = -(INT64_C(1) << 59);
    tribo_biquad_q31_change(&params, &params, &state, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, (int32_t)(state.section[0].w1 >> 28));
}

// Both words of d2, in either section of a pair and in one alone.
static void test_biquad_feeds_back_by_both_words_of_d2(void)
{
    const int32_t words[][2] = {{0, 5 << 24}, {0, -(5 << 24)}, {3, INT32_MIN}, {-3, INT32_MAX}, {-1, -1}};
    for (size_t i = 0; i < 2u * 2u * sizeof words / sizeof words[0]; i++)
    {
        const int32_t  d2       = words[i / 4u][0];
        const int32_t  d2_low   = words[i / 4u][1];
        const int32_t  y        = i % 2u == 0u ? 123456789 : -123456789;
        const uint32_t section  = i / 2u % 2u;
        params                  = blank(1u + section);
        params.section[section] = (tribo_biquad_q31_section_t){.d2 = d2, .d2_low = d2_low, .shift = 30};
        tribo_biquad_q31_reset(&state);
        state.section[section].w1 = (int64_t)y * (INT64_C(1) << 28);
        (void)cascade_q31_step(&params, &state, 0);
        const int64_t low = (int64_t)d2_low * y;
        const int64_t one = INT64_C(1) << 32;
        TEST_ASSERT_EQUAL_INT64((int64_t)d2 * y + (low - (low < 0 ? one - 1 : 0)) / one, state.section[section].w2);
    }
}

// One at a time: the compare that serves all w2 must miss none, nor take what is in range for lost.
static void test_biquad_finds_each_w2_that_is_lost(void)
{
    const int64_t values[] = {W_MAX, W_MAX + 1, INT64_C(1) << 62, -W_MAX, -W_MAX - 2, -(INT64_C(1) << 62)};
    for (uint32_t count = 2; count <= 3u; count++)
    {
        params = blank(count);
        for (uint32_t i = 0; i < count; i++)
        {
            params.section[i].shift = 30;
        }
        for (uint32_t i = 0; i < count; i++)
        {
            for (size_t j = 0; j < sizeof values / sizeof values[0]; j++)
            {
                const int64_t x = values[j];
                tribo_biquad_q31_reset(&state);
                state.section[i].w2 = x;
                (void)cascade_q31_step(&params, &state, 0);
                const bool lost = x > W_MAX || x < -W_MAX;
                TEST_ASSERT_EQUAL_INT64(lost ? 0 : x, state.section[i].w2);
                TEST_ASSERT_EQUAL_UINT32(lost, state.saturated);
            }
        }
    }
}

#include "runners/test_biquad_q31.inc" // main
