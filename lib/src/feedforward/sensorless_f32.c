// The feed-forward without a force sensor in single precision.

#include "../number/ranges.h"
#include "learner.h"
#include "words_f32.h"

#include "reference.h"

#define FASTEST 1000.0f // largest credible motion in a tick, widths

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

static tribo_status_t part_make(const tribo_loop_part_t             *part,
                                const tribo_force_loop_f32_config_t *loop,
                                tribo_force_loop_f32_params_t       *made)
{
    const tribo_sensorless_f32_config_t *const sensorless = (const tribo_sensorless_f32_config_t *)part->sensorless;
    if (sensorless == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = PARAMETERS_CHECK(tribo_sensorless_parameters, sensorless);
    if (status == TRIBO_OK)
    {
        status = tribo_feedforward_f32_make(part, loop, made);
    }
    if (status == TRIBO_OK)
    {
        params_t *const params   = (params_t *)part->params;
        params->trust            = sensorless->belief;
        params->method.functions = tribo_sensorless_f32_method;
    }
    return status;
}

tribo_loop_part_t tribo_sensorless_f32_use(tribo_feedforward_f32_params_t       *params,
                                           const tribo_feedforward_f32_config_t *config,
                                           const tribo_sensorless_f32_config_t  *sensorless)
{
    tribo_loop_part_t part = {.config = config, .sensorless = sensorless, .params = params};
    part.make_f32          = part_make;
    return part;
}
