#include "headroom_q31.h"

#include "biquad_f32_step.h"
#include "fixed_q31.h"

#include <stddef.h>

#define MARGIN      1.02f // over a measured peak, for the float sums and the tail
#define SCALE_MAX   24
#define BLOCK_TICKS 512u
#define QUARTER     64u // blocks
#define BLOCKS      (4u * QUARTER)

/// Sums of magnitudes of all that a cascade computes, i.e. L1 norms in the making.
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

/// One tick of a controller whose applied u - feedforward is `s`; `anti_windup` 0 for a plain cascade.
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

/// True when the blocks of the last half, a quarter apart, shrink by one and the same factor: a single slow pole is left.
static bool is_geometric(float half, float three_quarters, float last)
{
    const float middle = three_quarters * three_quarters;
    return magnitude(half * last - middle) <= 1.0e-4f * middle;
}

/// Adds `weight` times the L1 norms of the responses to an impulse of e or of s. False when one does not die away in
/// BLOCKS, unless all that is left of it is a single slow pole, whose tail is known.
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
            // By r in a quarter of the blocks, so 1/(1 - r^(1/64)) blocks are left, which is at most 64/(1 - r).
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

static float node_peak(const peaks_t *peaks, uint32_t i)
{
    return larger(peaks->named.section[i].y,
                  larger(peaks->named.section[i].corrected, peaks->named.section[i].correction));
}

/// The least scale from `at_least` on that takes `peak` below full scale.
static int32_t scale_for(float peak, int32_t at_least)
{
    int32_t scale = at_least;
    while (scale <= SCALE_MAX && !(scaled(peak, -scale) < 1.0f))
    {
        scale++;
    }
    return scale;
}

/// The largest s up to 30 that keeps x below 4 2^-s.
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

/// x 2^32 rounded to nearest, for x from 0 and below 2^31.
static int64_t fixed_in_two_words(float x)
{
    const uint32_t whole = (uint32_t)x;
    return (int64_t)((uint64_t)whole << 32 | fixed_unsigned(x - (float)whole, 32));
}

/// Back again.
static float from_two_words(int64_t fixed)
{
    return (float)(uint32_t)(fixed >> 32) + scaled((float)(uint32_t)fixed, -32);
}

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

/// The sections that `q` really is, in float: exact, as each was rounded from 24 bits.
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

/// Quantises f32's cascade for inputs within `e_peak` and `s_peak`, then makes f32 anew from the quantised numbers (by
/// `config`, or as a plain cascade without one), which checks that they are stable. All of it twice: the scales and
/// the report are then those of the numbers that run.
tribo_status_t headroom_q31_quantize(tribo_biquad_q31_params_t           *out,
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
