#include "headroom_q31.h"

#include "../number/fixed_q31.h"
#include "anti_windup_f32.h"

#include <stddef.h>

// The headroom of a cascade in fixed point. The worst-case peak of a node for inputs bounded by 1 is the L1 norm of its
// impulse response, the sum of |h[k]| over all k. A node holds its value times 2^-scale with 2^scale above that peak,
// so no input within its bound can make it overflow.
//
// The inputs of a controller are e and s = u - term, the applied output. With anti-windup the states follow s, so even
// an integrator has a bounded response. The cascade runs on an impulse of each, and the magnitudes are summed. The tail
// that slow poles leave after BLOCKS is bounded by the energies of the next 1, 1, 2, 4 ... ticks: a sum of n magnitudes
// is at most the root of n times the sum of their squares (Cauchy and Schwarz). The bound on such a tail is up to 4 %
// above the sum for a real pole, 15 % for an oscillation, and half as much again for one at a quarter of the sampling
// frequency. Where a node is small because slow modes all but cancel, beyond 1e5 full scales elsewhere, it may be
// several times as large.
//
// All of it is in double, because the small signals of a slow cascade are differences of large ones. A target without
// double in hardware links the compiler's functions for it, for set-up only.

#define MARGIN      1.02 // factor on a sum for rounding, and for what a pole at 1e-7 from z = 1 hides below DECAYED
#define SCALE_MAX   24   // larger scales leave too few bits of a signal
#define BLOCK_TICKS 128u // a response is summed in blocks
#define BLOCKS      8u
#define DECAYED     1.0e-6   // a last block of this fraction of the sum ends it
#define PIECE_TICKS 8u       // ticks between two pauses
#define SLOWEST     0x1p30f  // longest decay, ticks: enough for a pole at 1e-7 from z = 1
#define LONG_TICKS  0x1p16f  // shortest tail, ticks: a shorter one would hide a slower one
#define ROUNDING    1.0e-13f // rounding of an energy, as a fraction of its terms, which may cancel
#define STATES_MAX  (2u * TRIBO_BIQUAD_SECTIONS_MAX)
#define SIGNALS_MAX (2u + 5u * TRIBO_BIQUAD_SECTIONS_MAX)

/// The signals of a cascade in one tick, or the sums of their magnitudes over time: its L1 norms.
typedef union
{
    struct
    {
        double input; // with the correction
        double correction;
        struct
        {
            double y, corrected, correction, w1, w2;
        } section[TRIBO_BIQUAD_SECTIONS_MAX];
    } named;
    double at[SIGNALS_MAX];
} signals_t;

/// A row of states: w1 and w2 of each section.
typedef struct
{
    double at[STATES_MAX];
} row_t;

/// A square matrix of a cascade's states.
typedef struct
{
    double   at[STATES_MAX][STATES_MAX];
    uint32_t size;
} matrix_t;

/// The number of signals of a cascade.
static uint32_t signals(const tribo_controller_f32_params_t *f32)
{
    return 2u + 5u * f32->cascade.count;
}

/// One tick from the states x for an error `e` and an applied output `s`. Writes the signals to `now`, with w1 and w2 as
/// they are after the tick. Returns by how much the states change, because their new values would round off the distance
/// of a slow pole from 1. If anti_windup is 0 this is the cascade alone.
static row_t change_of(signals_t *now, const tribo_controller_f32_params_t *f32, const row_t *x, double e, double s)
{
    const tribo_biquad_f32_section_t *const section = f32->cascade.section;
    row_t                                   change  = {.at = {0.0}};
    double                                  v       = e;
    for (uint32_t i = 0; i < f32->cascade.count; i++)
    {
        v                       = (double)section[i].b0 * v + x->at[2u * i];
        now->named.section[i].y = v;
    }
    double c              = (s - v) * (double)f32->anti_windup;
    double in             = e + c;
    now->named.input      = in;
    now->named.correction = c;
    for (uint32_t i = 0; i < f32->cascade.count; i++)
    {
        c                      = (double)section[i].b0 * c;
        const double out       = now->named.section[i].y + c;
        change.at[2u * i]      = ((double)section[i].b1 * in - (double)section[i].a1 * out) + x->at[2u * i + 1u];
        change.at[2u * i + 1u] = (double)section[i].b2 * in - (double)section[i].a2 * out;
        now->named.section[i].corrected  = out;
        now->named.section[i].correction = c;
        now->named.section[i].w1         = x->at[2u * i] + change.at[2u * i];
        now->named.section[i].w2         = x->at[2u * i + 1u] + change.at[2u * i + 1u];
        in                               = out;
    }
    return change;
}

