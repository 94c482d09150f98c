/// Friction compensation by feed-forward, single precision: friction opposes the motion that the reference r asks for.
///
///     u = limit(v + lin + f + lead - b)          v = K(z) e          e = y expected - y
///
/// lin is the force that u would need without friction. f is a sum of stops that r drives; a learner finds their
/// weights, and a load, from y. The offset b removes from u what the controller wound up during stiction at a reversal.
/// When learning changes f and lin, b absorbs the change, so that learning never moves u. While r stands, and where
/// friction fed forward does harm, the method feeds friction back instead. docs/feedforward.md has the equations and
/// the reason for each constant.
///
/// Learning is not part of the tick. Every 10 ticks the tick posts a sample and takes the result of the previous
/// sample:
///
///     u = tribo_force_loop_f32_step(&params, &loop, r, y, NULL);
///     tribo_feedforward_f32_learn(&params, &memory); // at once, or in the background of the same core
///
/// If a result is not ready after 10 ticks, the tick takes it after 20, 30, ... and counts it as late. Late results
/// slow learning down and do no other harm.
///
/// A tick has at most three divisions, four when r moves on after a hold; a look-up in a breakaway table adds two. No
/// heap, no libm. One state, one tick, one learner.

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

/// The two directions of motion, numbered as the laws of friction_f32.h are.
#define TRIBO_BREAKAWAY_POSITIVE 0u
#define TRIBO_BREAKAWAY_NEGATIVE 1u

/// B is the breakaway at the usual force. If a member with "0: derived" is 0, the init computes it from breakaway,
/// poles and arm.
typedef struct
{
    float actuator_pole_rad_per_s; ///< p_a, 1e-3 to 1e6; times sample time 1e-9 to 50
    float sensor_pole_rad_per_s;   ///< p_s, with the ranges of p_a
    float reversal_n;   ///< w, width of a reversal of r; the error at a reversal is at least about w; 0: derived, B/314
    float presliding_n; ///< d, travel of F over which friction builds up; 0: derived, B/11
    float jump_time_s;  ///< T_j, duration of a reversal of f; less than a tick: f jumps; 0: derived, 2.1 tau
    float jump_lead;    ///< alpha, 0 to 1; part of the actuator's lag by which a jump of f leads
    float trust;        ///< gamma, 0 to 1; part of the configured friction that is used before anything is learned
    float forgetting_per_n; ///< Q; part of the prior variance that returns per newton of travel; 0: derived, 0.0157/B
    float still_time_s;     ///< T_q, 0 to 1e3; r counts as standing after this time without motion; 0: never
} tribo_feedforward_f32_config_t;

/// What was learned about one direction, for both arithmetics.
typedef struct
{
    float    L_n;               ///< breakaway at the requested force: V_0 L, and the friction that does not reverse
    float    relative_variance; ///< variance of L in this direction, divided by the prior variance
    float    travel_n; ///< travel learned from, in both directions; without a sensor widths of motion times reversal_n
    bool     at_bound; ///< V_0 is 0.2 or less, or at its limit of 3 times the configured value
    bool     stays_at_bound; ///< at four consecutive reversals; latched until a restore or a start
    bool     harms;          ///< feed-forward cost more effort than it saved, so friction is fed back; latched, too
    uint32_t late;           ///< number of samples whose result was late
    uint32_t forgotten;      ///< number of times that a corrupt memory was reset
} tribo_feedforward_learned_t;

/// Returns the default config, with the paper's poles.
tribo_feedforward_f32_config_t tribo_feedforward_f32_default(void);

/// Checks `config` field by field and computes `params`. The breakaway at `usual_force_n` sets all widths.
/// `input_max_n` limits which inputs are credible, and scales nothing. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_INPUT_MAX, TRIBO_ERR_USUAL_FORCE, or the status of a row of
/// TRIBO_FEEDFORWARD_PARAMETERS. Writes nothing unless TRIBO_OK. It leaves params.method empty, because a loop runs
/// only params that its own init has computed. Not for the tick.
tribo_status_t tribo_feedforward_f32_init(tribo_feedforward_f32_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_arm_f32_config_t         *arm,
                                          const tribo_friction_f32_params_t    *friction,
                                          float                                 input_max_n,
                                          float                                 usual_force_n,
                                          float                                 sample_time_s);

/// The derived jump_time_s, in multiples of tau.
#define TRIBO_FEEDFORWARD_JUMP_TIME 2.1f

