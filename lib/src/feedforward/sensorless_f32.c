// The feed-forward without a force sensor in single precision.

#include "../number/ranges.h"
#include "learner.h"
#include "words_f32.h"

#include "reference.h"

#define FASTEST 1000.0f // x_max, widths a tick

#define ROW(...) PARAMETERS_ROW(tribo_sensorless_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_sensorless_parameters[] = {TRIBO_SENSORLESS_PARAMETERS(ROW)};
#undef ROW

static bool is_part(float x)
{
    return within(x, 0.0f, 1.0f);
}

static float number_of_sum(wide_t x)
{
    return x;
}

#include "sensorless.h"

tribo_sensorless_f32_config_t tribo_sensorless_f32_default(void)
{
    const tribo_sensorless_f32_config_t standard = {TRIBO_SENSORLESS_PARAMETERS(PARAMETERS_DEFAULT)};
    return standard;
}

tribo_status_t tribo_force_loop_sensorless_f32_init(tribo_force_loop_f32_params_t        *params,
                                                    tribo_feedforward_f32_params_t       *feedforward,
                                                    const tribo_force_loop_f32_config_t  *config,
                                                    const tribo_feedforward_f32_config_t *feedforward_config,
                                                    const tribo_sensorless_f32_config_t  *sensorless_config)
{
    if (sensorless_config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = PARAMETERS_CHECK(tribo_sensorless_parameters, sensorless_config);
    if (status == TRIBO_OK)
    {
        status = tribo_force_loop_feedforward_f32_init(params, feedforward, config, feedforward_config);
    }
    if (status == TRIBO_OK)
    {
        feedforward->trust            = sensorless_config->belief;
        feedforward->method.functions = tribo_sensorless_f32_method;
    }
    return status;
}
