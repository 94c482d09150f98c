/// The feed-forward in fixed point: the twin of feedforward_f32.h. The tick is the same text, compiled for integers; the learner is the
/// same function, in float32, and is called in the background on a processor without an FPU.
///
/// Arguments and results are Q31 of one full scale FS, as in the rest of the library. Inside, forces are Q29 of FS, a quarter of
/// 32 bits, so that lin (within 2 FS), f and b (each within FS), and the difference of any two forces fit. A unit is 2^-29 FS,
/// 4e-9 N at 2 N. Noise and rate, which are slow means, are Q35, up to FS/128.
///
/// Mirrored inputs, without gravity, give mirrored bits as long as nothing is learned. e and the term are limited to FS.
/// A tick has at most three divisions of 32 bits, a look-up in a table two more. Not synchronized: one state, one tick, one learner.

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

/// Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE, a status of tribo_feedforward_f32_init, or that of a parameter that full_scale_n does
/// not suit. Writes nothing unless TRIBO_OK. It leaves params.method empty, as tribo_feedforward_f32_init.
tribo_status_t tribo_feedforward_q31_init(tribo_feedforward_q31_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_arm_f32_config_t         *arm,
                                          const tribo_friction_f32_params_t    *friction,
                                          float                                 input_max_n,
                                          float                                 usual_force_n,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n);

/// Forgets what was learned; the next good tick is the first. A start without `keep_learned` does it, too.
void tribo_feedforward_q31_reset(tribo_feedforward_q31_state_t *state);

/// As tribo_feedforward_f32_learn, with which it shares the learner in float32.
bool tribo_feedforward_q31_learn(const tribo_force_loop_q31_params_t *params, tribo_feedforward_q31_memory_t *memory);

/// Learned breakaway in `direction` at the end-point force `force`, Q31; the result is in N. Not for every tick.
tribo_feedforward_learned_t tribo_feedforward_q31_learned(const tribo_force_loop_q31_params_t *params,
                                                          const tribo_feedforward_q31_state_t *state,
                                                          uint32_t                             direction,
                                                          int32_t                              force);

/// Unlatches stays_at_bound and harms, and feeds friction forward; learned values stay.
void tribo_feedforward_q31_restore(tribo_feedforward_q31_state_t *state);

/// See the twin.
tribo_loop_part_t tribo_feedforward_q31_use(tribo_feedforward_q31_params_t       *params,
                                            const tribo_feedforward_f32_config_t *config);

// --- without a force sensor; see the twin -----------------------------------------------------------------------------
//
// What u goes on from after a change of params is within full scale of the controller's output.

/// See the twin.
tribo_loop_part_t tribo_sensorless_q31_use(tribo_feedforward_q31_params_t       *params,
                                           const tribo_feedforward_f32_config_t *config,
                                           const tribo_sensorless_f32_config_t  *sensorless);

/// See the twin; widths in Q29. A tick of more than 3.9 widths is taken for none.
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

// --- what they hold: give it room; write only what a comment says ------------------------------------------------------

/// Constants of a tick, made by tribo_feedforward_q31_init; see the twin. Forces are Q29 of FS, gains Q16, parts Q32.
struct tribo_feedforward_q31_params
{
    tribo_force_loop_q31_method_t method;                             ///< for a loop with the feed-forward
    int32_t                       input_max;                          ///< Q31
    int32_t                       offset_max;                         ///< up to FS
    int32_t                       reversal;                           ///< w
    uint32_t                      stop_gain[TRIBO_FEEDFORWARD_STOPS]; ///< FS/d_j
    int32_t                       jump;                               ///< Q29
    uint32_t                      lead_gain, lag_gain, damping_gain;  ///< alpha/(p_a h), tau/(64 h), b_arm/(K h)
    int32_t                       step;
    int32_t                       noise_floor; ///< Q35
    uint32_t noise_part, slow_part, fast_part, lag_part, actuator_part, sensor_part, leak_part, trust;
    uint32_t still_ticks, quick_ticks;
    tribo_feedforward_learning_t learning;
};

/// What the tick uses of what is learned.
typedef struct
{
    int32_t  sliding;                        ///< V_0, Q29
    int32_t  use[TRIBO_FEEDFORWARD_WEIGHTS]; ///< U_j, Q29
    int32_t  constant, scale;                ///< c_0, c_2; Q29
    uint32_t trust;                          ///< 1 - (1 - gamma) doubt, Q32
    int32_t  turned;                         ///< V_0 from a reversal on
    uint32_t kept;                           ///< part of the load that stays there, Q32
    uint32_t fed_back;                       ///< 1: friction fed forward does harm
    uint32_t seal;                           ///< of these numbers: one that does not fit is corrupt
} tribo_feedforward_q31_weights_t;

/// What a tick posts for the learner.
typedef struct
{
    int32_t travelled, force, friction, noise, effort; ///< m, yf, z, n_y, LP(v)
    int32_t need;                                      ///< v + f - b at the last reversal
    uint8_t flips, turns, chatter; ///< since the last sample: reversals, those where r did not stand, chatter
    uint8_t learns, moves, starts; ///< 1: r moves and y is good; f is fed forward; first sample of a run
} tribo_feedforward_q31_sample_t;

