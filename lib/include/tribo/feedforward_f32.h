/// Friction compensation by feed-forward, single precision: friction opposes the motion that the reference r asks for.
///
///     u = limit(v + lin + f + lead - b)          v = K(z) e          e = y expected - y
///
/// lin is the force without friction. f is a sum of stops that r drives; a learner finds their weights, and a load, from y. The
/// offset b takes what the controller wound up during stiction at a reversal, and what f and lin change by as they are learned:
/// learning never moves u. While r stands, or where friction fed forward does harm, friction is fed back instead.
/// docs/feedforward.md has the equations and the reason of each constant.
///
/// Learning is no part of the tick. Every 10 ticks the tick posts a sample, and takes the result of the last one:
///
///     u = tribo_force_loop_f32_step(&params, &loop, r, y, NULL);
///     tribo_feedforward_f32_learn(&params, &memory); // at once, or in the background of the same core
///
/// A result that is not ready after 10 ticks is taken after 20, 30, ..., and counted as late. That costs time to learn, nothing else.
///
/// A tick has at most three divisions, a look-up in a table two more. No heap, no libm. One state, one tick, one learner.

#ifndef TRIBO_FEEDFORWARD_F32_H
#define TRIBO_FEEDFORWARD_F32_H

#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_feedforward_f32_params tribo_feedforward_f32_params_t;
typedef struct tribo_feedforward_f32_state  tribo_feedforward_f32_state_t;
typedef struct tribo_feedforward_f32_memory tribo_feedforward_f32_memory_t;

/// Directions, as in the laws of friction_f32.h.
#define TRIBO_BREAKAWAY_POSITIVE 0u
#define TRIBO_BREAKAWAY_NEGATIVE 1u

/// 0 where "derived" is said: computed by the init from breakaway, poles and arm. B is the breakaway at the usual force.
typedef struct
{
    float actuator_pole_rad_per_s; ///< p_a, 1e-3 to 1e6; times sample time 1e-9 to 50
    float sensor_pole_rad_per_s;   ///< p_s, as p_a
    float reversal_n;       ///< w, width of a reversal of r; the error at one is at least about w; 0: derived, B/314
    float presliding_n;     ///< d, travel of F over which friction builds up; 0: derived, B/11
    float jump_time_s;      ///< T_j, of a reversal of f; shorter than a tick: at once; 0: derived, 2.1 tau
    float jump_lead;        ///< alpha, 0 to 1; part of the actuator's lag that a jump of f leads by
    float trust;            ///< gamma, 0 to 1; part of the prior that is used before anything is learned
    float forgetting_per_n; ///< Q; part of the prior variance that returns per newton; 0: derived, 0.0157/B
    float still_time_s;     ///< T_q, 0 to 1e3; r stands after this time without motion; 0: never
} tribo_feedforward_f32_config_t;

/// Learned breakaway in one direction, of both arithmetics.
typedef struct
{
    float L_n;               ///< at some force: V_0 L, and what does not reverse
    float relative_variance; ///< of L in this direction, over the prior's
    float travel_n;          ///< learned from, both ways; without a sensor widths of motion times reversal_n
    bool  at_bound;          ///< learning has hit its limit, 0.2 or 3 times the configured value
    bool  stays_at_bound;    ///< four consecutive reversals found it so; latched until restore or a start anew
    bool
        harms; ///< friction fed forward cost more effort than it saved, and was fed back; latched until restore or a start anew
    uint32_t late;      ///< samples whose result was late
    uint32_t forgotten; ///< times that a corrupt memory was reset
} tribo_feedforward_learned_t;

/// Defaults, for the paper's poles.
tribo_feedforward_f32_config_t tribo_feedforward_f32_default(void);

/// Checks `config` field by field and computes `params`. Breakaway at `usual_force_n` sets all widths; `input_max_n` bounds what is
/// credible, and scales nothing else. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_INPUT_MAX,
/// TRIBO_ERR_USUAL_FORCE, or the status of a row of TRIBO_FEEDFORWARD_PARAMETERS. Writes nothing unless TRIBO_OK. It leaves
/// params.method empty: a loop runs only params that its own init has made. Not for the tick.
tribo_status_t tribo_feedforward_f32_init(tribo_feedforward_f32_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_arm_f32_config_t         *arm,
                                          const tribo_friction_f32_params_t    *friction,
                                          float                                 input_max_n,
                                          float                                 usual_force_n,
                                          float                                 sample_time_s);

