#include "headroom_q31.h"

#include "../number/fixed_q31.h"
#include "biquad_f32.h"

#include <stddef.h>

// Headroom of a cascade in fixed point. The worst-case peak of a node for inputs bounded by 1 is the L1 norm of its impulse
// response, the sum of |h[k]| over all k. A node holds its value times 2^-scale with 2^scale above that peak, so no input
// within its bound can make it overflow.
//
// The inputs of a controller are e and s = u - feedforward, the applied output. With anti-windup the states follow s, so
// even an integrator has a bounded response. The norms are measured by running the f32 cascade on an impulse of each.

#define MARGIN      1.02f // on a measured peak: rounding of the sums and of the estimated tail
#define SCALE_MAX   24    // larger scales leave too few bits of a signal
#define BLOCK_TICKS 512u  // a response is summed in blocks
#define QUARTER     64u   // of BLOCKS
#define BLOCKS      (4u * QUARTER)

/// Sums of |x| over time for each signal x of a cascade: its L1 norms once the response has decayed.
typedef struct
{
    float input; // with the correction
    float correction;
    struct
    {
        float y, corrected, correction, w1, w2;
    } section[TRIBO_BIQUAD_SECTIONS_MAX];
} sums_t;

#define SUMS (sizeof(sums_t) / sizeof(float))

typedef union
{
    sums_t named;
    float  at[SUMS];
} peaks_t;

/// Adds one tick of the cascade to `block`, for an error `e` and an applied output `s`. `anti_windup` is c/D, or 0 for a
/// cascade alone.
static void add_tick(peaks_t                         *block,
                     const tribo_biquad_f32_params_t *cascade,
                     tribo_biquad_f32_state_t        *state,
                     float                            anti_windup,
                     float                            e,
                     float                            s)
{
    const uint32_t count = cascade->count;
    float          y[TRIBO_BIQUAD_SECTIONS_MAX];
    float          v = e;
    for (uint32_t i = 0; i < count; i++)
    {
        v    = biquad_f32_section_output(&cascade->section[i], &state->section[i], v);
        y[i] = v;
    }
    const float correction = (s - v) * anti_windup;
    float       in         = e + correction;
    float       c          = correction;
    block->named.input += magnitude(in);
    block->named.correction += magnitude(correction);
    for (uint32_t i = 0; i < count; i++)
    {
        c *= cascade->section[i].b0;
        const float out = y[i] + c;
        biquad_f32_section_advance(&cascade->section[i], &state->section[i], in, out);
        block->named.section[i].y += magnitude(y[i]);
        block->named.section[i].corrected += magnitude(out);
        block->named.section[i].correction += magnitude(c);
        block->named.section[i].w1 += magnitude(state->section[i].w1);
        block->named.section[i].w2 += magnitude(state->section[i].w2);
        in = out;
    }
}

/// True if three blocks, a quarter of the run apart, shrink by the same factor: only a single slow pole is left.
static bool is_geometric(float half, float three_quarters, float last)
{
    const float middle = three_quarters * three_quarters;
    return magnitude(half * last - middle) <= 1.0e-4f * middle;
}

/// Adds `weight` times the L1 norms of the responses to an impulse of e or of s. A response must decay to 1e-6 of its sum
/// within BLOCKS, or to a single slow pole, whose tail is the sum of a geometric series. False otherwise.
static bool add_response(peaks_t                         *peaks,
                         const tribo_biquad_f32_params_t *cascade,
                         float                            anti_windup,
                         bool                             of_s,
                         float                            weight)
{
    tribo_biquad_f32_state_t state;
    peaks_t                  sum            = {.at = {0.0f}};
    peaks_t                  half           = {.at = {0.0f}};
    peaks_t                  three_quarters = {.at = {0.0f}};
    peaks_t                  block          = {.at = {0.0f}};
    bool                     done           = false;
    tribo_biquad_f32_reset(&state);
    for (uint32_t i = 0; i < BLOCKS && !done; i++)
    {
        half           = i == 2u * QUARTER ? block : half;
        three_quarters = i == 3u * QUARTER ? block : three_quarters;
        block          = (peaks_t){.at = {0.0f}};
        for (uint32_t k = 0; k < BLOCK_TICKS; k++)
        {
            const float impulse = i == 0u && k == 0u ? 1.0f : 0.0f;
            add_tick(&block, cascade, &state, anti_windup, of_s ? 0.0f : impulse, of_s ? impulse : 0.0f);
        }
        done = true;
        for (uint32_t j = 0; j < SUMS; j++)
        {
            sum.at[j] += block.at[j];
            done = done && block.at[j] <= 1.0e-6f * sum.at[j];
        }
    }
    for (uint32_t j = 0; j < SUMS; j++)
    {
        float tail = 0.0f;
        if (block.at[j] > 1.0e-6f * sum.at[j])
        {
            // Each block is q = r^(1/64) times the one before, so the tail is block q/(1 - q), at most 64/(1 - r) of it.
            const float r = block.at[j] / three_quarters.at[j];
            if (!(r < 0.99f) || !is_geometric(half.at[j], three_quarters.at[j], block.at[j]))
            {
                return false;
            }
            tail = block.at[j] * (float)QUARTER / (1.0f - r);
        }
        peaks->at[j] += weight * MARGIN * (sum.at[j] + tail);
    }
    return true;
}