/// See the twin.
typedef struct
{
    volatile uint32_t                        owner; ///< tribo_feedforward_owner_t
    volatile tribo_feedforward_q31_sample_t  sample;
    volatile tribo_feedforward_q31_weights_t result;
} tribo_feedforward_q31_exchange_t;

/// All that a tick leaves to the next. Forces are Q29 of FS, slow means Q35, numbers Q29.
struct tribo_feedforward_q31_state
{
    tribo_force_loop_q31_tick_t      tick;          ///< what the loop reads
    uint8_t                          mode, rule;    ///< tribo_feedforward_mode_t, tribo_feedforward_offset_t
    uint8_t                          phase;         ///< ticks since the last sample
    int8_t                           sign, limited; ///< s, 0 before the first move; sign of the limit that u met
    uint8_t                          flips, y_good; ///< in this tick: r reverses; y is credible
    uint8_t                          turned_since;  ///< since the last sample was posted
    uint8_t                          flipped, turns, chatter, starts;      ///< for the next sample
    int32_t                          r[2], r_noise;                        ///< the last good r, and the one before; n_r
    int32_t                          reached, rate, turned;                ///< rs, its change in a tick, rp'
    int32_t                          stop[TRIBO_FEEDFORWARD_STOPS], sigma; ///< phi_j, sigma
    int32_t                          behind[2];                            ///< m_1 and m_2 less rs
    int32_t                          load, own_load;  ///< what does not reverse, and the part of it that is learned
    int32_t                          lin, level;      ///< force without friction; share L
    int32_t                          f, lead, b;      ///< u = limit(v + lin + f + lead - b)
    int32_t                          e, u, v;         ///< v: low pass
    int32_t                          need, turn_need; ///< f - b of the last tick; with v, of the last reversal
    int32_t                          y[2], y_noise, y_now; ///< the last good y, and the one before; n_y; y of this tick
    int32_t                          actuator, sensor, force;         ///< u_1, u_2, yf
    int32_t                          difference, friction, travelled; ///< zf, z, m
    int32_t                          error;                           ///< mean of e, in a hold a step of r
    uint32_t                         offset_seal;                     ///< ~b, from a tick to the next
    uint32_t                         still, since;    ///< ticks of standing; ticks since the last change of side
    int8_t                           side;            ///< of breakaway that friction reached last
    uint8_t                          quick;           ///< changes of side in quick succession, up to 4
    uint8_t                          rests;           ///< the error is within the noise, and u stays
    uint32_t                         late, forgotten; ///< late results; corrupt states; both stop at UINT32_MAX
    tribo_feedforward_q31_weights_t  weights;
    tribo_feedforward_q31_exchange_t exchange;
    tribo_feedforward_learner_t      learner;
};

/// See the twin. Motion is Q29 of a width, in a sum too; forces are Q29 of FS.
typedef struct
{
    int32_t  moved, effort; ///< motion of a tick, and u without the model's load; low passes
    int32_t  slack;         ///< of moved, in a play a width wide
    int8_t   side;          ///< sign of the slide, 0: none yet
    uint32_t ticks;         ///< of the slide; at its most, the slide does not count
    int64_t  travel, work, prior;
    float    last_travel;           ///< widths
    float    last_work, last_prior; ///< N
} tribo_feedforward_q31_effort_t;

/// Of a loop without a sensor.
typedef struct
{
    int32_t                        slack[2];  ///< of a play a width wide, intended and measured
    int8_t                         sign;      ///< of the last motion, 0: none yet
    uint8_t                        is_known;  ///< in this tick
    uint8_t                        was_known; ///< in any tick: what is learned is used
    int32_t                        measured;  ///< in this tick, Q29
    tribo_feedforward_q31_effort_t effort;
} tribo_feedforward_q31_motion_t;

/// See the twin.
struct tribo_feedforward_q31_memory
{
    tribo_feedforward_q31_state_t  state;
    tribo_feedforward_q31_motion_t motion;
};

/// True while the learner has a sample: then leave reset, restore and a start without keep_learned alone unless the caller is the one who learns.
static inline bool tribo_feedforward_q31_is_learning(const tribo_feedforward_q31_state_t *state)
{
    return state->exchange.owner == TRIBO_FEEDFORWARD_OWNER_LEARNER;
}

/// Writes the functions of the feed-forward as a method of the force loop, for the first member of its params.
void tribo_feedforward_q31_method(tribo_force_loop_q31_functions_t *functions);

/// The feed-forward's params of a loop; null for another method.
static inline const tribo_feedforward_q31_params_t *tribo_feedforward_q31_of(
    const tribo_force_loop_q31_params_t *params)
{
    const bool is_one = params->method != NULL && params->method->functions == tribo_feedforward_q31_method;
    return is_one ? (const tribo_feedforward_q31_params_t *)params->method : NULL; // its first member
}

/// Writes the functions of the feed-forward without a force sensor, likewise.
void tribo_sensorless_q31_method(tribo_force_loop_q31_functions_t *functions);

#ifdef __cplusplus
}
#endif

#endif