/// T_j of tau, where jump_time_s is derived.
#define TRIBO_FEEDFORWARD_JUMP_TIME 2.1f

/// tau, s: the lag of actuator and arm. Of a config and an arm that the init takes.
static inline float tribo_feedforward_f32_lag_s(const tribo_feedforward_f32_config_t *config,
                                                const tribo_arm_f32_config_t         *arm)
{
    return 1.0f / config->actuator_pole_rad_per_s + arm->damping / arm->stiffness;
}

/// Forgets what was learned; the next good tick is the first. A start without `keep_learned` does it, too.
void tribo_feedforward_f32_reset(tribo_feedforward_f32_state_t *state);

/// Learns from the last sample, if the tick has posted one. True if it had. In the tick's own call, or in the background of the same core;
/// from another core call it under a lock, or with barriers of your own. Some 2,000 floating-point operations every 10 ticks; without an
/// FPU some 48,000 instructions.
bool tribo_feedforward_f32_learn(const tribo_force_loop_f32_params_t *params, tribo_feedforward_f32_memory_t *memory);

/// Learned breakaway in `direction` (TRIBO_BREAKAWAY_POSITIVE or _NEGATIVE) at the end-point force `force_n`, with the `params` of a loop
/// with or without a sensor; all 0 with params that name no method. A bad force counts as 0. Not for every tick.
tribo_feedforward_learned_t tribo_feedforward_f32_learned(const tribo_force_loop_f32_params_t *params,
                                                          const tribo_feedforward_f32_state_t *state,
                                                          uint32_t                             direction,
                                                          float                                force_n);

/// Unlatches stays_at_bound and harms, and feeds friction forward; learned values stay.
void tribo_feedforward_f32_restore(tribo_feedforward_f32_state_t *state);

/// The feed-forward as the method of a loop's config: the loop's init makes `params` of `config`, with a status of
/// tribo_feedforward_f32_init.
///
///     config.method = tribo_feedforward_f32_use(&feedforward, &feedforward_config);
///     status        = tribo_force_loop_f32_init(&params, &config);
///     loop.memory   = &memory.state.tick;
///     status        = tribo_force_loop_f32_start(&loop, &params, false);
tribo_loop_part_t tribo_feedforward_f32_use(tribo_feedforward_f32_params_t       *params,
                                            const tribo_feedforward_f32_config_t *config);

// --- without a force sensor -------------------------------------------------------------------------------------------
//
// For drives with current and encoder only:
//
//     u = limit(lin + f + lead - b)          f = belief V L(rs) sigma
//
// A method of the force loop: steps 2 to 6 with the stops left out, with the params and memory of the feed-forward. y is not used (give 0), and the
// controller's output is taken out of u. b is 0, or what u goes on from after a change of params or of V, and fades with 0.3 s. It has no feedback: u is as right as V L is, so it believes low.
//
// r is the force that the arm shall have, or the effort of somebody else's position or velocity loop. With that, and wherever the
// motion is known better than by r, tell it: tribo_sensorless_f32_motion.
//
// V is 1 until then. From then on it is the weight V_0 that two slides teach, one in each direction: from one reversal to the next
// u does the work of friction and load, and of nothing else. tribo_feedforward_f32_learned shows it.
//
// No guard: it judges y. A corrupt memory is forgotten whole and counted. No loops, one division a tick, five at a reversal.

typedef struct
{
    float belief; ///< part of the believed breakaway that is fed forward, 0 to 1
} tribo_sensorless_f32_config_t;

/// The default: believes low.
tribo_sensorless_f32_config_t tribo_sensorless_f32_default(void);

/// As tribo_feedforward_f32_use, for a loop without a sensor; of `config` it uses the actuator's pole, reversal_n, jump_time_s and
/// jump_lead. The memory is the feed-forward's.
tribo_loop_part_t tribo_sensorless_f32_use(tribo_feedforward_f32_params_t       *params,
                                           const tribo_feedforward_f32_config_t *config,
                                           const tribo_sensorless_f32_config_t  *sensorless);