/// Sums of magnitudes over a block that begins with the impulses `e` and `s`. The states x advance.
static signals_t sum_block(const tribo_controller_f32_params_t *f32,
                           row_t                               *x,
                           double                               e,
                           double                               s,
                           const tribo_controller_f32_config_t *config)
{
    signals_t sum = {.at = {0.0}};
    for (uint32_t k = 0; k < BLOCK_TICKS; k++)
    {
        signals_t   now;
        const row_t change = change_of(&now, f32, x, k == 0u ? e : 0.0, k == 0u ? s : 0.0);
        for (uint32_t j = 0; j < 2u * f32->cascade.count; j++)
        {
            x->at[j] += change.at[j];
        }
        for (uint32_t j = 0; j < signals(f32); j++)
        {
            sum.at[j] += now.at[j] < 0.0 ? -now.at[j] : now.at[j];
        }
        if (k % PIECE_TICKS == 0u)
        {
            controller_f32_pause(config);
        }
    }
    return sum;
}

/// Adds a block to the sum. True if the block is so small that the sum may end with it.
static bool add_block(signals_t *sum, const signals_t *block, uint32_t count)
{
    bool decayed = true;
    for (uint32_t j = 0; j < count; j++)
    {
        sum->at[j] += block->at[j];
        decayed = decayed && block->at[j] <= DECAYED * sum->at[j];
    }
    return decayed;
}

/// X (1 + E), or X^T (1 + E) if `transposed`.
static matrix_t advanced(const matrix_t *X, bool transposed, const matrix_t *E)
{
    matrix_t result = {.size = E->size};
    for (uint32_t i = 0; i < E->size; i++)
    {
        for (uint32_t j = 0; j < E->size; j++)
        {
            double sum = transposed ? X->at[j][i] : X->at[i][j];
            for (uint32_t k = 0; k < E->size; k++)
            {
                sum += (transposed ? X->at[k][i] : X->at[i][k]) * E->at[k][j];
            }
            result.at[i][j] = sum;
        }
    }
    return result;
}

static void add(matrix_t *to, const matrix_t *X)
{
    for (uint32_t i = 0; i < X->size; i++)
    {
        for (uint32_t j = 0; j < X->size; j++)
        {
            to->at[i][j] += X->at[i][j];
        }
    }
}

/// Bound on the sum of |signal k| over `ticks`. `of` holds the signals for a 1 in each state, `energy` is the sum of
/// x^T x.
static float bound(const signals_t of[STATES_MAX], uint32_t k, const matrix_t *energy, float ticks)
{
    double squares = 0.0;
    float  terms   = 0.0f;
    for (uint32_t i = 0; i < energy->size; i++)
    {
        for (uint32_t j = 0; j < energy->size && of[i].at[k] != 0.0; j++)
        {
            const double term = of[i].at[k] * (of[j].at[k] * energy->at[i][j]);
            squares += term;
            terms += magnitude((float)term);
        }
    }
    return root_f32(ticks * (larger((float)squares, 0.0f) + ROUNDING * terms));
}

/// Adds bounds on the sums from the states x on. False if the response does not decay.
static bool add_tail(signals_t                           *sum,
                     const tribo_controller_f32_params_t *f32,
                     const row_t                         *x,
                     const tribo_controller_f32_config_t *config)
{
    const uint32_t size           = 2u * f32->cascade.count;
    matrix_t       E              = {.size = size}; // x[k + 1] = x[k] (1 + E)
    matrix_t       energy         = {.size = size}; // the sum of x^T x
    matrix_t       next           = {.size = size}; // the energy of the next `ticks`
    signals_t      of[STATES_MAX] = {{.at = {0.0}}};
    for (uint32_t i = 0; i < size; i++)
    {
        row_t unit      = {.at = {0.0}};
        unit.at[i]      = 1.0;
        const row_t row = change_of(&of[i], f32, &unit, 0.0, 0.0);
        for (uint32_t j = 0; j < size; j++)
        {
            E.at[i][j]    = row.at[j];
            next.at[i][j] = x->at[i] * x->at[j];
        }
    }
    bool  decayed = false;
    float ticks   = 1.0f; // that `next` covers
    for (float of_E = 1.0f; of_E < SLOWEST && !decayed; of_E *= 2.0f)
    {
        signals_t block = {.at = {0.0}};
        for (uint32_t k = 0; k < signals(f32); k++)
        {
            controller_f32_pause(config);
            block.at[k] = (double)bound(of, k, &next, ticks);
        }
        decayed = add_block(sum, &block, signals(f32)) && ticks >= LONG_TICKS;
        add(&energy, &next);
        controller_f32_pause(config);
        const matrix_t half = advanced(&energy, false, &E);
        controller_f32_pause(config);
        next  = advanced(&half, true, &E);
        ticks = of_E;
        controller_f32_pause(config);
        const matrix_t change = advanced(&E, false, &E);
        add(&E, &change);
    }
    return decayed;
}

