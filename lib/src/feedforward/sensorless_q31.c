// The feed-forward without a force sensor in fixed point. Sums over a slide are Q29 in 64 bits: X stays within 2^22
// widths and W within 2^23 FS.

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "learner.h"
#include "words_q31.h"

#include "reference.h"

#define FASTEST NUMBER(3.9) // largest motion in a tick that fits, widths

static bool is_part(uint32_t x)
{
    (void)x;
    return true;
}

static float number_of_sum(wide_t x)
{
    return (float)x / 536870912.0f;
}

#include "sensorless.h"

static tribo_status_t part_make(const tribo_loop_part_t             *part,
                                const tribo_force_loop_f32_config_t *loop,
                                float                                full_scale_n,
                                tribo_force_loop_q31_params_t       *made)
{
    const tribo_sensorless_f32_config_t *const sensorless = (const tribo_sensorless_f32_config_t *)part->sensorless;
    if (sensorless == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = PARAMETERS_CHECK(tribo_sensorless_parameters, sensorless);
    if (status == TRIBO_OK)
    {
        status = tribo_feedforward_q31_make(part, loop, full_scale_n, made);
    }
    if (status == TRIBO_OK)
    {
        params_t *const params   = (params_t *)part->params;
        params->trust            = fixed_unsigned(sensorless->belief, 32);
        params->method.functions = tribo_sensorless_q31_method;
    }
    return status;
}

tribo_loop_part_t tribo_sensorless_q31_use(tribo_feedforward_q31_params_t       *params,
                                           const tribo_feedforward_f32_config_t *config,
                                           const tribo_sensorless_f32_config_t  *sensorless)
{
    tribo_loop_part_t part = {.config = config, .sensorless = sensorless, .params = params};
    part.make_q31          = part_make;
    return part;
}