/// Returns tau, the lag of actuator and arm in s, for a config and an arm that the init accepts.
static inline float tribo_feedforward_f32_lag_s(const tribo_feedforward_f32_config_t *config,
                                                const tribo_arm_f32_config_t         *arm)
{
    return 1.0f / config->actuator_pole_rad_per_s + arm->damping / arm->stiffness;
}

/// Forgets what was learned; the next good tick is the first one. A start without `keep_learned` does this, too.
void tribo_feedforward_f32_reset(tribo_feedforward_f32_state_t *state);

/// Learns from the last sample if the tick has posted one, and returns whether it had. Values that were learned with
/// params of another breakaway, gravity or presliding are forgotten first. Call it after the tick, or in
/// the background of the same core. From another core call it under a lock, or with your own barriers. A sample costs
/// about 2,000 floating-point operations, or 48,000 instructions without an FPU.
bool tribo_feedforward_f32_learn(const tribo_force_loop_f32_params_t *params, tribo_feedforward_f32_memory_t *memory);

/// Returns the learned breakaway in `direction` (TRIBO_BREAKAWAY_POSITIVE or _NEGATIVE) at the end-point force
/// `force_n`. `params` are those of a loop with or without a sensor; all members are 0 if they name no method. A bad
/// force counts as 0. Not for every tick.
tribo_feedforward_learned_t tribo_feedforward_f32_learned(const tribo_force_loop_f32_params_t *params,
                                                          const tribo_feedforward_f32_state_t *state,
                                                          uint32_t                             direction,
                                                          float                                force_n);

/// Clears the latched stays_at_bound and harms, and feeds friction forward again. Learned values stay.
void tribo_feedforward_f32_restore(tribo_feedforward_f32_state_t *state);

/// Names the feed-forward as the method in a loop's config. The loop's init computes `params` from `config` and returns
/// a status of tribo_feedforward_f32_init if it refuses them.
///
///     config.method = tribo_feedforward_f32_use(&feedforward, &feedforward_config);
///     status        = tribo_force_loop_f32_init(&params, &config);
///     loop.memory   = &memory.state.tick;
///     status        = tribo_force_loop_f32_start(&loop, &params, false);
tribo_loop_part_t tribo_feedforward_f32_use(tribo_feedforward_f32_params_t       *params,
                                            const tribo_feedforward_f32_config_t *config);

// --- without a force sensor -------------------------------------------------------------------------------------------
//
// For drives with only a current measurement and an encoder:
//
//     u = limit(lin + f + lead - b)          f = belief V L(rs) sigma
//
// This is a method of the force loop: steps 2 to 6 of the feed-forward without the stops, with the same params and
// memory. The method does not use y (pass 0), and removes the controller's output from u. b continues u after a change
// of params or of V, and fades with a time constant of 0.3 s. There is no feedback, so the default underestimates
// friction: 90 % of the breakaway you configured.
//
// r is the force that the arm shall apply, or the output of your position or velocity loop. In the second case, and
// wherever you know the motion better than r does, pass the motion by tribo_sensorless_f32_motion.
//
// V is 1 before the first such call. After it V is the weight V_0, which two slides teach, one in each direction:
// between two reversals the work of u goes into friction and load only. tribo_feedforward_f32_learned returns it.
//
// There is no guard, because the guard needs y. A corrupt memory is reset and counted. No loops; one division a tick,
// five at a reversal.

typedef struct
{
    float belief; ///< part of the configured breakaway that is fed forward, 0 to 1
} tribo_sensorless_f32_config_t;

/// Returns the default config, which underestimates friction on purpose.
tribo_sensorless_f32_config_t tribo_sensorless_f32_default(void);

/// Names the method without a force sensor in a loop's config. The method reads the actuator's pole, reversal_n,
/// jump_time_s and jump_lead of `config`. Its memory is a tribo_feedforward_f32_memory_t.
tribo_loop_part_t tribo_sensorless_f32_use(tribo_feedforward_f32_params_t       *params,
                                           const tribo_feedforward_f32_config_t *config,
                                           const tribo_sensorless_f32_config_t  *sensorless);

