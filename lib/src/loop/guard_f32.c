#include "guard_f32.h"

#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

#include "../number/ranges.h"
#include "prepare.h"

#include <stddef.h>

#define ROW(...) PARAMETERS_ROW(tribo_guard_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_guard_parameters[] = {TRIBO_GUARD_PARAMETERS(ROW)};
#undef ROW

tribo_guard_f32_config_t tribo_guard_f32_default(void)
{
    const tribo_guard_f32_config_t standard = {TRIBO_GUARD_PARAMETERS(PARAMETERS_DEFAULT)};
    return standard;
}

tribo_guard_f32_config_t tribo_guard_f32_tuned(float breakaway_n, float lag_s, float noise_n, float sample_time_s)
{
    const float longest = 1.0e5f * sample_time_s; // this and 1000 s: upper limits of tribo_guard_f32_prepare
    const float quick   = limit_f32(16.0f * lag_s, 20.0f * sample_time_s, longest);
    // The other members' defaults stay out of the image.
    const float fade = tribo_guard_parameters[TRIBO_ERR_GUARD_FADE_TIME - TRIBO_ERR_GUARD_TURN].standard;
    return (tribo_guard_f32_config_t){.turn_n       = breakaway_n / 3.14f,
                                      .quick_time_s = quick < 1.0e3f ? quick : 1.0e3f,
                                      .stray_n      = larger(breakaway_n / 15.7f, 8.0f * noise_n),
                                      .fade_time_s  = fade};
}

tribo_status_t tribo_guard_f32_init(tribo_guard_f32_params_t       *params,
                                    const tribo_guard_f32_config_t *config,
                                    float                           sample_time_s)
{
    const tribo_status_t status = tribo_guard_f32_prepare(params, config, sample_time_s);
    if (status == TRIBO_OK)
    {
        params->step = tribo_guard_f32_step;
    }
    return status;
}

tribo_status_t tribo_guard_f32_prepare(tribo_guard_f32_params_t       *params,
                                       const tribo_guard_f32_config_t *config,
                                       float                           sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!sample_time_ok(sample_time_s))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    const tribo_status_t status = PARAMETERS_CHECK(tribo_guard_parameters, config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!(config->quick_time_s <= 1.0e5f * sample_time_s))
    {
        return TRIBO_ERR_GUARD_QUICK_TIME;
    }
    if (!(config->fade_time_s <= 1.0e6f * sample_time_s)) // 1 less a smaller step would round to 1
    {
        return TRIBO_ERR_GUARD_FADE_TIME;
    }
    const float fade_step = sample_time_s / config->fade_time_s;
    params->on            = 1;
    params->half_n        = 0.5f * config->turn_n;
    params->stray_n       = config->stray_n;
    params->work          = config->turn_n * config->stray_n;
    params->fade_step     = fade_step < 1.0f ? fade_step : 1.0f;
    params->quick_ticks   = (uint32_t)(config->quick_time_s / sample_time_s + 0.5f) + 1u;
    return TRIBO_OK;
}

#define guard_init(params, config, sample_time_s, full_scale_n) tribo_guard_f32_init(params, config, sample_time_s)

#include "guard_step.h"
