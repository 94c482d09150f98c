/// The friction-compensated force loop of Fig. 9, single precision: one call a tick.
///
///     y --> e = r - y --> controller --> (+ gain f^ of the last tick) --> limit --> u
///                              ^                                            |
///                              '------ anti-windup ------------------------+--> compensator --> f^
///
/// Forces are in N. The command u is scaled so that u = F at rest without friction. "Newton" stands for the unit in
/// which the plant was identified, for example N m.
///
/// A tick cannot fail: for any r and y, u is finite and within u_min_n to u_max_n. If r or y is bad (NaN, infinite, or
/// beyond input_max_n), the loop counts the tick and runs it with e = 0: u keeps the controller's state, and with a
/// feed-forward it follows a good r open loop. The loop resumes with the next good input, but it never stops by itself:
/// your drive must stop after some bad inputs in succession (the examples: 20).
///
/// Retune while running: pass a pointer to other validated params at any tick. The first tick with new params takes the
/// state over without a jump of u, even if the cascade, the gain, the friction and the arm differ. New limits apply at
/// once. That tick reads the old params once more and costs about three ticks. Free the old params when state.active is
/// the new pointer. Do not write to params in use, nor to a breakaway table that they point to. All params of a loop
/// have one sample time.
///
/// The loop compensates friction by the paper's method (gain 0 turns it off), or by the method that the config names
/// (feedforward_f32.h). A guard can watch the loop for over-compensation. Unused methods and guards are not linked. New
/// params may name another method; u does not jump.
///
/// A flipped bit in RAM: the loop does not follow a corrupt pointer of the state, and counts the tick in `bad_inputs`.
/// While `active` is corrupt, the loop ignores a change of params. While `memory` is corrupt, the controller runs
/// without a method until the next start. The loop trusts its params: they hold factors, pointers to the params of
/// parts, and pointers to code (the functions of `method` and of the guard). No tick checks them, so keep params in
/// flash, in RAM with ECC, or under a checksum of your own.
///
/// A third and a fourth section, a breakaway table and a change of params each add to the cost of a tick;
/// tests/bench/numbers_md.py prints the figures. No heap, no libm, no globals, no double in a tick. Every target
/// computes the same bits. Not synchronized: one state, one tick.

#ifndef TRIBO_FORCE_LOOP_F32_H
#define TRIBO_FORCE_LOOP_F32_H

#include "tribo/controller_f32.h"
#include "tribo/friction_f32.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_force_loop_f32_config tribo_force_loop_f32_config_t;
typedef struct tribo_force_loop_f32_params tribo_force_loop_f32_params_t;
struct tribo_force_loop_q31_params;
typedef struct tribo_guard_f32_state      tribo_guard_f32_state_t;
typedef struct tribo_guard_f32_params     tribo_guard_f32_params_t;
typedef struct tribo_force_loop_f32_state tribo_force_loop_f32_state_t;

/// A method or a guard that a config names. tribo_feedforward_f32_use, tribo_sensorless_f32_use, tribo_guard_f32_use
/// and their Q31 counterparts return one. Only a call of such a function links the method. A struct of zeros names no
/// method.
typedef struct tribo_loop_part
{
    /// Computes `params` from `config` while the loop's init runs. In float32 `full_scale_n` is 1.
    tribo_status_t (*make_f32)(const struct tribo_loop_part        *part,
                               const tribo_force_loop_f32_config_t *loop,
                               float                                full_scale_n,
                               tribo_force_loop_f32_params_t       *made);
    tribo_status_t (*make_q31)(const struct tribo_loop_part        *part,
                               const tribo_force_loop_f32_config_t *loop,
                               float                                full_scale_n,
                               struct tribo_force_loop_q31_params  *made);
    const void *config;
    const void *sensorless; ///< a second config, for the method without a force sensor
    void       *params;
} tribo_loop_part_t;

typedef struct
{
    tribo_loop_part_t part;
} tribo_loop_guard_t;

/// A PI by gains, v = kp e + ki (integral of e).
typedef struct
{
    float kp;       ///< 1e-6 to 1e5
    float ki_per_s; ///< 0 to 1e5, times the sample time at most 2 kp
} tribo_pi_t;

