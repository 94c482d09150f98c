#include "app/loop_setup.h"

#include "tribo/quantize_feedforward_q31.h"

#include <stddef.h>

tribo_status_t loop_setup(loop_setup_t *setup, const tribo_force_loop_f32_config_t *config, float full_scale_n)
{
#ifdef DRIVE_ARITH_Q31
    return tribo_force_loop_q31_init(&setup->params, setup->table, config, full_scale_n, NULL);
#else
    (void)full_scale_n;
    return tribo_force_loop_f32_init(&setup->params, config);
#endif
}

#if DRIVE_FEEDFORWARD
tribo_status_t loop_setup_feedforward(loop_setup_t                         *setup,
                                      const tribo_force_loop_f32_config_t  *config,
                                      const tribo_feedforward_f32_config_t *feedforward,
                                      float                                 full_scale_n)
{
#ifdef DRIVE_ARITH_Q31
    return tribo_force_loop_feedforward_q31_init(&setup->params,
                                                 setup->table,
                                                 &setup->feedforward,
                                                 config,
                                                 feedforward,
                                                 full_scale_n,
                                                 NULL);
#else
    (void)full_scale_n;
    return tribo_force_loop_feedforward_f32_init(&setup->params, &setup->feedforward, config, feedforward);
#endif
}

tribo_status_t loop_setup_guard(loop_guard_params_t            *guard,
                                const tribo_guard_f32_config_t *config,
                                float                           sample_time_s,
                                float                           full_scale_n)
{
    guard->on = false;
#ifdef DRIVE_ARITH_Q31
    return tribo_guard_q31_init(&guard->params, config, sample_time_s, full_scale_n);
#else
    (void)full_scale_n;
    return tribo_guard_f32_init(&guard->params, config, sample_time_s);
#endif
}
#endif