/// Peak at the output node of section i: the largest before and after the correction and of the correction itself.
static float node_peak(const peaks_t *peaks, uint32_t i)
{
    return larger(peaks->named.section[i].y,
                  larger(peaks->named.section[i].corrected, peaks->named.section[i].correction));
}

/// The smallest scale, from `at_least` on, at which `peak` 2^-scale is below full scale; SCALE_MAX + 1 if there is none.
static int32_t scale_for(float peak, int32_t at_least)
{
    int32_t scale = at_least;
    while (scale <= SCALE_MAX && !(scaled(peak, -scale) < 1.0f))
    {
        scale++;
    }
    return scale;
}

/// The largest s up to 30 with |x| < 4 2^-s: the extra fraction bits of w2, c2 and d2.
static int32_t shift_for(float x)
{
    const float most  = magnitude(x);
    int32_t     shift = 30;
    while (shift > 0 && !(scaled(most, shift) < 3.999f))
    {
        shift--;
    }
    return shift;
}

/// x 2^32 rounded to nearest, for 0 <= x < 2^31.
static int64_t fixed_in_two_words(float x)
{
    const uint32_t whole = (uint32_t)x;
    return (int64_t)((uint64_t)whole << 32 | fixed_unsigned(x - (float)whole, 32));
}

/// The inverse of fixed_in_two_words.
static float from_two_words(int64_t fixed)
{
    return (float)(uint32_t)(fixed >> 32) + scaled((float)(uint32_t)fixed, -32);
}

/// Scales and coefficients of all sections. A coefficient from a node at scale i to one at scale j is multiplied by 2^(i - j),
/// so the sections compute at the scales of their nodes.
static tribo_status_t quantize_sections(tribo_biquad_q31_params_t       *out,
                                        const tribo_biquad_f32_params_t *cascade,
                                        const peaks_t                   *peaks,
                                        float                            input_peak)
{
    int32_t before   = scale_for(larger(input_peak, larger(peaks->named.input, peaks->named.correction)), 2);
    out->input_scale = (uint8_t)before;
    out->count       = (uint8_t)cascade->count;
    if (before > SCALE_MAX)
    {
        return TRIBO_ERR_HEADROOM;
    }
    for (uint32_t i = 0; i < cascade->count; i++)
    {
        const tribo_biquad_f32_section_t *s     = &cascade->section[i];
        const float                       gain  = larger(magnitude(s->b0), larger(magnitude(s->b1), magnitude(s->b2)));
        const float                       w     = larger(peaks->named.section[i].w1, peaks->named.section[i].w2);
        const float                       most  = larger(scaled(gain, before), w);
        const int32_t                     scale = scale_for(most / 3.999f, scale_for(node_peak(peaks, i), 0));
        const int32_t                     by    = before - scale;
        const float                       b2    = scaled(s->b2, by);
        const float                       w2    = scaled(peaks->named.section[i].w2, -scale);
        const int32_t                     shift = shift_for(larger(magnitude(b2), larger(s->a2, w2)));
        if (scale > SCALE_MAX)
        {
            return TRIBO_ERR_HEADROOM;
        }
        const int32_t b0 = fixed(scaled(s->b0, by), 28);
        const int64_t d2 = -fixed_in_two_words(scaled(s->a2, 28 + shift));
        out->section[i]  = (tribo_biquad_q31_section_t){.b0       = b0,
                                                        .c1       = fixed(scaled(s->b1, by), 28) - b0,
                                                        .minus_a1 = -fixed(s->a1, 28),
                                                        .c2       = fixed(b2, 28 + shift),
                                                        .d2       = (int32_t)((d2 + (INT64_C(1) << 31)) >> 32),
                                                        .d2_low   = (int32_t)(uint32_t)d2,
                                                        .shift    = (uint8_t)shift,
                                                        .scale    = (uint8_t)scale};
        before           = scale;
    }
    out->output_scale = (uint8_t)before;
    return TRIBO_OK;
}

