/// The feed-forward without a force sensor in fixed point: the twin of sensorless_f32.h, in the formats of feedforward_q31.h.
///
/// What u goes on from after a change of params is within full scale of the controller's output.

#ifndef TRIBO_SENSORLESS_Q31_H
#define TRIBO_SENSORLESS_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/sensorless_f32.h"
#include "tribo/status.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// See the twin.
tribo_status_t tribo_force_loop_sensorless_q31_init(tribo_force_loop_q31_params_t        *params,
                                                    tribo_breakaway_point_q31_t          *table,
                                                    tribo_feedforward_q31_params_t       *feedforward,
                                                    const tribo_force_loop_f32_config_t  *config,
                                                    const tribo_feedforward_f32_config_t *feedforward_config,
                                                    const tribo_sensorless_f32_config_t  *sensorless_config,
                                                    float                                 full_scale_n,
                                                    tribo_headroom_q31_t                 *headroom);

/// See the twin; widths in Q29, within +-4.
void tribo_sensorless_q31_motion(tribo_feedforward_q31_memory_t *memory, int32_t intended, int32_t measured);

/// Of F, from u alone; Q29.
typedef struct
{
    uint32_t runs;
    int32_t  lagged, force, low, high;
} tribo_force_estimate_q31_t;

/// See the twin; `tolerance` in Q32.
void tribo_force_estimate_q31_step(const tribo_force_loop_q31_params_t  *params,
                                   const tribo_feedforward_q31_params_t *feedforward,
                                   tribo_force_estimate_q31_t           *estimate,
                                   uint32_t                              tolerance,
                                   int32_t                               u_q31);

/// The method, for params made on a host.
#define TRIBO_SENSORLESS_Q31_METHOD                                                                                    \
    {.error    = tribo_sensorless_q31_method_error,                                                                    \
     .friction = tribo_sensorless_q31_method_friction,                                                                 \
     .term     = tribo_sensorless_q31_method_term,                                                                     \
     .after    = tribo_sensorless_q31_method_after,                                                                    \
     .last     = tribo_sensorless_q31_method_last,                                                                     \
     .enter    = tribo_sensorless_q31_method_enter}

int32_t tribo_sensorless_q31_method_error(const tribo_force_loop_q31_params_t *loop,
                                          void                                *memory,
                                          int32_t                              r_q31,
                                          int32_t                              y_q31,
                                          uint32_t                             fade);
int32_t tribo_sensorless_q31_method_friction(const void *memory);
int32_t tribo_sensorless_q31_method_term(const tribo_force_loop_q31_params_t *loop, void *memory, int32_t v);
void    tribo_sensorless_q31_method_after(const tribo_force_loop_q31_params_t *loop,
                                          void                                *memory,
                                          int32_t                              v,
                                          int32_t                              u_q31,
                                          tribo_force_loop_q31_signals_t      *seen);
void    tribo_sensorless_q31_method_last(const void *memory, tribo_force_loop_q31_last_t *last);
void    tribo_sensorless_q31_method_enter(void *memory, int32_t term, bool anew);

#ifdef __cplusplus
}
#endif

#endif