/// Call it before a tick with the arm's intended and measured motion in that tick. The unit is the width of a reversal:
/// the travel that is certainly a reversal and not noise. So pass the change of position divided by that travel, or the
/// speed times h divided by it, and 0 for no motion. Friction opposes the intended motion and, while that is 0, the
/// measured motion. In a tick without this call the sign of friction follows r. Friction never jumps when its source
/// changes.
///
/// The method learns friction while the measured motion slides back and forth by 16 widths or more and r is the output
/// of the loop that moves the arm, provided that the arm receives u. Pass 0 as the measured motion where a process
/// opposes the motion. A motion of more than 1000 widths in a tick counts as none.
void tribo_sensorless_f32_motion(tribo_feedforward_f32_memory_t *memory, float intended, float measured);

/// An estimate of F from u, without a force sensor.
typedef struct
{
    uint32_t runs;
    float    lagged; ///< u behind the lag of actuator and arm, N
    float    force;  ///< F^ of an arm that sticks within L, N
    float    low,
        high; ///< F^ with L times (1 - tolerance) to (1 + tolerance); F is between them, apart from the error of the lag
} tribo_force_estimate_f32_t;

/// Runs one tick of the estimate with the applied command `u_n`. `params` are those of a loop with or without a
/// sensor. At runs = 0 any F is possible. A tolerance or a force that is not credible changes nothing.
void tribo_force_estimate_f32_step(const tribo_force_loop_f32_params_t  *params,
                                   const tribo_feedforward_f32_params_t *feedforward,
                                   tribo_force_estimate_f32_t           *estimate,
                                   float                                 tolerance,
                                   float                                 u_n);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

#define TRIBO_FEEDFORWARD_STOPS   2u ///< in addition to sigma
#define TRIBO_FEEDFORWARD_WEIGHTS 3u ///< V_0 of sliding, V_1 and V_2 of the stops
#define TRIBO_FEEDFORWARD_LEARNED 5u ///< the weights, and the load c_0 + c_2 F

#define TRIBO_FEEDFORWARD_BOUND_TURNS 4u ///< consecutive reversals at a bound of V_0 that latch stays_at_bound

typedef enum
{
    TRIBO_FEEDFORWARD_RESTART = 0, ///< the next good tick is the first one; the controller is at rest
    TRIBO_FEEDFORWARD_ENTER,       ///< the next good tick is the first one; the controller runs, and u continues
    TRIBO_FEEDFORWARD_START,       ///< r has not moved since the start: friction has no direction
    TRIBO_FEEDFORWARD_MOVING,      ///< f follows r
    TRIBO_FEEDFORWARD_HOLD         ///< r stands, and friction is fed back
} tribo_feedforward_mode_t;

/// How a tick sets b.
typedef enum
{
    TRIBO_FEEDFORWARD_KEEP = 0,
    TRIBO_FEEDFORWARD_REVERSAL, ///< b = v, except for a part of the load
    TRIBO_FEEDFORWARD_CONTINUE, ///< so that u of the last tick continues
    TRIBO_FEEDFORWARD_TAKE_OVER ///< so that the term of the last tick continues
} tribo_feedforward_offset_t;

/// Constants of the learner in N, for both arithmetics.
typedef struct
{
    float    breakaway_n;                          ///< B
    float    reversal_n;                           ///< w
    float    per_n[TRIBO_FEEDFORWARD_WEIGHTS];     ///< 2/w and 1/d_j, for the stops that the measured force moves
    float    deviation[TRIBO_FEEDFORWARD_LEARNED]; ///< S, standard deviations of the prior
    float    jump_lag;                             ///< 1.5 T_j divided by the time between samples
    float    forgetting_per_n;                     ///< Q
    float    trust;                                ///< gamma
    float    unit_n;                               ///< newtons in one unit of the tick's forces; 1 in float32
    uint32_t rig; ///< checksum of the breakaway, gravity and presliding that learned values refer to
} tribo_feedforward_learning_t;

/// Constants of a tick, computed by tribo_feedforward_f32_init. Constant from then on; several loops may share them.
/// Forces are in N.
struct tribo_feedforward_f32_params
{
    tribo_force_loop_f32_method_t method; ///< a loop with the feed-forward points here
    float                         input_max;
    float                         offset_max;                         ///< limit of |b|
    float                         reversal;                           ///< w
    float                         stop_gain[TRIBO_FEEDFORWARD_STOPS]; ///< 1/d_j
    float                         jump; ///< largest change of sigma in a tick, 2 h/T_j up to 2
    float                         lead_gain, lag_gain, damping_gain; ///< alpha/(p_a h), tau/h, b_arm/(K h)
    float                         step;        ///< a sudden move of r by more is a step and has no rate
    float                         noise_floor; ///< w/500
    float                         noise_part, slow_part, fast_part; ///< of the low passes of noise; of e; of rate, v, y
    float                         lag_part, actuator_part, sensor_part; ///< of the low passes with tau, p_a, p_s
    float                         leak_part;                            ///< part by which b fades in 10 ticks
    float                         trust;                                ///< gamma
    uint32_t                      still_ticks, quick_ticks; ///< with 0 still_ticks r never counts as standing
    tribo_feedforward_learning_t  learning;
};

