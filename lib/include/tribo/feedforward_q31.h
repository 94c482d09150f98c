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

/// Forgets what was learned; the next good tick is the first one. A start without `keep_learned` does this, too.
void tribo_feedforward_q31_reset(tribo_feedforward_q31_state_t *state);

/// Does what tribo_feedforward_f32_learn does, with the same learner in float32.
bool tribo_feedforward_q31_learn(const tribo_force_loop_q31_params_t *params, tribo_feedforward_q31_memory_t *memory);

/// Returns the learned breakaway in N, in `direction` at the end-point force `force`, Q31. Not for every tick.
tribo_feedforward_learned_t tribo_feedforward_q31_learned(const tribo_force_loop_q31_params_t *params,
                                                          const tribo_feedforward_q31_state_t *state,
                                                          uint32_t                             direction,
                                                          int32_t                              force);

/// Clears the latched stays_at_bound and harms, and feeds friction forward again. Learned values stay.
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

/// Constants of a tick, computed by tribo_feedforward_q31_init; tribo_feedforward_f32_params explains them. Forces are
/// Q29 of FS, gains Q16, parts Q32.
struct tribo_feedforward_q31_params
{
    tribo_force_loop_q31_method_t method;                             ///< a loop with the feed-forward points here
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

/// The learned values that the tick uses.
typedef struct
{
    int32_t  sliding;                        ///< V_0, Q29
    int32_t  use[TRIBO_FEEDFORWARD_WEIGHTS]; ///< U_j, Q29
    int32_t  constant, scale;                ///< c_0, c_2; Q29
    uint32_t trust;                          ///< 1 - (1 - gamma) doubt, Q32
    int32_t  turned;                         ///< V_0 after the next reversal
    uint32_t kept;                           ///< part of the load that stays after it, Q32
    uint32_t fed_back;                       ///< 1: friction fed forward does harm, and is fed back
    uint32_t seal;                           ///< checksum of the members above
} tribo_feedforward_q31_weights_t;

/// A sample, which a tick posts for the learner.
typedef struct
{
    int32_t travelled, force, friction, noise, effort; ///< m, yf, z, n_y, LP(v)
    int32_t need;                                      ///< v + f - b at the last reversal
    uint8_t flips, turns, chatter; ///< numbers since the last sample: reversals, reversals while r moves, chatter
    uint8_t learns, moves, starts; ///< 1: r moves and y is good; f is fed forward; it is the first sample of a run
} tribo_feedforward_q31_sample_t;

/// The exchange between the tick and the learner; tribo_feedforward_f32_exchange_t explains it.
typedef struct
{
    volatile uint32_t                        owner; ///< tribo_feedforward_owner_t
    volatile tribo_feedforward_q31_sample_t  sample;
    volatile tribo_feedforward_q31_weights_t result;
} tribo_feedforward_q31_exchange_t;

/// Everything that a tick remembers for the next. Forces are Q29 of FS, slow means Q35, numbers Q29.
struct tribo_feedforward_q31_state
{
    tribo_force_loop_q31_tick_t     tick;          ///< what the loop reads
    uint8_t                         mode, rule;    ///< tribo_feedforward_mode_t, tribo_feedforward_offset_t
    uint8_t                         phase;         ///< ticks since the last sample
    int8_t                          sign, limited; ///< s, 0 before the first move; sign of the limit that holds u, or 0
    uint8_t                         flips, y_good; ///< in this tick: r reverses; y is credible
    uint8_t                         turned_since;  ///< r has reversed since the last sample was posted
    uint8_t                         flipped, turns, chatter, starts;      ///< counted for the next sample
    int32_t                         r[2], r_noise;                        ///< the last two good r; n_r
    int32_t                         reached, rate, turned;                ///< rs, its change in a tick, rp'
    int32_t                         stop[TRIBO_FEEDFORWARD_STOPS], sigma; ///< phi_j, sigma
    int32_t                         behind[2];                            ///< m_1 and m_2, minus rs
    int32_t                         load, own_load;  ///< the force that does not reverse, and the learned part of it
    int32_t                         lin, level;      ///< the force without friction; L times the guard's fade
    int32_t                         f, lead, b;      ///< u = limit(v + lin + f + lead - b)
    int32_t                         e, u, v;         ///< v is low-passed
    int32_t                         need, turn_need; ///< f - b of the last tick; v + f - b of the last reversal
    int32_t                         y[2], y_noise, y_now;            ///< the last two good y; n_y; y of this tick
    int32_t                         actuator, sensor, force;         ///< u_1, u_2, yf
    int32_t                         difference, friction, travelled; ///< zf, z, m
    int32_t                         error;                           ///< mean of e; in a hold the last step of r
    uint32_t                        offset_seal;                     ///< ~b, checked in the next tick
    uint32_t                        still, since;    ///< ticks since r last moved; ticks since `side` last changed
    int8_t                          side;            ///< sign of the breakaway that friction reached last
    uint8_t                         quick;           ///< quick changes of `side` in succession, up to 4
    uint8_t                         rests;           ///< the error is within the noise, and u does not change
    uint32_t                        late, forgotten; ///< late results; corrupt states; both stop at UINT32_MAX
    tribo_feedforward_q31_weights_t weights;
    tribo_feedforward_q31_exchange_t exchange;
    tribo_feedforward_learner_t      learner;
};

/// The work that your loop's output does over a slide. Motion and travel are Q29 of a width; forces are Q29 of FS.
typedef struct
{
    int32_t  moved, effort; ///< low passes of the motion in a tick, and of u without the model's load
    int32_t  slack;         ///< position of `moved` in a play one width wide
    int8_t   side;          ///< sign of the slide; 0 before the first slide
    uint32_t ticks;         ///< length of the slide; a slide of the maximal length does not count
    int64_t  travel, work, prior;
    float    last_travel;           ///< widths
    float    last_work, last_prior; ///< N
} tribo_feedforward_q31_effort_t;

/// The motion of an arm without a force sensor.
typedef struct
{
    int32_t                        slack[2];  ///< of the intended and the measured motion in plays one width wide
    int8_t                         sign;      ///< sign of the last motion; 0 before the first motion
    uint8_t                        is_known;  ///< the motion was passed for this tick
    uint8_t                        was_known; ///< the motion was passed for any tick, so that learned values are used
    int32_t                        measured;  ///< measured motion in this tick, Q29
    tribo_feedforward_q31_effort_t effort;
} tribo_feedforward_q31_motion_t;

/// Memory of a feed-forward. Set `&memory.state.tick` as the memory of a loop; a tribo_feedforward_q31_state_t is too
/// small.
struct tribo_feedforward_q31_memory
{
    tribo_feedforward_q31_state_t  state;
    tribo_feedforward_q31_motion_t motion;
};

/// Returns true while the learner has a sample. Meanwhile do not reset, restore or start without keep_learned, unless
/// your call is in the context that learns.
static inline bool tribo_feedforward_q31_is_learning(const tribo_feedforward_q31_state_t *state)
{
    return state->exchange.owner == TRIBO_FEEDFORWARD_OWNER_LEARNER;
}

/// Writes the functions of the feed-forward. The first member of its params holds the address of this function.
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
