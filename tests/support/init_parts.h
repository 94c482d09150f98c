// Set-up in the arithmetic of the file that includes this, of parts that the tests keep beside each other.

#ifndef TESTS_SUPPORT_INIT_PARTS_H
#define TESTS_SUPPORT_INIT_PARTS_H

#include "../../wire/tribo_arithmetic.h"

/// Does what tribo_init_loop does, with the feed-forward in place of the method that `config` names.
static inline tribo_status_t tribo_init_feedforward(TRIBO(force_loop, params_t) * params,
                                                    tribo_point_t *table,
                                                    TRIBO(feedforward, params_t) * feedforward,
                                                    const tribo_force_loop_f32_config_t  *config,
                                                    const tribo_feedforward_f32_config_t *feedforward_config,
                                                    float                                 full_scale_n)
{
    tribo_force_loop_f32_config_t whole = *config;
    whole.method                        = TRIBO(feedforward, use)(feedforward, feedforward_config);
    return tribo_init_loop(params, table, &whole, full_scale_n);
}

/// Does the same without a force sensor.
static inline tribo_status_t tribo_init_sensorless(TRIBO(force_loop, params_t) * params,
                                                   tribo_point_t *table,
                                                   TRIBO(feedforward, params_t) * feedforward,
                                                   const tribo_force_loop_f32_config_t  *config,
                                                   const tribo_feedforward_f32_config_t *feedforward_config,
                                                   const tribo_sensorless_f32_config_t  *sensorless_config,
                                                   float                                 full_scale_n)
{
    tribo_force_loop_f32_config_t whole = *config;
    whole.method                        = TRIBO(sensorless, use)(feedforward, feedforward_config, sensorless_config);
    return tribo_init_loop(params, table, &whole, full_scale_n);
}

/// A guard beside a loop.
static inline tribo_status_t tribo_init_guard(TRIBO(guard, params_t) * params,
                                              const tribo_guard_f32_config_t *config,
                                              float                           sample_time_s,
                                              float                           full_scale_n)
{
#ifdef TRIBO_ARITHMETIC_Q31
    return tribo_guard_q31_init(params, config, sample_time_s, full_scale_n);
#else
    (void)full_scale_n;
    return tribo_guard_f32_init(params, config, sample_time_s);
#endif
}

#endif