/// The learned values that the tick uses.
typedef struct
{
    float    sliding;                        ///< V_0
    float    use[TRIBO_FEEDFORWARD_WEIGHTS]; ///< U_j
    float    constant, scale;                ///< c_0, c_2
    float    trust;                          ///< 1 - (1 - gamma) doubt
    float    turned, kept;                   ///< after the next reversal: V_0, and the part of the load that stays
    uint32_t fed_back;                       ///< 1: friction fed forward does harm, and is fed back
    uint32_t seal;                           ///< checksum of the members above
} tribo_feedforward_f32_weights_t;

/// A sample, which a tick posts for the learner.
typedef struct
{
    float   travelled, force, friction, noise, effort; ///< m, yf, z, n_y, LP(v)
    float   need;                                      ///< v + f - b at the last reversal
    uint8_t flips, turns, chatter; ///< numbers since the last sample: reversals, reversals while r moves, chatter
    uint8_t learns, moves, starts; ///< 1: r moves and y is good; f is fed forward; it is the first sample of a run
} tribo_feedforward_f32_sample_t;

/// Which side may access the exchange between the tick and the learner.
typedef enum
{
    TRIBO_FEEDFORWARD_OWNER_TICK = 0, ///< the tick; there is no result
    TRIBO_FEEDFORWARD_OWNER_LEARNER,  ///< the learner; there is a sample
    TRIBO_FEEDFORWARD_OWNER_RESULT    ///< the tick; there is a result
} tribo_feedforward_owner_t;

/// The exchange between the tick and the learner. On one core an interrupt and its background need no more than the
/// order of accesses to volatile objects.
typedef struct
{
    volatile uint32_t                        owner; ///< tribo_feedforward_owner_t
    volatile tribo_feedforward_f32_sample_t  sample;
    volatile tribo_feedforward_f32_weights_t result;
} tribo_feedforward_f32_exchange_t;

/// The state of the learner, in float32 for both arithmetics.
typedef struct
{
    float    a[TRIBO_FEEDFORWARD_LEARNED]; ///< V_0 - 1, V_1, V_2, c_0, c_2, each divided by its standard deviation S
    float    P[15];                        ///< their covariance, the lower triangle by rows
    float    doubt;                        ///< 1 to 0
    float    travel_n;                     ///< travel that was learned from
    float    breakaway_n;                  ///< B of the params of the last sample, to which c_0 refers
    uint32_t rig;                          ///< of those params; all values refer to its numbers
    uint32_t seal;                         ///< checksum of the members above

    float stop[TRIBO_FEEDFORWARD_WEIGHTS]; ///< X_j/d_j, -1 to 1
    float travelled_n, friction_n;         ///< m and z of the last sample
    float surplus;                         ///< l, the learned load divided by L
    float played_n, effort_n, need_n; ///< of the monitor: vbar behind a play, its travel t_v, need of the last reversal
    float ratio;                      ///< xi, 0 to 4
    uint8_t begun;                    ///< r has moved since the start
    uint8_t harms;                    ///< latched
    uint8_t left,
        length; ///< reversals that will be fed back; length of the last feedback, less the reversals fed forward since
    uint8_t  at_bound;  ///< consecutive reversals with V_0 at a bound; 4 stays until a restore
    uint8_t  judged;    ///< reversals of which xi is a mean; stops at 255
    uint32_t forgotten; ///< number of times that a corrupt memory was reset
} tribo_feedforward_learner_t;