/// Before a tick: the motion of the arm in it, intended and measured, each in widths of a reversal, e.g. a change of position over
/// the travel that is surely a reversal and no noise, or a speed times h over that. 0 where there is none. Friction opposes the
/// intended motion; while that is at rest, the measured. In a tick without this call, r decides. Friction never jumps between them.
///
/// Friction is learned where the measured motion slides to and fro by 16 widths or more and r is the effort of the loop that moves it, so
/// far as u is what the arm gets. Give 0 for it where a process opposes the motion. A tick of more than 1000 widths is taken for none.
void tribo_sensorless_f32_motion(tribo_feedforward_f32_memory_t *memory, float intended, float measured);

/// Of F, from u alone.
typedef struct
{
    uint32_t runs;
    float    lagged; ///< u behind the lag of actuator and arm, N
    float    force;  ///< F^: an arm that sticks within L, N
    float low, high; ///< the same with L times (1 - tolerance) to (1 + tolerance): F is between, beside the lag's error
} tribo_force_estimate_f32_t;

/// One tick with `u_n` as applied, by the params of a loop with or without a sensor. From runs = 0 any F is possible. A tolerance
/// or a force that is not credible changes nothing.
void tribo_force_estimate_f32_step(const tribo_force_loop_f32_params_t  *params,
                                   const tribo_feedforward_f32_params_t *feedforward,
                                   tribo_force_estimate_f32_t           *estimate,
                                   float                                 tolerance,
                                   float                                 u_n);

// --- what they hold: give it room; write only what a comment says ------------------------------------------------------

#define TRIBO_FEEDFORWARD_STOPS   2u ///< beside sigma
#define TRIBO_FEEDFORWARD_WEIGHTS 3u ///< V_0 of sliding, V_1 and V_2 of the stops
#define TRIBO_FEEDFORWARD_LEARNED 5u ///< and the load, c_0 and c_2 F

#define TRIBO_FEEDFORWARD_BOUND_TURNS 4u ///< consecutive reversals at a bound of V_0 until it stays

typedef enum
{
    TRIBO_FEEDFORWARD_RESTART = 0, ///< the next good tick is the first, beside a controller at rest
    TRIBO_FEEDFORWARD_ENTER,       ///< the next good tick is the first, beside a running controller: u goes on
    TRIBO_FEEDFORWARD_START,       ///< r has not moved yet: no direction, nothing learned
    TRIBO_FEEDFORWARD_MOVING,      ///< f follows r
    TRIBO_FEEDFORWARD_HOLD         ///< r stands: friction is fed back
} tribo_feedforward_mode_t;

/// How b gets its value in a tick.
typedef enum
{
    TRIBO_FEEDFORWARD_KEEP = 0,
    TRIBO_FEEDFORWARD_REVERSAL, ///< b = v, but for a part of the load
    TRIBO_FEEDFORWARD_CONTINUE, ///< u of the last tick goes on
    TRIBO_FEEDFORWARD_TAKE_OVER ///< the term of the last tick goes on
} tribo_feedforward_offset_t;

/// Constants of the learner, in N, for both arithmetics.
typedef struct
{
    float breakaway_n;                          ///< B
    float reversal_n;                           ///< w
    float per_n[TRIBO_FEEDFORWARD_WEIGHTS];     ///< 2/w, 1/d_j: widths of the stops that the measured force moves
    float deviation[TRIBO_FEEDFORWARD_LEARNED]; ///< S, standard deviations of the prior
    float jump_lag;                             ///< 1.5 T_j over the time of a sample
    float forgetting_per_n;                     ///< Q
    float trust;                                ///< gamma
    float unit_n;                               ///< newtons of a unit of the tick's forces; 1 in float32
} tribo_feedforward_learning_t;

