#include "hold_q31.h"

#include "tribo/feedforward_f32.h"
#include "tribo/feedforward_q31.h"

#include "../number/fixed_q31.h"
#include "../number/parameters.h"
#include "hold_f32.h"

#include <stddef.h>

tribo_status_t tribo_hold_q31_init(tribo_hold_q31_params_t       *params,
                                   const tribo_hold_f32_config_t *config,
                                   float                          sample_time_s,
                                   float                          full_scale_n)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_hold_f32_params_t f32;
    const tribo_status_t    status = tribo_hold_f32_init(&f32, config, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    // 2^16 units or more, so that their inverse fits.
    if (!within(config->margin_travel_n / full_scale_n, 1.25e-4f, 1.0e3f))
    {
        return TRIBO_ERR_HOLD_MARGIN_TRAVEL;
    }
    if (!(f32.deadband_part >= UNITS_Q31_PART_MIN))
    {
        return TRIBO_ERR_HOLD_DEADBAND;
    }
    params->on                    = f32.on;
    params->still_ticks           = f32.still_ticks;
    params->quick_ticks           = f32.quick_ticks;
    params->gain                  = fixed_unsigned(f32.gain, 32);
    params->margin                = fixed_unsigned(f32.margin, 32);
    params->extra_margin_per_unit = fixed_unsigned(f32.extra_margin_per_n * full_scale_n, 48 - 29);
    params->deadband_part         = fixed_unsigned(f32.deadband_part, 32);
    return TRIBO_OK;
}
