#include "tribo/friction_q31.h"

#include "tribo/friction_f32.h"

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "law_f32.h"
#include "law_q31.h"

#include <stddef.h>

static tribo_status_t quantize_law(tribo_friction_q31_params_t *out,
                                   uint32_t                     sign,
                                   const tribo_breakaway_f32_t *law,
                                   float                        full_scale_n)
{
    if (!within(law->offset_n / full_scale_n, FIXED_Q31_SMALLEST, 0.999999f))
    {
        return sign == 0u ? TRIBO_ERR_BREAKAWAY_OFFSET : TRIBO_ERR_BREAKAWAY_NEGATIVE_OFFSET;
    }
    const uint32_t whole  = (uint32_t)law->slope;
    out->law[sign].offset = (uint32_t)fixed_force(law->offset_n, full_scale_n);
    out->law[sign].slope  = fixed_unsigned(law->slope - (float)whole, 32);
    out->law_whole[sign]  = (uint8_t)whole;
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
            return tribo_friction_f32_refuse_point(TRIBO_ERR_TABLE_FORCE, config, i);
        }
        if (!within(point->positive_n / full_scale_n, FIXED_Q31_SMALLEST, 0.999999f))
        {
            return tribo_friction_f32_refuse_point(TRIBO_ERR_TABLE_POSITIVE, config, i);
        }
        if (!within(point->negative_n / full_scale_n, FIXED_Q31_SMALLEST, 0.999999f))
        {
            return tribo_friction_f32_refuse_point(TRIBO_ERR_TABLE_NEGATIVE, config, i);
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
    out->k_min   = fixed_unsigned(config->k_min, 32 - shift);
    out->k_max   = fixed_unsigned(config->k_max, 32 - shift);
    out->k_shift = (uint8_t)shift;
}

/// Quantises the exponent (2/ln 2) m (v/v0 - 1) as a factor on the rise of |n|, for exponents up to 32.
static tribo_status_t quantize_rate(tribo_friction_q31_params_t       *out,
                                    const tribo_friction_f32_params_t *f32,
                                    float                              full_scale_n)
{
    const float per_bit = scaled(f32->exponent_per_rise * full_scale_n, -31);
    if (!(per_bit < 17.0f))
    {
        return TRIBO_ERR_V0;
    }
    const float most      = (f32->exponent_at_rest + 32.0f) / per_bit; // not finite for m = 0
    out->rise_max         = most < 2147483520.0f ? (uint32_t)most + 1u : (uint32_t)TRIBO_Q31_MAX;
    out->rise_shift       = (uint8_t)tribo_q31_leading_zeros(out->rise_max);
    out->exponent_rate    = fixed_unsigned(per_bit, 54 - (int32_t)out->rise_shift);
    out->exponent_at_rest = fixed(f32->exponent_at_rest, 22);
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

/// The range of L for loads up to full scale, before L is limited to full scale.
static breakaways_t breakaways(const tribo_friction_q31_params_t *out,
                               const tribo_friction_f32_config_t *config,
                               float                              full_scale_n)
{
    breakaways_t all = {.least = UINT64_MAX, .largest = 0};
    for (uint32_t sign = 0; sign < 2u && config->table == NULL; sign++)
    {
        const tribo_breakaway_q31_t *const law = &out->law[sign];
        include(&all, law->offset);
        include(&all, law->offset + ((uint64_t)out->law_whole[sign] << 31) + (law->slope >> 1));
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
    if (tribo_q31_high(out->set_level, (uint32_t)L.least) == 0u)
    {
        return TRIBO_ERR_SET_LEVEL;
    }
    quantize_k(out, config);
    out->gravity     = fixed_force(config->gravity_n, full_scale_n);
    out->is_shallow  = config->table == NULL && L.largest <= TRIBO_Q31_MAX;
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

void tribo_friction_q31_reset(tribo_friction_q31_state_t *state)
{
    state->n         = 0;
    state->saturated = 0;
    relay_reset(&state->relay);
}

static uint32_t at_part(int32_t lower, int32_t upper, uint32_t part)
{
    return (uint32_t)(lower + (((int64_t)upper - lower) * part >> 31));
}

/// L is linear between the points and constant beyond the first and the last. Visits every point, so the time does not
/// depend on the load.
static void from_table(const tribo_friction_q31_params_t *params, uint32_t load, uint32_t L[2])
{
    const uint32_t length = params->table_length;
    uint32_t       below  = 0; // points at or below the load
    for (uint32_t i = 0; i < length; i++)
    {
        below += load >= (uint32_t)params->table[i].force;
    }
    const tribo_breakaway_point_q31_t *lower = &params->table[below > 0u ? below - 1u : 0u];
    const tribo_breakaway_point_q31_t *upper = &params->table[below < length ? below : length - 1u];

    const uint32_t span = (uint32_t)(upper->force - lower->force);
    const uint32_t part = span > 0u ? tribo_q31_ratio(load - (uint32_t)lower->force, span) : 0u;
    L[0]                = at_part(lower->positive, upper->positive, part);
    L[1]                = at_part(lower->negative, upper->negative, part);
}

/// L by the affine law, at most full scale.
static uint32_t from_law(const tribo_friction_q31_params_t *params, uint32_t sign, uint32_t load)
{
    const uint64_t L = friction_q31_affine(&params->law[sign], load) + tribo_q31_product(params->law_whole[sign], load);
    return L < TRIBO_Q31_MAX ? (uint32_t)L : (uint32_t)TRIBO_Q31_MAX;
}

void tribo_friction_q31_look_up(const tribo_friction_q31_params_t *params, uint32_t load, uint32_t L[2])
{
    if (params->table != NULL && params->table_length > 0u) // checks both, because a bit of one may have flipped
    {
        from_table(params, load, L);
    }
    else
    {
        L[0] = from_law(params, 0, load);
        L[1] = from_law(params, 1, load);
    }
}

int32_t tribo_friction_q31_step(const tribo_friction_q31_params_t *params,
                                tribo_friction_q31_state_t        *state,
                                int32_t                            u,
                                int32_t                            force,
                                tribo_friction_q31_signals_t      *signals)
{
    const int32_t n = friction_q31_net_force(params, state, u, force);
    return friction_q31_step(params, state, n, force, signals);
}
