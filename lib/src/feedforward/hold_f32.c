#include "hold_f32.h"

#include "tribo/feedforward_f32.h"

#include "../number/parameters.h"

#include <stddef.h>

tribo_hold_f32_config_t tribo_hold_f32_default(void)
{
    const tribo_hold_f32_config_t standard = {TRIBO_HOLD_PARAMETERS(PARAMETERS_DEFAULT)};
    return standard;
}

tribo_status_t tribo_hold_f32_init(tribo_hold_f32_params_t       *params,
                                   const tribo_hold_f32_config_t *config,
                                   float                          sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!sample_time_ok(sample_time_s))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    const tribo_status_t status = PARAMETERS_CHECK(tribo_hold_parameters, config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    params->on                 = config->gain > 0.0f;
    params->still_ticks        = (uint32_t)(config->still_time_s / sample_time_s + 0.5f) + 1u;
    params->quick_ticks        = (uint32_t)(config->quick_time_s / sample_time_s + 0.5f) + 1u;
    params->gain               = config->gain;
    params->margin             = config->margin;
    params->extra_margin_per_n = 1.0f / config->margin_travel_n;
    params->deadband_part      = first_order_f32_lag(config->deadband_time_s, sample_time_s);
    return TRIBO_OK;
}