/// Adds bounds on the L1 norms of the responses to an impulse `e` and to an impulse `s`. False if one does not decay.
static bool add_responses(signals_t                           *peaks,
                          const tribo_controller_f32_params_t *f32,
                          double                               e,
                          double                               s,
                          const tribo_controller_f32_config_t *config)
{
    const uint32_t count   = signals(f32);
    bool           bounded = true;
    for (uint32_t of_s = 0; of_s < 2u; of_s++)
    {
        signals_t sum       = {.at = {0.0}};
        row_t     x         = {.at = {0.0}};
        double    impulse[] = {of_s != 0u ? 0.0 : e, of_s != 0u ? s : 0.0};
        bool      decayed   = false;
        for (uint32_t i = 0; i < BLOCKS && !decayed; i++)
        {
            const signals_t block = sum_block(f32, &x, impulse[0], impulse[1], config);
            decayed               = add_block(&sum, &block, count);
            impulse[0] = impulse[1] = 0.0;
        }
        if (!decayed && !add_tail(&sum, f32, &x, config))
        {
            bounded = false;
        }
        for (uint32_t j = 0; j < count; j++)
        {
            peaks->at[j] += MARGIN * sum.at[j];
        }
    }
    return bounded;
}

static double larger_of(double a, double b)
{
    return a > b ? a : b;
}

/// Peak at the output node of section i: the largest of its output before and after the correction and of the
/// correction itself.
static float node_peak(const signals_t *peaks, uint32_t i)
{
    return (float)larger_of(peaks->named.section[i].y,
                            larger_of(peaks->named.section[i].corrected, peaks->named.section[i].correction));
}

/// The smallest scale, `at_least` or larger, at which `peak` 2^-scale is below full scale. SCALE_MAX + 1 if there is
/// none.
static int32_t scale_for(float peak, int32_t at_least)
{
    int32_t scale = at_least;
    while (scale <= SCALE_MAX && !(scaled(peak, -scale) < 1.0f))
    {
        scale++;
    }
    return scale;
}

/// The extra fraction bits of w2, c2 and d2: the largest s up to 30 with |x| < 4 2^-s.
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

/// Computes scales and coefficients of all sections. A coefficient from a node at scale i to one at scale j is
/// multiplied by 2^(i - j), so each section computes at the scales of its nodes.
static tribo_status_t quantize_sections(tribo_biquad_q31_params_t       *out,
                                        const tribo_biquad_f32_params_t *cascade,
                                        const signals_t                 *peaks,
                                        float                            input_peak)
{
    int32_t before   = scale_for(larger(input_peak, (float)larger_of(peaks->named.input, peaks->named.correction)), 2);
    out->input_scale = (uint8_t)before;
    out->count       = (uint8_t)cascade->count;
    if (before > SCALE_MAX)
    {
        return TRIBO_ERR_HEADROOM;
    }
    for (uint32_t i = 0; i < cascade->count; i++)
    {
        const tribo_biquad_f32_section_t *s    = &cascade->section[i];
        const float                       gain = larger(magnitude(s->b0), larger(magnitude(s->b1), magnitude(s->b2)));
        const float                       w = (float)larger_of(peaks->named.section[i].w1, peaks->named.section[i].w2);
        const float                       most  = larger(scaled(gain, before), w);
        const int32_t                     scale = scale_for(most / 3.999f, scale_for(node_peak(peaks, i), 0));
        const int32_t                     by    = before - scale;
        const float                       b2    = scaled(s->b2, by);
        const float                       w2    = scaled((float)peaks->named.section[i].w2, -scale);
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

/// The sections that `q` implements, in float. They are exact, because each coefficient came from a float and rounding
/// only removes bits.
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

static void report(tribo_headroom_q31_t *headroom, const signals_t *peaks, uint32_t count, float input_peak)
{
    if (headroom == NULL)
    {
        return;
    }
    headroom->input = larger(input_peak, (float)peaks->named.input);
    for (uint32_t i = 0; i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        headroom->output[i] = i < count ? node_peak(peaks, i) : 0.0f;
    }
}

tribo_status_t tribo_headroom_q31_quantize(tribo_biquad_q31_params_t           *out,
                                           tribo_controller_f32_params_t       *f32,
                                           const tribo_controller_f32_config_t *config,
                                           float                               *conditioned_by,
                                           float                                e_peak,
                                           float                                s_peak,
                                           tribo_headroom_q31_t                *headroom)
{
    signals_t      peaks;
    const uint32_t count  = f32->cascade.count;
    tribo_status_t status = TRIBO_OK;
    for (uint32_t i = 0; i < 2u && status == TRIBO_OK; i++)
    {
        peaks = (signals_t){.at = {0.0}};
        if (!add_responses(&peaks, f32, (double)e_peak, (double)s_peak, config) ||
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
            status                              = tribo_controller_f32_prepare(f32, &again, conditioned_by);
        }
        else
        {
            status = tribo_biquad_f32_init(&f32->cascade, really, count, NULL);
        }
    }
    if (status == TRIBO_OK)
    {
        report(headroom, &peaks, count, e_peak);
    }
    return status;
}