/// The sections that `q` implements, in float. Exact: each coefficient came from a float, and rounding only removes bits.
static void dequantize(tribo_biquad_f32_section_t *sections, const tribo_biquad_q31_params_t *q)
{
    int32_t before = q->input_scale;
    for (uint32_t i = 0; i < q->count; i++)
    {
        const tribo_biquad_q31_section_t *s  = &q->section[i];
        const int32_t                     by = s->scale - before;
        sections[i]                          = (tribo_biquad_f32_section_t){
                                     .b0 = scaled((float)s->b0, by - 28),
                                     .b1 = scaled((float)(s->c1 + s->b0), by - 28),
                                     .b2 = scaled((float)s->c2, by - 28 - (int32_t)s->shift),
                                     .a1 = scaled(-(float)s->minus_a1, -28),
                                     .a2 = scaled(from_two_words(-((int64_t)s->d2 * (INT64_C(1) << 32) + s->d2_low)), -28 - (int32_t)s->shift)};
        before = s->scale;
    }
}

static void report(tribo_headroom_q31_t *headroom, const peaks_t *peaks, uint32_t count, float input_peak)
{
    if (headroom == NULL)
    {
        return;
    }
    headroom->input = larger(input_peak, peaks->named.input);
    for (uint32_t i = 0; i < TRIBO_BIQUAD_Q31_SECTIONS_MAX; i++)
    {
        headroom->output[i] = i < count ? node_peak(peaks, i) : 0.0f;
    }
}

/// Peaks for inputs within `e_peak` and `s_peak`, as a fraction of full scale; false when one has no bound.
static bool find_peaks(peaks_t                         *peaks,
                       const tribo_biquad_f32_params_t *cascade,
                       float                            anti_windup,
                       float                            e_peak,
                       float                            s_peak)
{
    const float weight[] = {e_peak, s_peak};
    *peaks               = (peaks_t){.at = {0.0f}};
    bool bounded         = true;
    for (uint32_t i = 0; i < 2u; i++)
    {
        bounded = add_response(peaks, cascade, anti_windup, i == 1u, weight[i]) && bounded;
    }
    return bounded;
}

tribo_status_t tribo_headroom_q31_quantize(tribo_biquad_q31_params_t           *out,
                                           tribo_controller_f32_params_t       *f32,
                                           const tribo_controller_f32_config_t *config,
                                           float                                e_peak,
                                           float                                s_peak,
                                           tribo_headroom_q31_t                *headroom)
{
    peaks_t        peaks;
    const uint32_t count  = f32->cascade.count;
    tribo_status_t status = TRIBO_OK;
    for (uint32_t i = 0; i < 2u && status == TRIBO_OK; i++)
    {
        if (!find_peaks(&peaks, &f32->cascade, f32->anti_windup, e_peak, s_peak) ||
            quantize_sections(out, &f32->cascade, &peaks, e_peak) != TRIBO_OK)
        {
            return TRIBO_ERR_HEADROOM;
        }
        tribo_biquad_f32_section_t really[TRIBO_BIQUAD_SECTIONS_MAX];
        dequantize(really, out);
        if (config != NULL)
        {
            tribo_controller_f32_config_t again = *config;
            again.sections                      = really;
            status                              = tribo_controller_f32_init(f32, &again);
        }
        else
        {
            status = tribo_biquad_f32_init(&f32->cascade, really, count);
        }
    }
    if (status == TRIBO_OK)
    {
        report(headroom, &peaks, count, e_peak);
    }
    return status;
}
