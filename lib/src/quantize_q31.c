#include "tribo/quantize_q31.h"

#include "exact_f32.h"

#include <stddef.h>

static float larger(float a, float b)
{
    return a > b ? a : b;
}

/// x 2^bits, exact but for overflow and underflow.
static float scaled(float x, int32_t bits)
{
    float y = x;
    for (int32_t i = 0; i < bits; i++)
    {
        y *= 2.0f;
    }
    for (int32_t i = bits; i < 0; i++)
    {
        y *= 0.5f;
    }
    return y;
}

/// x 2^bits rounded to nearest, for |x 2^bits| < 2^31.
static int32_t fixed(float x, int32_t bits)
{
    const float y = scaled(x, bits);
    if (magnitude(y) >= 8388608.0f)
    {
        return (int32_t)y; // an integer already, and 0.5 more could round it up
    }
    return (int32_t)(y < 0.0f ? y - 0.5f : y + 0.5f);
}

/// x 2^bits rounded to nearest, for x from 0; what is 2^32 or more becomes the largest number.
static uint32_t fixed_unsigned(float x, int32_t bits)
{
    const float y = scaled(x, bits);
    if (y >= 8388608.0f)
    {
        return y < 4294967296.0f ? (uint32_t)y : UINT32_MAX;
    }
    return (uint32_t)(y + 0.5f);
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

/// A force within full scale in Q31; full scale itself does not fit and becomes the largest number.
static int32_t fixed_force(float force_n, float full_scale_n)
{
    const float part = force_n / full_scale_n;
    return magnitude(part) < 1.0f ? fixed(part, 31) : (part < 0.0f ? -TRIBO_Q31_MAX : TRIBO_Q31_MAX);
}

/// x below 2^30 as mantissa 2^(shift - 32), `shift` 1 to 31, with 31 significant bits where that gives them.
static void normalise(float x, int32_t *mantissa, uint8_t *shift)
{
    int32_t bits = 1;
    while (bits < 31 && magnitude(scaled(x, bits)) < 1073741824.0f)
    {
        bits++;
    }
    *mantissa = fixed(x, bits);
    *shift    = (uint8_t)(32 - bits);
}

#define SMALLEST 1.0e-6f // of full scale, or of 1: what is smaller has too few bits, or none

static bool full_scale_ok(float full_scale_n)
{
    return within(full_scale_n, 1.0e-3f, TRIBO_F32_FORCE_MAX_N);
}

// --- friction ------------------------------------------------------------------------------------------------------

static tribo_status_t quantize_law(tribo_friction_q31_params_t *out,
                                   uint32_t                     side,
                                   const tribo_breakaway_f32_t *law,
                                   float                        full_scale_n)
{
    if (!within(law->offset_n / full_scale_n, SMALLEST, 0.999999f))
    {
        return TRIBO_ERR_BREAKAWAY_OFFSET;
    }
    const uint32_t whole = (uint32_t)law->slope;
    const uint32_t part  = fixed_unsigned(law->slope - (float)whole, 32);

    out->law[side].offset   = (uint32_t)fixed_force(law->offset_n, full_scale_n);
    out->law[side].slope    = part;
    out->law_whole[side]    = (uint8_t)whole;
    out->reset[side].offset = tribo_q31_high(out->reset_level, out->law[side].offset);
    out->reset[side].slope  = tribo_q31_high(out->reset_level, part);
    return TRIBO_OK;
}

static tribo_status_t check_table(const tribo_friction_f32_config_t *config, float full_scale_n)
{
    int32_t last = -1;
    for (uint32_t i = 0; i < config->table_length; i++)
    {
        const tribo_breakaway_point_f32_t *point = &config->table[i];
        const int32_t                      force = fixed_force(point->force_n, full_scale_n);
        if (!(point->force_n < full_scale_n) || force <= last)
        {
            return TRIBO_ERR_TABLE_FORCE;
        }
        if (!within(point->positive_n / full_scale_n, SMALLEST, 0.999999f) ||
            !within(point->negative_n / full_scale_n, SMALLEST, 0.999999f))
        {
            return TRIBO_ERR_TABLE_BREAKAWAY;
        }
        last = force;
    }
    return TRIBO_OK;
}

static tribo_status_t quantize_breakaway(tribo_friction_q31_params_t       *out,
                                         const tribo_friction_f32_config_t *config,
                                         float                              full_scale_n)
{
    if (config->table != NULL)
    {
        return check_table(config, full_scale_n);
    }
    const tribo_status_t status = quantize_law(out, 0, &config->positive, full_scale_n);
    return status != TRIBO_OK ? status : quantize_law(out, 1, &config->negative, full_scale_n);
}

static void quantize_k(tribo_friction_q31_params_t *out, const tribo_friction_f32_config_t *config)
{
    int32_t shift = 0;
    while (scaled(config->k_min + config->k_max, -shift) >= 0.99999f)
    {
        shift++;
    }
    out->k[0]    = fixed_unsigned(config->k_min, 32 - shift);
    out->k[1]    = fixed_unsigned(config->k_max, 32 - shift);
    out->k[2]    = out->k[0];
    out->k_shift = (uint8_t)shift;
}

/// y = (2/ln 2) m (v/v0 - 1) as a product of the rise of |n|, up to where y is 32.
static tribo_status_t quantize_rate(tribo_friction_q31_params_t       *out,
                                    const tribo_friction_f32_params_t *f32,
                                    float                              full_scale_n)
{
    const float y_per_bit = scaled(f32->y_per_rise * full_scale_n, -31);
    if (!(y_per_bit < 17.0f))
    {
        return TRIBO_ERR_V0;
    }
    const float most = (f32->y_at_0 + 32.0f) / y_per_bit; // not finite for m = 0
    out->rise_max    = most < 2147483520.0f ? (uint32_t)most + 1u : (uint32_t)TRIBO_Q31_MAX;
    out->rise_shift  = (uint8_t)tribo_q31_leading_zeros(out->rise_max);
    out->rate        = fixed_unsigned(y_per_bit, 54 - (int32_t)out->rise_shift);
    out->y_at_0      = fixed(f32->y_at_0, 22);
    return TRIBO_OK;
}

typedef struct
{
    uint64_t least, largest;
} breakaways_t;

static void include(breakaways_t *all, uint64_t L)
{
    all->least   = L < all->least ? L : all->least;
    all->largest = L > all->largest ? L : all->largest;
}

/// All L that there can be, before they end at full scale.
static breakaways_t breakaways(const tribo_friction_q31_params_t *out,
                               const tribo_friction_f32_config_t *config,
                               float                              full_scale_n)
{
    breakaways_t all = {.least = UINT64_MAX, .largest = 0};
    for (uint32_t side = 0; side < 2u && config->table == NULL; side++)
    {
        const uint64_t rise = ((uint64_t)out->law_whole[side] << 31) + (out->law[side].slope >> 1);
        include(&all, out->law[side].offset);
        include(&all, out->law[side].offset + rise);
    }
    for (uint32_t i = 0; i < out->table_length; i++)
    {
        include(&all, (uint64_t)fixed_force(config->table[i].positive_n, full_scale_n));
        include(&all, (uint64_t)fixed_force(config->table[i].negative_n, full_scale_n));
    }
    return all;
}

static void copy_table(tribo_breakaway_point_q31_t       *table,
                       const tribo_friction_f32_config_t *config,
                       float                              full_scale_n)
{
    for (uint32_t i = 0; i < config->table_length; i++)
    {
        table[i].force    = fixed_force(config->table[i].force_n, full_scale_n);
        table[i].positive = fixed_force(config->table[i].positive_n, full_scale_n);
        table[i].negative = fixed_force(config->table[i].negative_n, full_scale_n);
    }
}

static tribo_status_t quantize_friction(tribo_friction_q31_params_t       *out,
                                        const tribo_friction_f32_config_t *config,
                                        float                              sample_time_s,
                                        float                              full_scale_n)
{
    tribo_friction_f32_params_t f32;
    tribo_status_t              status = tribo_friction_f32_init(&f32, config, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    out->table_length = f32.table_length;
    out->set_level    = fixed_unsigned(config->set_level, 32);
    out->reset_level  = fixed_unsigned(config->reset_level, 32);
    status            = quantize_rate(out, &f32, full_scale_n);
    status            = status != TRIBO_OK ? status : quantize_breakaway(out, config, full_scale_n);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!(magnitude(config->gravity_n) < full_scale_n))
    {
        return TRIBO_ERR_GRAVITY;
    }
    const breakaways_t L = breakaways(out, config, full_scale_n);
    if (!(config->set_level >= SMALLEST) || tribo_q31_high(out->set_level, (uint32_t)L.least) == 0u)
    {
        return TRIBO_ERR_SET_LEVEL;
    }
    if (!(config->reset_level >= SMALLEST))
    {
        return TRIBO_ERR_RESET_LEVEL;
    }
    quantize_k(out, config);
    out->gravity     = fixed_force(config->gravity_n, full_scale_n);
    out->plain       = config->table == NULL && L.largest <= TRIBO_Q31_MAX;
    out->pulse_width = f32.pulse_width;
    return TRIBO_OK;
}

tribo_status_t tribo_friction_q31_init(tribo_friction_q31_params_t       *params,
                                       tribo_breakaway_point_q31_t       *table,
                                       const tribo_friction_f32_config_t *config,
                                       float                              sample_time_s,
                                       float                              full_scale_n)
{
    if (params == NULL || config == NULL || (config->table != NULL && table == NULL))
    {
        return TRIBO_ERR_NULL;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    tribo_friction_q31_params_t made   = {.table = config->table != NULL ? table : NULL};
    const tribo_status_t        status = quantize_friction(&made, config, sample_time_s, full_scale_n);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (config->table != NULL)
    {
        copy_table(table, config, full_scale_n);
    }
    *params = made;
    return TRIBO_OK;
}

// --- arm -----------------------------------------------------------------------------------------------------------

#define ARM_MAX 3.999f

static int64_t lesser(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/// Jury's conditions, on the quantised numbers: of the arm that moves under a constant force, and of G alone when it
/// sticks. A slow arm's are small differences, so nothing is rounded before they are taken.
static bool arm_is_stable(const tribo_arm_q31_params_t *p)
{
    const int64_t one      = INT64_C(1) << 28;
    const int64_t coupling = (int64_t)p->phi_g * p->gamma_d; // Q(56 + s)
    const int64_t at_one   = p->phi_d * (one - p->gamma_g) + coupling;
    const int64_t radius   = (one - p->gamma_g) * (INT64_C(1) << p->shift) +
                           tribo_q31_shift_to_zero((int64_t)p->phi_d * p->gamma_g - coupling, 28);
    const int64_t phi_d        = tribo_q31_shift_to_zero(p->phi_d, p->shift);
    const int64_t at_minus_one = (2 * one - phi_d) * (one + p->gamma_g) + tribo_q31_shift_to_zero(coupling, p->shift);
    const int64_t sticking     = one - (int64_t)tribo_q31_magnitude(p->gamma_g);
    return lesser(lesser(at_one, at_minus_one), lesser(radius, sticking)) > 0;
}

tribo_status_t tribo_arm_q31_init(tribo_arm_q31_params_t       *params,
                                  const tribo_arm_f32_config_t *config,
                                  float                         sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_arm_f32_params_t f32;
    const tribo_status_t   status = tribo_arm_f32_init(&f32, config, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    // gamma_d is about (omega h)^2: with G times 1/(omega h), drive and speed get coefficients of like size. As phi_d is 2
    // at the most and phi_g 1, those of F stay below 4 together, so that their products' sum is below 2^61.
    const float push  = magnitude(f32.gamma_d);
    const float move  = magnitude(f32.phi_d);
    const float coast = magnitude(f32.phi_g);
    int32_t     shift = 0;
    while (shift < 15 && scaled(push, 2 * (shift + 1)) <= 1.0f && scaled(move, shift + 1) + coast < ARM_MAX)
    {
        shift++;
    }
    if (!(scaled(push, shift) < ARM_MAX))
    {
        return TRIBO_ERR_ARM_TOO_FAST;
    }
    const tribo_arm_q31_params_t made = {.phi_d   = fixed(scaled(f32.phi_d, shift), 28),
                                         .phi_g   = fixed(f32.phi_g, 28),
                                         .gamma_d = fixed(scaled(f32.gamma_d, shift), 28),
                                         .gamma_g = fixed(f32.gamma_g, 28),
                                         .power   = INT32_C(1) << (30 - shift),
                                         .below   = (uint16_t)((1u << shift) - 1u),
                                         .shift   = (uint8_t)shift};
    if (!arm_is_stable(&made))
    {
        return TRIBO_ERR_DAMPING;
    }
    *params = made;
    return TRIBO_OK;
}

// --- LuGre ---------------------------------------------------------------------------------------------------------

/// The most bits, up to `bits_max`, with which x is below 2^31; x itself is.
static int32_t bits_for(float x, int32_t bits_max)
{
    int32_t bits = bits_max;
    while (!(scaled(x, bits) < 2147483648.0f))
    {
        bits--;
    }
    return bits;
}

static tribo_status_t quantize_side(tribo_lugre_q31_params_t    *out,
                                    uint32_t                     side,
                                    const tribo_breakaway_f32_t *law,
                                    float                        full_scale_n)
{
    const float offset = law->offset_n / full_scale_n;
    if (!(offset >= SMALLEST && offset < 1.0f))
    {
        return TRIBO_ERR_BREAKAWAY_OFFSET;
    }
    out->offset[side] = (uint32_t)fixed(offset, 31);
    out->slope[side]  = fixed_unsigned(law->slope, 28);
    return TRIBO_OK;
}

static tribo_status_t quantize_lugre(tribo_lugre_q31_params_t       *out,
                                     const tribo_lugre_f32_params_t *f32,
                                     float                           full_scale_n)
{
    const int32_t divisor_bits = bits_for(f32->a + f32->b_and_1, 30);
    const int32_t c_bits       = bits_for(f32->c, 50);
    if (divisor_bits < 10)
    {
        return TRIBO_ERR_BRISTLE_DAMPING;
    }
    tribo_status_t status = quantize_side(out, 0, &f32->law[0], full_scale_n);
    status                = status != TRIBO_OK ? status : quantize_side(out, 1, &f32->law[1], full_scale_n);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!(magnitude(f32->gravity_n) <= full_scale_n))
    {
        return TRIBO_ERR_GRAVITY;
    }
    out->a       = fixed_unsigned(f32->a, divisor_bits);
    out->b_and_1 = fixed_unsigned(f32->b_and_1, divisor_bits);
    out->one     = UINT32_C(1) << divisor_bits;
    out->beta    = fixed(f32->beta, 20);
    out->c       = fixed_unsigned(f32->c, c_bits);
    out->c_shift = (uint8_t)c_bits;
    out->stuck   = fixed_unsigned(f32->stuck, 32);
    out->gamma_g = fixed(f32->gamma_g, 28);
    out->gravity = fixed_force(f32->gravity_n, full_scale_n);
    return TRIBO_OK;
}

tribo_status_t tribo_lugre_q31_init(tribo_lugre_q31_params_t       *params,
                                    const tribo_lugre_f32_config_t *config,
                                    const tribo_arm_f32_config_t   *arm,
                                    float                           sample_time_s,
                                    float                           full_scale_n)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    tribo_lugre_f32_params_t f32;
    tribo_lugre_q31_params_t made;
    tribo_status_t           status = tribo_lugre_f32_init(&f32, config, arm, sample_time_s);
    status                          = status != TRIBO_OK ? status : quantize_lugre(&made, &f32, full_scale_n);
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

tribo_status_t tribo_compensator_q31_init(tribo_compensator_q31_params_t       *params,
                                          tribo_breakaway_point_q31_t          *table,
                                          const tribo_compensator_f32_config_t *config,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    // The arm first: the friction, when it is accepted, writes the table.
    tribo_compensator_q31_params_t made;
    tribo_compensator_f32_params_t f32;
    tribo_status_t                 status = tribo_compensator_f32_init(&f32, config, sample_time_s);
    status = status != TRIBO_OK ? status : tribo_arm_q31_init(&made.arm, &config->arm, sample_time_s);
    status = status != TRIBO_OK
                 ? status
                 : tribo_friction_q31_init(&made.friction, table, &config->friction, sample_time_s, full_scale_n);
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

// --- cascade -------------------------------------------------------------------------------------------------------

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
    tribo_biquad_f32_outputs_t outputs;
    const float                v          = tribo_biquad_f32_output(cascade, state, e, &outputs);
    const float                correction = (s - v) * anti_windup;
    block->named.input += magnitude(e + correction);
    block->named.correction += magnitude(correction);
    float c = correction;
    for (uint32_t i = 0; i < cascade->count; i++)
    {
        c *= cascade->section[i].b0;
        block->named.section[i].y += magnitude(outputs.y[i]);
        block->named.section[i].corrected += magnitude(outputs.y[i] + c);
        block->named.section[i].correction += magnitude(c);
    }
    tribo_biquad_f32_advance(cascade, state, e, &outputs, correction);
    for (uint32_t i = 0; i < cascade->count; i++)
    {
        block->named.section[i].w1 += magnitude(state->section[i].w1);
        block->named.section[i].w2 += magnitude(state->section[i].w2);
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

static tribo_status_t quantize_sections(tribo_biquad_q31_params_t       *out,
                                        const tribo_biquad_f32_params_t *cascade,
                                        const peaks_t                   *peaks,
                                        float                            input_peak)
{
    int32_t before   = scale_for(larger(input_peak, larger(peaks->named.input, peaks->named.correction)), 2);
    out->input_scale = (uint8_t)before;
    out->count       = (uint8_t)cascade->count;
    out->pair_power  = cascade->count == 2u ? INT32_C(1) << (32 - before) : 0;
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
        out->section[i]  = (tribo_biquad_q31_section_t){.b0          = b0,
                                                        .c1          = fixed(scaled(s->b1, by), 28) - b0,
                                                        .minus_a1    = -fixed(s->a1, 28),
                                                        .c2          = fixed(b2, 28 + shift),
                                                        .d2          = (int32_t)((d2 + (INT64_C(1) << 31)) >> 32),
                                                        .d2_low      = (int32_t)(uint32_t)d2,
                                                        .shift_power = INT32_C(1) << (30 - shift),
                                                        .shift       = (uint8_t)shift,
                                                        .scale       = (uint8_t)scale};
        before           = scale;
    }
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

/// Peaks for inputs within `e_peak` and `s_peak`, in parts of full scale; false when one has no bound.
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
static tribo_status_t quantize_cascade(tribo_biquad_q31_params_t           *out,
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

#define FULL 0.99999994f // full scale, which itself does not fit

tribo_status_t tribo_biquad_q31_init(tribo_biquad_q31_params_t        *params,
                                     const tribo_biquad_f32_section_t *sections,
                                     uint32_t                          count,
                                     tribo_headroom_q31_t             *headroom)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_biquad_q31_params_t     made = {.count = 0};
    tribo_controller_f32_params_t f32  = {.anti_windup = 0.0f};

    tribo_status_t status = tribo_biquad_f32_init(&f32.cascade, sections, count);
    status                = status != TRIBO_OK ? status : quantize_cascade(&made, &f32, NULL, FULL, 0.0f, headroom);
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

// --- controller and loop -------------------------------------------------------------------------------------------

static tribo_status_t check_limits(const tribo_controller_f32_params_t *f32, float full_scale_n)
{
    if (!(f32->u_min_n >= -full_scale_n))
    {
        return TRIBO_ERR_U_MIN;
    }
    const bool wide = (f32->u_max_n - f32->u_min_n) / full_scale_n >= SMALLEST; // else nothing would be left of it
    return f32->u_max_n <= full_scale_n && wide ? TRIBO_OK : TRIBO_ERR_U_MAX;
}

/// The most that a limit may take off the last node without a correction beyond full scale at any.
static int32_t taken_max(const tribo_controller_q31_params_t *made)
{
    float gain = magnitude(scaled((float)made->anti_windup, (int32_t)made->anti_windup_shift - 32));
    float most = larger(gain, 1.0f);
    for (uint32_t i = 0; i < made->cascade.count; i++)
    {
        gain *= magnitude(scaled((float)made->cascade.section[i].b0, -28));
        most = larger(gain, most);
    }
    // Below the end by less than the headroom's margin. What is taken has 5 units for the rounding here and for that of the
    // correction, whose last bit is up to 4 gains.
    return fixed(0.99999f / most, 31) - 5;
}

tribo_status_t tribo_controller_q31_init(tribo_controller_q31_params_t       *params,
                                         const tribo_controller_f32_config_t *config,
                                         float                                full_scale_n,
                                         tribo_headroom_q31_t                *headroom)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    tribo_controller_q31_params_t made = {.u_min = 0};
    tribo_controller_f32_params_t f32;
    tribo_status_t                status = tribo_controller_f32_init(&f32, config);
    status                               = status != TRIBO_OK ? status : check_limits(&f32, full_scale_n);
    if (status != TRIBO_OK)
    {
        return status;
    }
    const float u_peak = larger(-f32.u_min_n, f32.u_max_n) / full_scale_n;
    status             = quantize_cascade(&made.cascade, &f32, config, FULL, u_peak + 1.0f, headroom);
    if (status != TRIBO_OK)
    {
        return status;
    }
    const int32_t by = (int32_t)made.cascade.section[made.cascade.count - 1u].scale - (int32_t)made.cascade.input_scale;
    // It is below 2^24: what the anti-windup makes of s is below full scale at the input node.
    normalise(scaled(f32.anti_windup, by), &made.anti_windup, &made.anti_windup_shift);
    made.taken_max = taken_max(&made);
    made.u_min     = fixed_force(f32.u_min_n, full_scale_n);
    made.u_max     = fixed_force(f32.u_max_n, full_scale_n);
    *params        = made;
    return TRIBO_OK;
}

tribo_status_t tribo_force_loop_q31_init(tribo_force_loop_q31_params_t       *params,
                                         tribo_breakaway_point_q31_t         *table,
                                         const tribo_force_loop_f32_config_t *config,
                                         float                                full_scale_n,
                                         tribo_headroom_q31_t                *headroom)
{
    tribo_force_loop_f32_params_t f32;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_force_loop_f32_init(&f32, config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    if (!within(config->input_max_n / full_scale_n, SMALLEST, 1.0f))
    {
        return TRIBO_ERR_INPUT_MAX;
    }
    tribo_headroom_q31_t          measured;
    tribo_force_loop_q31_params_t made = {.input_end = (uint32_t)fixed_force(config->input_max_n, full_scale_n) + 1u,
                                          .gain      = fixed(f32.gain, 29)};

    status = tribo_controller_q31_init(&made.controller, &config->controller, full_scale_n, &measured);
    status = status != TRIBO_OK ? status
                                : tribo_compensator_q31_init(&made.compensator,
                                                             table,
                                                             &config->compensator,
                                                             config->sample_time_s,
                                                             full_scale_n);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (headroom != NULL)
    {
        *headroom = measured;
    }
    const bool usual = made.controller.cascade.count == 2u && made.compensator.friction.plain &&
                       made.gain <= INT32_C(1) << 29; // whose feedforward fits
    made.usual_input_end = usual ? made.input_end : 0u;
    *params              = made;
    return TRIBO_OK;
}
