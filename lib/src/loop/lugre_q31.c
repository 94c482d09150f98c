#include "tribo/force_loop_q31.h"

#include <stddef.h>

tribo_status_t tribo_force_loop_lugre_q31_init(tribo_force_loop_q31_params_t       *params,
                                               tribo_breakaway_point_q31_t         *table,
                                               tribo_lugre_q31_params_t            *lugre,
                                               const tribo_force_loop_f32_config_t *config,
                                               const tribo_lugre_f32_config_t      *lugre_config,
                                               float                                full_scale_n,
                                               tribo_headroom_q31_t                *headroom)
{
    tribo_force_loop_q31_params_t made;
    tribo_headroom_q31_t          measured;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_force_loop_q31_init(&made, table, config, full_scale_n, &measured);
    if (status == TRIBO_OK)
    {
        status = tribo_lugre_q31_init(lugre, lugre_config, &config->compensator.arm, config->sample_time_s);
    }
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (headroom != NULL)
    {
        *headroom = measured;
    }
    tribo_lugre_q31_attach(&made.compensator, lugre);
    *params = made;
    return TRIBO_OK;
}