/// Constants of a tick, made by tribo_feedforward_f32_init. Const from then on; may be shared. Forces are in N.
struct tribo_feedforward_f32_params
{
    tribo_force_loop_f32_method_t method; ///< for a loop with the feed-forward
    float                         input_max;
    float                         offset_max;                           ///< of |b|
    float                         reversal;                             ///< w
    float                         stop_gain[TRIBO_FEEDFORWARD_STOPS];   ///< 1/d_j
    float                         jump;                                 ///< of sigma a tick, 2 h/T_j up to 2
    float                         lead_gain, lag_gain, damping_gain;    ///< alpha/(p_a h), tau/h, b_arm/(K h)
    float                         step;                                 ///< a move of r that has no rate
    float                         noise_floor;                          ///< w/500
    float                         noise_part, slow_part, fast_part;     ///< of low passes: of noise, e; of rate, v, y
    float                         lag_part, actuator_part, sensor_part; ///< of tau, p_a, p_s
    float                         leak_part;                            ///< of b, in 10 ticks
    float                         trust;                                ///< of the prior, before anything is learned
    uint32_t                      still_ticks, quick_ticks;             ///< 0 still_ticks: r never stands
    tribo_feedforward_learning_t  learning;
};

/// What the tick uses of what is learned.
typedef struct
{
    float    sliding;                        ///< V_0
    float    use[TRIBO_FEEDFORWARD_WEIGHTS]; ///< U_j
    float    constant, scale;                ///< c_0, c_2
    float    trust;                          ///< 1 - (1 - gamma) doubt
    float    turned, kept; ///< where r reverses: V_0 from then on, and the part of the load that stays
    uint32_t fed_back;     ///< 1: friction fed forward does harm
    uint32_t seal;         ///< of these numbers: one that does not fit is corrupt
} tribo_feedforward_f32_weights_t;

/// What a tick posts for the learner.
typedef struct
{
    float   travelled, force, friction, noise, effort; ///< m, yf, z, n_y, LP(v)
    float   need;                                      ///< v + f - b at the last reversal
    uint8_t flips, turns, chatter; ///< since the last sample: reversals, those where r did not stand, chatter
    uint8_t learns, moves, starts; ///< 1: r moves and y is good; f is fed forward; first sample of a run
} tribo_feedforward_f32_sample_t;

/// Who may touch what stands between the tick and the learner.
typedef enum
{
    TRIBO_FEEDFORWARD_OWNER_TICK = 0, ///< the tick, and there is no result
    TRIBO_FEEDFORWARD_OWNER_LEARNER,  ///< the learner, with a sample
    TRIBO_FEEDFORWARD_OWNER_RESULT    ///< the tick, with a result
} tribo_feedforward_owner_t;

/// Between the tick and the learner. On one core the order of accesses to volatile objects is all that an interrupt and its background need.
typedef struct
{
    volatile uint32_t                        owner; ///< tribo_feedforward_owner_t
    volatile tribo_feedforward_f32_sample_t  sample;
    volatile tribo_feedforward_f32_weights_t result;
} tribo_feedforward_f32_exchange_t;

/// What is learned, in float32 for both arithmetics.
typedef struct
{
    float    a[TRIBO_FEEDFORWARD_LEARNED]; ///< V_0 - 1, V_1, V_2, c_0, c_2, each over its deviation
    float    P[15];                        ///< their covariance, the lower triangle by rows
    float    doubt;                        ///< 1 to 0
    float    travel_n;                     ///< learned from
    uint32_t seal;                         ///< of these numbers: one that does not fit is corrupt

    float    stop[TRIBO_FEEDFORWARD_WEIGHTS]; ///< X_j/d_j, -1 to 1
    float    travelled_n, friction_n;         ///< m and z of the last sample
    float    surplus;                         ///< l, the learned load over L
    float    played_n, effort_n, need_n; ///< monitor: vbar behind a play, its travel t_v, need of the last reversal
    float    ratio;                      ///< xi, 0 to 4
    uint8_t  begun;                      ///< r has moved since the start
    uint8_t  harms;                      ///< latched
    uint8_t  left, length; ///< reversals to be fed back; of the last feedback, less those fed forward since
    uint8_t  at_bound;     ///< consecutive reversals with V_0 at a bound; 4 stays until restored
    uint32_t forgotten;    ///< times that a corrupt memory was reset
} tribo_feedforward_learner_t;

