// The feed-forward without a force sensor in fixed point. Sums over a slide are Q29 in 64 bits: X within 2^22 widths, W within 2^23 FS.

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "learner.h"
#include "words_q31.h"

#include "reference.h"

#define FASTEST NUMBER(3.9) // x_max, widths a tick

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

tribo_status_t tribo_force_loop_sensorless_q31_init(tribo_force_loop_q31_params_t        *params,
                                                    tribo_breakaway_point_q31_t          *table,
                                                    tribo_feedforward_q31_params_t       *feedforward,
                                                    const tribo_force_loop_f32_config_t  *config,
                                                    const tribo_feedforward_f32_config_t *feedforward_config,
                                                    const tribo_sensorless_f32_config_t  *sensorless_config,
                                                    float                                 full_scale_n,
                                                    tribo_headroom_q31_t                 *headroom)
{
    if (sensorless_config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = PARAMETERS_CHECK(tribo_sensorless_parameters, sensorless_config);
    if (status == TRIBO_OK)
    {
        status = tribo_force_loop_feedforward_q31_init(params,
                                                       table,
                                                       feedforward,
                                                       config,
                                                       feedforward_config,
                                                       full_scale_n,
                                                       headroom);
    }
    if (status == TRIBO_OK)
    {
        feedforward->trust            = fixed_unsigned(sensorless_config->belief, 32);
        feedforward->method.functions = tribo_sensorless_q31_method;
    }
    return status;
}