/// Everything that a tick remembers for the next. Forces are in N.
struct tribo_feedforward_f32_state
{
    tribo_force_loop_f32_tick_t     tick;          ///< what the loop reads
    uint8_t                         mode, rule;    ///< tribo_feedforward_mode_t, tribo_feedforward_offset_t
    uint8_t                         phase;         ///< ticks since the last sample
    int8_t                          sign, limited; ///< s, 0 before the first move; sign of the limit that holds u, or 0
    uint8_t                         flips, y_good; ///< in this tick: r reverses; y is credible
    uint8_t                         turned_since;  ///< r has reversed since the last sample was posted
    uint8_t                         flipped, turns, chatter, starts;      ///< counted for the next sample
    float                           r[2], r_noise;                        ///< the last two good r; n_r
    float                           reached, rate, turned;                ///< rs, its change in a tick, rp'
    float                           stop[TRIBO_FEEDFORWARD_STOPS], sigma; ///< phi_j, sigma
    float                           behind[2];                            ///< m_1 and m_2, minus rs
    float                           load, own_load;  ///< the force that does not reverse, and the learned part of it
    float                           lin, level;      ///< the force without friction; L times the guard's fade
    float                           f, lead, b;      ///< u = limit(v + lin + f + lead - b)
    float                           e, u, v;         ///< v is low-passed
    float                           need, turn_need; ///< f - b of the last tick; v + f - b of the last reversal
    float                           y[2], y_noise, y_now;            ///< the last two good y; n_y; y of this tick
    float                           actuator, sensor, force;         ///< u_1, u_2, yf
    float                           difference, friction, travelled; ///< zf, z, m
    float                           error;                           ///< mean of e; in a hold the last step of r
    uint32_t                        offset_seal;                     ///< ~b, checked in the next tick
    uint32_t                        still, since;    ///< ticks since r last moved; ticks since `side` last changed
    int8_t                          side;            ///< sign of the breakaway that friction reached last
    uint8_t                         quick;           ///< quick changes of `side` in succession, up to 4
    uint8_t                         rests;           ///< the error is within the noise, and u does not change
    uint32_t                        late, forgotten; ///< late results; corrupt states; both stop at UINT32_MAX
    tribo_feedforward_f32_weights_t weights;
    tribo_feedforward_f32_exchange_t exchange;
    tribo_feedforward_learner_t      learner;
};

/// The work that your loop's output does over a slide. Travel is in widths of a reversal.
typedef struct
{
    float    moved, effort;         ///< low passes of the motion in a tick, and of u without the model's load
    float    slack;                 ///< position of `moved` in a play one width wide
    int8_t   side;                  ///< sign of the slide; 0 before the first slide
    uint32_t ticks;                 ///< length of the slide; a slide of the maximal length does not count
    float    travel, work, prior;   ///< X, W, G
    float    last_travel;           ///< X' of the last slide that counted, with its sign
    float    last_work, last_prior; ///< a' and l', per width
} tribo_feedforward_f32_effort_t;

/// The motion of an arm without a force sensor.
typedef struct
{
    float                          slack[2];  ///< of the intended and the measured motion in plays one width wide
    int8_t                         sign;      ///< sign of the last motion; 0 before the first motion
    uint8_t                        is_known;  ///< the motion was passed for this tick
    uint8_t                        was_known; ///< the motion was passed for any tick, so that learned values are used
    float                          measured;  ///< measured motion in this tick, widths
    tribo_feedforward_f32_effort_t effort;
} tribo_feedforward_f32_motion_t;

/// Memory of a feed-forward. Set `&memory.state.tick` as the memory of a loop; a tribo_feedforward_f32_state_t is too
/// small.
struct tribo_feedforward_f32_memory
{
    tribo_feedforward_f32_state_t  state;
    tribo_feedforward_f32_motion_t motion;
};

/// Returns true while the learner has a sample. Meanwhile do not reset, restore or start without keep_learned,
/// unless your call is in the context that learns.
static inline bool tribo_feedforward_f32_is_learning(const tribo_feedforward_f32_state_t *state)
{
    return state->exchange.owner == TRIBO_FEEDFORWARD_OWNER_LEARNER;
}

/// Writes the functions of the feed-forward. The first member of its params holds the address of this function.
void tribo_feedforward_f32_method(tribo_force_loop_f32_functions_t *functions);

/// Returns the params of the feed-forward that a loop runs; null if the loop runs another method.
static inline const tribo_feedforward_f32_params_t *tribo_feedforward_f32_of(
    const tribo_force_loop_f32_params_t *params)
{
    const bool is_one = params->method != NULL && params->method->functions == tribo_feedforward_f32_method;
    return is_one ? (const tribo_feedforward_f32_params_t *)params->method : NULL; // its first member
}

/// Writes the functions of the method without a force sensor.
void tribo_sensorless_f32_method(tribo_force_loop_f32_functions_t *functions);

#ifdef __cplusplus
}
#endif

#endif
