#include "tribo/controller_q31.h"

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "anti_windup_f32.h"
#include "anti_windup_q31.h"
#include "headroom_q31.h"

#include <stddef.h>

/// Writes x, below 2^30, as `mantissa` 2^(shift - 32) with a shift of 1 to 31. The mantissa has 31 significant bits if
/// that shift allows.
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

static tribo_status_t check_limits(const tribo_controller_f32_params_t *f32, float full_scale_n)
{
    if (!(f32->u_min_n >= -full_scale_n))
    {
        return TRIBO_ERR_U_MIN;
    }
    const bool wide =
        (f32->u_max_n - f32->u_min_n) / full_scale_n >= FIXED_Q31_SMALLEST; // otherwise too few bits would be left
    return f32->u_max_n <= full_scale_n && wide ? TRIBO_OK : TRIBO_ERR_U_MAX;
}

/// How much a limit may change the last node at most: with more, the correction would exceed full scale at some node.
static int32_t taken_max(const tribo_controller_q31_params_t *made)
{
    float gain = magnitude(scaled((float)made->anti_windup, (int32_t)made->anti_windup_shift - 32));
    float most = larger(gain, 1.0f);
    for (uint32_t i = 0; i < made->cascade.count; i++)
    {
        gain *= magnitude(scaled((float)made->cascade.section[i].b0, -28));
        most = larger(gain, most);
    }
    // Stay just below full scale, closer than the margin of the headroom. 5 units cover the rounding here and in the
    // correction.
    return fixed(0.99999f / most, 31) - 5;
}

/// A refusal of the rounded sections shows the number that was given.
static tribo_status_t refuse_as_given(tribo_status_t status, const tribo_controller_f32_config_t *config)
{
    tribo_refusal_t *const refusal = config->refusal;
    if (refusal == NULL)
    {
        return status;
    }
    const uint32_t index = refusal->index;
    return tribo_element_refuse(status,
                                tribo_section_numbers,
                                refusal->member,
                                &config->sections[index],
                                index,
                                refusal);
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
    float                         c      = 0.0f; // chosen for the design, because rounding must not choose another
    tribo_status_t                status = tribo_controller_f32_prepare(&f32, config, &c);
    status                               = status != TRIBO_OK ? status : check_limits(&f32, full_scale_n);
    if (status != TRIBO_OK)
    {
        return status;
    }
    const float u_peak = larger(-f32.u_min_n, f32.u_max_n) / full_scale_n;
    status = tribo_headroom_q31_quantize(&made.cascade, &f32, config, &c, FIXED_Q31_FULL, u_peak + 1.0f, headroom);
    if (status == TRIBO_ERR_HEADROOM)
    {
        return tribo_element_refuse(status, tribo_section_numbers, 0, config->sections, 0, config->refusal);
    }
    if (status != TRIBO_OK)
    {
        return refuse_as_given(status, config);
    }
    const int32_t by = (int32_t)made.cascade.output_scale - (int32_t)made.cascade.input_scale;
    // The scaled c/D is below 2^24, because the part of s in the anti-windup stays below full scale at the input node.
    normalise(scaled(f32.anti_windup, by), &made.anti_windup, &made.anti_windup_shift);
    made.taken_max = taken_max(&made);
    made.u_min     = fixed_force(f32.u_min_n, full_scale_n);
    made.u_max     = fixed_force(f32.u_max_n, full_scale_n);
    *params        = made;
    return TRIBO_OK;
}

void tribo_controller_q31_reset(tribo_controller_q31_state_t *state)
{
    tribo_biquad_q31_reset(&state->cascade);
    state->limited_ticks = 0;
}