/// The config of a loop in either arithmetic. The controller is either `pi` or the sections of `controller`:
/// `tribo_paper_controller_f32`, or your design. If you run your own controller between the two halves of a tick, set
/// kp = 1: the config must name a controller, but the halves do not run it.
struct tribo_force_loop_f32_config
{
    float sample_time_s; ///< time between two ticks, 1e-6 to 0.1 s
    float input_max_n;   ///< largest credible |r| and |y|, 1e-6 to 1e6 N
    float gain;          ///< eta, 0 to 2; 0 turns the compensation off, 1 overcompensates
    float usual_force_n; ///< |F| around which the rig usually works, 0 to 1e6 N; 0: tribo_force_loop_f32_usual_force_n
    /// The limits of u, and sections designed for this sample time; no sections with `pi`.
    tribo_controller_f32_config_t  controller;
    tribo_pi_t                     pi; ///< kp = ki = 0: the sections are the controller
    tribo_compensator_f32_config_t compensator;
    tribo_loop_part_t  method; ///< `config.method = tribo_feedforward_f32_use(...)`; zeros: the paper's method
    tribo_loop_guard_t guard;  ///< `config.guard = tribo_guard_f32_use(...)`; zeros: no guard
};

/// Signals of one tick, for logging.
typedef struct
{
    float                           e_n;             ///< the controller's error; r - y with the paper's method
    float                           friction_term_n; ///< added to v; with the paper's method gain f^[k-1]
    tribo_controller_f32_signals_t  controller;      ///< controller term v, u, limited
    tribo_compensator_f32_signals_t compensator;     ///< F^, n, L, v, f^, Q1, Q2, Q
} tribo_force_loop_f32_signals_t;

typedef enum
{
    TRIBO_GUARD_NONE = 0, ///< no fading
    TRIBO_GUARD_HUNTING,  ///< friction reversed quickly and drove y against r
    TRIBO_GUARD_OVERSHOOT ///< F repeatedly broke away with an error of the wrong sign
} tribo_guard_cause_t;

typedef struct
{
    float turn_n;       ///< f has reversed once it has come back by this much; 1e-9 to 1e6 N, about L/3
    float quick_time_s; ///< reversals closer together than this may be hunting; 1e-6 to 1e3 s and up to 1e5 samples
    float stray_n;     ///< least excess that counts as overshoot; 1e-9 to 1e6 N, about L/15, over twice the noise peaks
    float fade_time_s; ///< friction fades out in this time; 1e-6 to 1e3 s and up to 1e6 samples
} tribo_guard_f32_config_t;

/// Returns the config of the paper's loop: 1 ms, gain 0.85, friction and arm of Eqs. (7), (9), (10) with displacement
/// in degrees, the H-infinity controller of Eqs. (13), (14), u within +-2 N, |r| and |y| up to 2 N. The controller is
/// valid only at 1 ms: another sample_time_s needs its own sections.
tribo_force_loop_f32_config_t tribo_force_loop_f32_paper(void);

/// Returns the beginning of a config for your own rig. Everything that depends on the rig is 0, and the init refuses it
/// until you set it: sample_time_s, input_max_n, the controller and its limits, breakaway in both directions (offset_n
/// and slope), and the arm. The gain and the shape of friction are those of the paper's loop; only the paper's method
/// reads them. Its v0_n_per_s is a rate of 4.5 % of the breakaway per second.
tribo_force_loop_f32_config_t tribo_force_loop_f32_rig(void);

/// Returns the force around which the rig usually works: usual_force_n, or a quarter of the larger |limit| of u if
/// usual_force_n is 0.
static inline float tribo_force_loop_f32_usual_force_n(const tribo_force_loop_f32_config_t *config)
{
    const float up   = config->controller.u_max_n;
    const float down = -config->controller.u_min_n;
    return config->usual_force_n > 0.0f ? config->usual_force_n : 0.25f * (up > down ? up : down);
}

/// Returns the section of a PI, integrated by the bilinear rule, for a drive that stores sections. Checks nothing.
tribo_biquad_f32_section_t tribo_pi_f32_section(const tribo_pi_t *pi, float sample_time_s);

/// Checks `config` field by field and computes `params`. Returns TRIBO_OK, TRIBO_ERR_NULL, the status of the first
/// wrong field or of the method's or the guard's init, TRIBO_ERR_CONTROLLER for sections together with a PI,
/// TRIBO_ERR_PAPER_SAMPLE_TIME for the paper's controller at another sample time than its own, or TRIBO_ERR_PART for a
/// method or a guard of Q31. Writes `params` only with TRIBO_OK; the params of the method may have been written when
/// the guard is refused. The params of method and guard must outlive `params`, which point to them. Not for the tick.
tribo_status_t tribo_force_loop_f32_init(tribo_force_loop_f32_params_t       *params,
                                         const tribo_force_loop_f32_config_t *config);

/// Puts the loop to rest at F = 0 and its counters to 0: the second of the two calls that start a loop. `keep_learned`
/// keeps what an earlier run has learned, and the guard's latched cause and fade; the first start of a zeroed state has
/// nothing to keep. Returns TRIBO_OK, TRIBO_ERR_NULL, or TRIBO_ERR_MEMORY if the params name a method and state.memory
/// is null: such a loop would run the controller without a method, and count each tick as a bad input.
///
/// Set state.memory before each start, even if only later params name a method: the start does not change the pointer.
/// Params without a method do not touch the memory. Starting a running loop makes u jump. A start without
/// `keep_learned` resets the memory that a learner in the background works on, so make sure that the learner is idle.
tribo_status_t tribo_force_loop_f32_start(tribo_force_loop_f32_state_t        *state,
                                          const tribo_force_loop_f32_params_t *params,
                                          bool                                 keep_learned);