/// All that a tick leaves to the next. Forces are in N.
struct tribo_feedforward_f32_state
{
    tribo_force_loop_f32_tick_t      tick;          ///< what the loop reads
    uint8_t                          mode, rule;    ///< tribo_feedforward_mode_t, tribo_feedforward_offset_t
    uint8_t                          phase;         ///< ticks since the last sample
    int8_t                           sign, limited; ///< s, 0 before the first move; sign of the limit that u met
    uint8_t                          flips, y_good; ///< in this tick: r reverses; y is credible
    uint8_t                          turned_since;  ///< since the last sample was posted
    uint8_t                          flipped, turns, chatter, starts;      ///< for the next sample
    float                            r[2], r_noise;                        ///< the last good r, and the one before; n_r
    float                            reached, rate, turned;                ///< rs, its change in a tick, rp'
    float                            stop[TRIBO_FEEDFORWARD_STOPS], sigma; ///< phi_j, sigma
    float                            behind[2];                            ///< m_1 and m_2 less rs
    float                            load, own_load;  ///< what does not reverse, and the part of it that is learned
    float                            lin, level;      ///< force without friction; share L
    float                            f, lead, b;      ///< u = limit(v + lin + f + lead - b)
    float                            e, u, v;         ///< v: low pass
    float                            need, turn_need; ///< f - b of the last tick; with v, of the last reversal
    float                            y[2], y_noise, y_now; ///< the last good y, and the one before; n_y; y of this tick
    float                            actuator, sensor, force;         ///< u_1, u_2, yf
    float                            difference, friction, travelled; ///< zf, z, m
    float                            error;                           ///< mean of e, in a hold a step of r
    uint32_t                         offset_seal;                     ///< ~b, from a tick to the next
    uint32_t                         still, since;    ///< ticks of standing; ticks since the last change of side
    int8_t                           side;            ///< of breakaway that friction reached last
    uint8_t                          quick;           ///< changes of side in quick succession, up to 4
    uint8_t                          rests;           ///< the error is within the noise, and u stays
    uint32_t                         late, forgotten; ///< late results; corrupt states; both stop at UINT32_MAX
    tribo_feedforward_f32_weights_t  weights;
    tribo_feedforward_f32_exchange_t exchange;
    tribo_feedforward_learner_t      learner;
};

/// The work of another loop's effort over a slide. Travel is in widths of a reversal.
typedef struct
{
    float    moved, effort;         ///< motion of a tick, and u without the model's load; low passes
    float    slack;                 ///< of moved, in a play a width wide
    int8_t   side;                  ///< sign of the slide, 0: none yet
    uint32_t ticks;                 ///< of the slide; at its most, the slide does not count
    float    travel, work, prior;   ///< X, W, G
    float    last_travel;           ///< X', of the last slide that counted, with its sign
    float    last_work, last_prior; ///< a', l', a width
} tribo_feedforward_f32_effort_t;

/// Of a loop without a sensor.
typedef struct
{
    float                          slack[2];  ///< of a play a width wide, intended and measured
    int8_t                         sign;      ///< of the last motion, 0: none yet
    uint8_t                        is_known;  ///< in this tick
    uint8_t                        was_known; ///< in any tick: what is learned is used
    float                          measured;  ///< in this tick, widths
    tribo_feedforward_f32_effort_t effort;
} tribo_feedforward_f32_motion_t;

/// Memory of a feed-forward: `&memory.state.tick` is the memory of a loop, and a state alone is too small.
struct tribo_feedforward_f32_memory
{
    tribo_feedforward_f32_state_t  state;
    tribo_feedforward_f32_motion_t motion;
};

/// True while the learner has a sample: then leave reset, restore and a start without keep_learned alone unless the caller is the one who learns.
static inline bool tribo_feedforward_f32_is_learning(const tribo_feedforward_f32_state_t *state)
{
    return state->exchange.owner == TRIBO_FEEDFORWARD_OWNER_LEARNER;
}

/// Writes the functions of the feed-forward as a method of the force loop, for the first member of its params.
void tribo_feedforward_f32_method(tribo_force_loop_f32_functions_t *functions);

/// The feed-forward's params of a loop; null for another method.
static inline const tribo_feedforward_f32_params_t *tribo_feedforward_f32_of(
    const tribo_force_loop_f32_params_t *params)
{
    const bool is_one = params->method != NULL && params->method->functions == tribo_feedforward_f32_method;
    return is_one ? (const tribo_feedforward_f32_params_t *)params->method : NULL; // its first member
}

/// Writes the functions of the feed-forward without a force sensor, likewise.
void tribo_sensorless_f32_method(tribo_force_loop_f32_functions_t *functions);

#ifdef __cplusplus
}
#endif

#endif
