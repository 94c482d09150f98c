/// The feed-forward in fixed point; feedforward_f32.h explains the method. Both compile the same text of the tick. Both
/// call the same learner in float32; on a processor without an FPU call it in the background.
///
/// Arguments and results are Q31 of one full scale FS, as in the rest of the library. The state holds forces as Q29 of
/// FS, so that lin (within 2 FS), f and b (each within FS), and the difference of any two forces fit into 32 bits. A
/// unit is 2^-29 FS, 4e-9 N at FS = 2 N. Noise and rate are slow means and stand in Q35, up to FS/128.
///
/// Without gravity, mirrored inputs give mirrored bits until something is learned. e and the term are limited to FS. A
/// tick has at most three divisions of 32 bits; a look-up in a breakaway table adds two. Not synchronized: one state,
/// one tick, one learner.

#ifndef TRIBO_FEEDFORWARD_Q31_H
#define TRIBO_FEEDFORWARD_Q31_H

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_q31.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_feedforward_q31_params tribo_feedforward_q31_params_t;
typedef struct tribo_feedforward_q31_state  tribo_feedforward_q31_state_t;
typedef struct tribo_feedforward_q31_memory tribo_feedforward_q31_memory_t;

/// Does what tribo_feedforward_f32_init does, in Q31. Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE, a status of
/// tribo_feedforward_f32_init, or the status of a parameter that does not fit full_scale_n. Writes nothing unless
/// TRIBO_OK.
tribo_status_t tribo_feedforward_q31_init(tribo_feedforward_q31_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_arm_f32_config_t         *arm,
                                          const tribo_friction_f32_params_t    *friction,
                                          float                                 input_max_n,
                                          float                                 usual_force_n,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n);

/// Does what tribo_feedforward_f32_reset does.
void tribo_feedforward_q31_reset(tribo_feedforward_q31_state_t *state);

/// Does what tribo_feedforward_f32_learn does, with the same learner in float32.
bool tribo_feedforward_q31_learn(const tribo_force_loop_q31_params_t *params, tribo_feedforward_q31_memory_t *memory);

/// Returns the learned breakaway in N, in `direction` at the end-point force `force`, Q31. Not for every tick.
tribo_feedforward_learned_t tribo_feedforward_q31_learned(const tribo_force_loop_q31_params_t *params,
                                                          const tribo_feedforward_q31_state_t *state,
                                                          uint32_t                             direction,
                                                          int32_t                              force);

/// Does what tribo_feedforward_f32_restore does.
void tribo_feedforward_q31_restore(tribo_feedforward_q31_state_t *state);

/// Names the feed-forward as the method in a loop's config, as tribo_feedforward_f32_use does for float32.
tribo_loop_part_t tribo_feedforward_q31_use(tribo_feedforward_q31_params_t       *params,
                                            const tribo_feedforward_f32_config_t *config);

// --- without a force sensor -------------------------------------------------------------------------------------------
//
// feedforward_f32.h explains the method. After a change of params the term that continues u is limited to full scale.

/// Names the method without a force sensor in a loop's config, as tribo_sensorless_f32_use does for float32.
tribo_loop_part_t tribo_sensorless_q31_use(tribo_feedforward_q31_params_t       *params,
                                           const tribo_feedforward_f32_config_t *config,
                                           const tribo_sensorless_f32_config_t  *sensorless);

/// Does what tribo_sensorless_f32_motion does; widths are Q29. A motion of more than 3.9 widths in a tick counts as
/// none.
void tribo_sensorless_q31_motion(tribo_feedforward_q31_memory_t *memory, int32_t intended, int32_t measured);

/// An estimate of F from u, without a force sensor. Forces are Q29; tribo_force_estimate_f32_t explains the members.
typedef struct
{
    uint32_t runs;
    int32_t  lagged, force, low, high;
} tribo_force_estimate_q31_t;

/// Does what tribo_force_estimate_f32_step does, with `tolerance` in Q32.
void tribo_force_estimate_q31_step(const tribo_force_loop_q31_params_t  *params,
                                   const tribo_feedforward_q31_params_t *feedforward,
                                   tribo_force_estimate_q31_t           *estimate,
                                   uint32_t                              tolerance,
                                   int32_t                               u_q31);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------
//
// feedforward_f32.h explains the members. Unless a comment says otherwise, forces are Q29 of FS and numbers Q29.

