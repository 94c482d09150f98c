#include "tribo/force_loop_q31.h"

#include "tribo/force_loop_f32.h"

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "loop_q31.h"

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
    if (!within(config->input_max_n / full_scale_n, FIXED_Q31_SMALLEST, 1.0f))
    {
        return TRIBO_ERR_INPUT_MAX;
    }
    tribo_headroom_q31_t          measured;
    tribo_force_loop_q31_params_t made = {.input_max = fixed_input_max(config->input_max_n, full_scale_n),
                                          .gain      = fixed(f32.gain, LOOP_Q31_GAIN_FRACTION)};

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
    *params = made;
    return TRIBO_OK;
}

#include "step.h"