/// Runs one tick: returns the manipulated input u in N for the reference `r_n` and the measured end-point force `y_n`,
/// both in N. Cannot fail. Writes all of `signals`, which may be null.
float tribo_force_loop_f32_step(const tribo_force_loop_f32_params_t *params,
                                tribo_force_loop_f32_state_t        *state,
                                float                                r_n,
                                float                                y_n,
                                tribo_force_loop_f32_signals_t      *signals);

/// The first half of a tick, for your own controller between the two halves: pass `e` to your controller, and its
/// output `v` to the second half.
///
///     e = tribo_force_loop_f32_error(&params, &state, r, y);
///     u = tribo_force_loop_f32_command(&params, &state, my_controller(e), &excess);
///
/// The guard, retuning and bad inputs work as in tribo_force_loop_f32_step, but a change from a method to none drops
/// the method's term. The controller of the params does not run. `excess` is u minus the sum of v and the method's
/// term: 0 within the limits, and otherwise the part that the limit has cut off, for the anti-windup of your
/// controller. Without a method u is v within the limits. A v that is not a number, or beyond 1e6 N, counts as a bad
/// input and as 0; so does a term of a corrupt memory. Cannot fail.
float tribo_force_loop_f32_error(const tribo_force_loop_f32_params_t *params,
                                 tribo_force_loop_f32_state_t        *state,
                                 float                                r_n,
                                 float                                y_n);

/// The second half of a tick: returns u in N for the output `v_n` of your controller.
float tribo_force_loop_f32_command(const tribo_force_loop_f32_params_t *params,
                                   tribo_force_loop_f32_state_t        *state,
                                   float                                v_n,
                                   float                               *excess_n);

/// Returns the default config, for forces of about 1 N.
tribo_guard_f32_config_t tribo_guard_f32_default(void);

/// Returns a config for a rig with this breakaway at its usual force, this lag from u to F, and this standard deviation
/// of y (0 if it is not known). Checks nothing.
tribo_guard_f32_config_t tribo_guard_f32_tuned(float breakaway_n, float lag_s, float noise_n, float sample_time_s);

/// Names the guard in a loop's config. The loop's init computes `params` from `config`.
tribo_loop_guard_t tribo_guard_f32_use(tribo_guard_f32_params_t *params, const tribo_guard_f32_config_t *config);

/// Computes `params` of a guard for a loop of your own, which calls tribo_guard_f32_step. Returns TRIBO_OK,
/// TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME, or the status of a row of TRIBO_GUARD_PARAMETERS. Writes nothing unless
/// TRIBO_OK. Not for the tick.
tribo_status_t tribo_guard_f32_init(tribo_guard_f32_params_t       *params,
                                    const tribo_guard_f32_config_t *config,
                                    float                           sample_time_s);

/// Clears the history and the cause; friction is not faded.
void tribo_guard_f32_reset(tribo_guard_f32_state_t *state);

/// Clears the cause and the history; the fade rises to 1 again.
void tribo_guard_f32_restore(tribo_guard_f32_state_t *state);

/// Runs one tick of the guard on the reference, the reading, and the friction contained in u. Returns the fade, the
/// factor on friction in the next tick. Cannot fail: the guard ignores a tick in which `good` is false (r or y is not
/// credible), or in which a force is NaN or beyond TRIBO_F32_FORCE_MAX_N. A loop whose params name a guard makes this
/// call itself.
float tribo_guard_f32_step(const tribo_guard_f32_params_t *params,
                           tribo_guard_f32_state_t        *state,
                           float                           r_n,
                           float                           y_n,
                           float                           f_n,
                           bool                            good);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

#define TRIBO_FORCE_LOOP_F32_PARAMS_VERSION                                                                            \
    9 ///< changes with the fields of params and their meaning, for params made on a host

/// What a method tells the loop. The memory of a method begins with this struct. Zeros: the method has not had a tick
/// yet.
typedef struct
{
    float e_n;        ///< the controller's error of the last tick
    float y_n;        ///< the reading from which `e_n` was computed
    float term_n;     ///< added to v in the last tick, without its lead: a change of params continues from this value
    float friction_n; ///< added to u in this tick, for a guard
    bool  has_e;      ///< false: there is no `e_n` yet
    bool  has_y;      ///< false: `e_n` does not depend on y
} tribo_force_loop_f32_tick_t;