/// Constants of a tick, computed by tribo_feedforward_q31_init. Gains are Q16, parts and trust Q32.
struct tribo_feedforward_q31_params
{
    tribo_force_loop_q31_method_t method;
    int32_t                       input_max; ///< Q31
    int32_t                       offset_max, reversal;
    uint32_t                      stop_gain[TRIBO_FEEDFORWARD_STOPS]; ///< FS/d_j
    int32_t                       jump;
    uint32_t                      lead_gain, lag_gain, damping_gain; ///< alpha/(p_a h), tau/(64 h), b_arm/(K h)
    int32_t                       step, noise_floor;                 ///< noise_floor: Q35
    uint32_t noise_part, slow_part, fast_part, lag_part, actuator_part, sensor_part, leak_part, trust;
    uint32_t still_ticks, quick_ticks;
    tribo_feedforward_learning_t learning;
};

/// The learned values that the tick uses.
typedef struct
{
    int32_t  sliding, use[TRIBO_FEEDFORWARD_WEIGHTS], constant, scale;
    uint32_t trust; ///< Q32
    int32_t  turned;
    uint32_t kept; ///< Q32
    uint32_t fed_back, seal;
} tribo_feedforward_q31_weights_t;

/// A sample, which a tick posts for the learner.
typedef struct
{
    int32_t travelled, force, friction, noise, effort, need;
    uint8_t flips, turns, chatter, learns, moves, starts;
} tribo_feedforward_q31_sample_t;

/// The exchange between the tick and the learner.
typedef struct
{
    volatile uint32_t                        owner;
    volatile tribo_feedforward_q31_sample_t  sample;
    volatile tribo_feedforward_q31_weights_t result;
} tribo_feedforward_q31_exchange_t;

/// Everything that a tick remembers for the next.
struct tribo_feedforward_q31_state
{
    tribo_force_loop_q31_tick_t tick;
    uint8_t                     mode, rule, phase;
    int8_t                      sign, limited;
    uint8_t                     flips, y_good, turned_since, flipped, turns, chatter, starts;
    int32_t                     r[2], r_noise, reached, rate, turned; ///< r_noise and rate: Q35
    int32_t                     stop[TRIBO_FEEDFORWARD_STOPS], sigma, behind[2];
    int32_t                     load, own_load, lin, level, f, lead, b, e, u, v, need, turn_need;
    int32_t                     y[2], y_noise, y_now; ///< y_noise: Q35
    int32_t                     actuator, sensor, force, difference, friction, travelled, error;
    uint32_t                    offset_seal, still, since;
    int8_t                      side;
    uint8_t                     quick, rests;
    uint32_t                    late, forgotten;

    tribo_feedforward_q31_weights_t  weights;
    tribo_feedforward_q31_exchange_t exchange;
    tribo_feedforward_learner_t      learner;
};

/// The work that your loop's output does over a slide. Motion and travel are Q29 of a width.
typedef struct
{
    int32_t  moved, effort, slack;
    int8_t   side;
    uint32_t ticks;
    int64_t  travel, work, prior;
    float    last_travel, last_work, last_prior; ///< widths, N, N
} tribo_feedforward_q31_effort_t;

/// The motion of an arm without a force sensor, Q29 of a width.
typedef struct
{
    int32_t                        slack[2];
    int8_t                         sign;
    uint8_t                        is_known, was_known;
    int32_t                        measured;
    tribo_feedforward_q31_effort_t effort;
} tribo_feedforward_q31_motion_t;

/// Memory of a feed-forward. Set `&memory.state.tick` as the memory of a loop.
struct tribo_feedforward_q31_memory
{
    tribo_feedforward_q31_state_t  state;
    tribo_feedforward_q31_motion_t motion;
};

/// Does what tribo_feedforward_f32_is_learning does.
static inline bool tribo_feedforward_q31_is_learning(const tribo_feedforward_q31_state_t *state)
{
    return state->exchange.owner == TRIBO_FEEDFORWARD_OWNER_LEARNER;
}

/// Writes the functions of the feed-forward.
void tribo_feedforward_q31_method(tribo_force_loop_q31_functions_t *functions);

/// Returns the params of the feed-forward that a loop runs; null if the loop runs another method.
static inline const tribo_feedforward_q31_params_t *tribo_feedforward_q31_of(
    const tribo_force_loop_q31_params_t *params)
{
    const bool is_one = params->method != NULL && params->method->functions == tribo_feedforward_q31_method;
    return is_one ? (const tribo_feedforward_q31_params_t *)params->method : NULL; // its first member
}

/// Writes the functions of the method without a force sensor.
void tribo_sensorless_q31_method(tribo_force_loop_q31_functions_t *functions);

#ifdef __cplusplus
}
#endif

#endif
