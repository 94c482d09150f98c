/// The feed-forward without a force sensor, for drives with current and encoder only, single precision.
///
///     u = limit(lin + f + lead - b)          f = belief L(rs) sigma
///
/// A method of the force loop: steps 2 to 6 of feedforward_f32.h with the stops left out, its params and its memory. y is not
/// used (give 0), the controller's output is taken out of u, and nothing is learned. b is 0, or what u goes on from after a change
/// of params, and fades in a quarter of a second. It has no feedback: u is as right as L is, so it believes low.
///
/// r is the force that the arm shall have, or the effort of somebody else's position or velocity loop. With that, and wherever
/// the motion is known better than by r, tell it: tribo_sensorless_f32_motion.
///
/// No guard: it judges y. A corrupt memory is forgotten whole and counted, as the feed-forward's. No loops, one division a tick.

#ifndef TRIBO_SENSORLESS_F32_H
#define TRIBO_SENSORLESS_F32_H

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct
{
    float belief; ///< part of the believed breakaway that is fed forward, 0 to 1
} tribo_sensorless_f32_config_t;

/// The default: believes low.
tribo_sensorless_f32_config_t tribo_sensorless_f32_default(void);

/// Makes `params` as the feed-forward's init does, for a loop without a sensor; of `feedforward_config` it uses the actuator's pole,
/// reversal_n, jump_time_s and jump_lead. The memory is attached as the feed-forward's.
tribo_status_t tribo_force_loop_sensorless_f32_init(tribo_force_loop_f32_params_t        *params,
                                                    tribo_feedforward_f32_params_t       *feedforward,
                                                    const tribo_force_loop_f32_config_t  *config,
                                                    const tribo_feedforward_f32_config_t *feedforward_config,
                                                    const tribo_sensorless_f32_config_t  *sensorless_config);

/// Before a tick: the motion of the arm in it, intended and measured, each in widths of a reversal, e.g. a change of position over
/// the travel that is surely a reversal and no noise, or a speed times h over that. 0 where there is none. Friction opposes the
/// intended motion; while that is at rest, the measured. In a tick without this call, r decides. Friction never jumps between them.
void tribo_sensorless_f32_motion(tribo_feedforward_f32_memory_t *memory, float intended, float measured);

/// Of F, from u alone.
typedef struct
{
    uint32_t runs;
    float    lagged_n; ///< u behind the lag of actuator and arm
    float    force_n;  ///< F^: an arm that sticks within L
    float    low_n,
        high_n; ///< the same with L times (1 - tolerance) to (1 + tolerance): F is between, beside the lag's error
} tribo_force_estimate_f32_t;

/// One tick with `u_n` as applied, by the params of a loop with or without a sensor. From runs = 0 any F is possible. A tolerance
/// or a force that is not credible changes nothing.
void tribo_force_estimate_f32_step(const tribo_force_loop_f32_params_t  *params,
                                   const tribo_feedforward_f32_params_t *feedforward,
                                   tribo_force_estimate_f32_t           *estimate,
                                   float                                 tolerance,
                                   float                                 u_n);

/// The method, for params made on a host.
#define TRIBO_SENSORLESS_F32_METHOD                                                                                    \
    {.error    = tribo_sensorless_f32_method_error,                                                                    \
     .friction = tribo_sensorless_f32_method_friction,                                                                 \
     .term     = tribo_sensorless_f32_method_term,                                                                     \
     .after    = tribo_sensorless_f32_method_after,                                                                    \
     .last     = tribo_sensorless_f32_method_last,                                                                     \
     .enter    = tribo_sensorless_f32_method_enter}

float tribo_sensorless_f32_method_error(const tribo_force_loop_f32_params_t *loop,
                                        void                                *memory,
                                        float                                r_n,
                                        float                                y_n,
                                        float                                fade);
float tribo_sensorless_f32_method_friction(const void *memory);
float tribo_sensorless_f32_method_term(const tribo_force_loop_f32_params_t *loop, void *memory, float v_n);
void  tribo_sensorless_f32_method_after(const tribo_force_loop_f32_params_t *loop,
                                        void                                *memory,
                                        float                                v_n,
                                        float                                u_n,
                                        tribo_force_loop_f32_signals_t      *seen);
void  tribo_sensorless_f32_method_last(const void *memory, tribo_force_loop_f32_last_t *last);
void  tribo_sensorless_f32_method_enter(void *memory, float term_n, bool anew);

#ifdef __cplusplus
}
#endif

#endif
