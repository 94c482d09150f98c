#include "tribo/force_loop_f32.h"

#include "../number/ieee_f32.h"

#include <stddef.h>

tribo_status_t tribo_force_loop_lugre_f32_init(tribo_force_loop_f32_params_t       *params,
                                               tribo_lugre_f32_params_t            *lugre,
                                               const tribo_force_loop_f32_config_t *config,
                                               const tribo_lugre_f32_config_t      *lugre_config)
{
    tribo_force_loop_f32_params_t made;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_force_loop_f32_init(&made, config);
    if (status == TRIBO_OK)
    {
        status = tribo_lugre_f32_init(lugre, lugre_config, &config->compensator.arm, config->sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        tribo_lugre_f32_attach(&made.compensator, lugre);
        *params = made;
    }
    return status;
}