/// A method's functions in a tick, which the loop calls in this order. `memory` is state.memory and never null: without
/// memory the loop does not call the method. No function can fail.
typedef struct
{
    /// Returns the controller's error, and writes the struct above except `term_n`. `fade` is the guard's factor on
    /// friction, 0 to 1.
    float (*error)(const tribo_force_loop_f32_params_t *params, void *memory, float r_n, float y_n, float fade);

    /// Returns the term to add to the controller's output `v_n`, and writes `term_n`.
    float (*term)(const tribo_force_loop_f32_params_t *params, void *memory, float v_n);

    /// Runs when u is known. `signals` is complete except for the compensator's signals, which the method fills in.
    void (*after)(const tribo_force_loop_f32_params_t *params,
                  void                                *memory,
                  float                                v_n,
                  float                                u_n,
                  tribo_force_loop_f32_signals_t      *signals);

    /// Prepares the first tick after a change of params, which has to add `term_n`. `anew`: another method ran the loop
    /// before.
    void (*enter)(void *memory, float term_n, bool anew);

    /// Prepares the first tick after a start. Without `keep_learned` it forgets what was learned.
    void (*start)(void *memory, bool keep_learned);
} tribo_force_loop_f32_functions_t;

/// A compensation method other than the paper's. The params of a method begin with this struct, and `params->method`
/// points to them. They hold the address of a single function: params made on a host can be constants of a program, and
/// the library contains no table of addresses.
typedef struct
{
    void (*functions)(tribo_force_loop_f32_functions_t *functions); ///< writes the method's functions
} tribo_force_loop_f32_method_t;

typedef struct
{
    float   position_n;
    int32_t sign; ///< sign of the last move; 0 before the first move
} tribo_play_f32_state_t;

struct tribo_guard_f32_state
{
    uint8_t                running;       ///< 0 before the first tick
    uint8_t                turns, strays; ///< number in succession
    tribo_guard_cause_t    cause;         ///< latched
    float                  fade;          ///< factor on friction, 0 to 1
    uint32_t               since;         ///< ticks since the last reversal, up to quick_ticks
    float                  work;          ///< W since then, N^2; constant from quick_ticks on
    float                  high_n, low_n; ///< largest and smallest error since then, or 0
    float                  r_n, y_n;      ///< r and y of the last tick
    tribo_play_f32_state_t play;          ///< follows f with a play of turn_n
};

/// Constants of a guard, computed by tribo_guard_f32_init. Constant from then on; several loops may share them.
struct tribo_guard_f32_params
{
    /// tribo_guard_f32_step, which a loop calls through this pointer.
    float (*step)(const struct tribo_guard_f32_params *params,
                  tribo_guard_f32_state_t             *state,
                  float                                r_n,
                  float                                y_n,
                  float                                f_n,
                  bool                                 good);
    uint8_t  on; ///< 1, set by init. 0: the guard judges nothing, forgets its cause and removes its fading
    float    half_n;
    float    stray_n;
    float    work;      ///< limit of hunting, N^2
    float    fade_step; ///< change of the fade in a tick
    uint32_t quick_ticks;
};

/// Constants of a loop, computed by tribo_force_loop_f32_init. Constant from then on; several loops may share them.
struct tribo_force_loop_f32_params
{
    float                                input_max_n; ///< largest credible |r| and |y|
    float                                gain;        ///< eta
    tribo_controller_f32_params_t        controller;
    tribo_compensator_f32_params_t       compensator;
    const tribo_force_loop_f32_method_t *method; ///< null: the paper's method, with `compensator`
    const tribo_guard_f32_params_t      *guard;  ///< null: no guard
};

/// Everything that a tick remembers for the next. Set it to zero, set `memory`, and start it.
struct tribo_force_loop_f32_state
{
    /// Memory of the method that the params name, for example `&memory.state.tick` of a tribo_feedforward_f32_memory_t.
    /// Null: no method. One loop has one memory, which must outlive the loop. tribo_force_loop_f32_start does not
    /// change this pointer.
    tribo_force_loop_f32_tick_t *memory;
    uintptr_t memory_seal; ///< ~memory; if it differs, `memory` is corrupt and the loop does not use it
    const tribo_force_loop_f32_params_t *active;      ///< params of the last tick; null after a start
    uintptr_t                            active_seal; ///< ~active; if it differs, `active` is corrupt
    tribo_guard_f32_state_t              guard;       ///< state of the guard that the params name
    float                                friction_n;  ///< f^ of the last tick
    /// Bad r, y, v or term, corrupt pointers, ticks of a method without memory; stops at UINT32_MAX.
    uint32_t                      bad_inputs;
    tribo_controller_f32_state_t  controller; ///< contains limited_ticks
    tribo_compensator_f32_state_t compensator;
};

#ifdef __cplusplus
}
#endif

#endif
