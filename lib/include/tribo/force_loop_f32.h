/// The friction-compensated force loop of Fig. 9, single precision: one call a tick.
///
///     y --> e = r - y --> controller --> (+ gain f^ of the last tick) --> limit --> u
///                              ^                                            |
///                              '------ anti-windup ------------------------+--> compensator --> f^
///
/// Forces are in N, u is scaled so that u = F at rest without friction. (Newton stands for the unit in which the plant was
/// identified, e.g. N m.)
///
/// A tick is total: for any r and y, u is finite and within u_min_n to u_max_n. If one of them is bad (NaN, infinite,
/// beyond input_max_n) the tick is counted and runs with e = 0, so u coasts on the controller's state. The loop resumes
/// with the next good input. The drive decides when this is a fault.
///
/// Retuning: pass a pointer to other validated params at any tick. The first tick with it takes the state over without a
/// bump in u, even if cascade, gain, friction and arm have changed (new limits hold at once). It reads the old params once
/// more and costs about three ticks; free them when state.active is the new pointer. Do not write to params in use, nor to
/// a breakaway table that they point to. All params of a loop are for one sample time.
///
/// Friction is compensated by the paper's method (off: gain 0), or by the method that the config names: feedforward_f32.h. A guard
/// against over-compensation may watch the loop. A drive that names neither links neither. A change of params
/// may change the method without a jump of u.
///
/// A flipped bit in RAM: a corrupt pointer in the state is not used. It is counted in `bad_inputs`. With a corrupt `active` there is no
/// change of params. With a corrupt `memory` the controller runs alone until the next start. Params are trusted: they hold factors,
/// pointers to params of parts, and pointers to code (the functions of `method` and of the guard). Nothing in a tick checks them, so keep
/// them in flash, in RAM with ECC, or under a checksum of your own.
///
/// A third and a fourth section, a breakaway table and a change of params cost more when used; tests/bench/numbers_md.py prints the
/// figures. No heap, no libm, no globals, no double in a tick; the same bits on every target. Not synchronized: one state, one tick.

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

/// A method or a guard that a config names. The call that names it is all that links it: tribo_feedforward_f32_use,
/// tribo_sensorless_f32_use, tribo_guard_f32_use and those of Q31. All 0: none.
typedef struct tribo_loop_part
{
    /// Makes `params` of `config`, for the loop that is being made.
    tribo_status_t (*make_f32)(const struct tribo_loop_part        *part,
                               const tribo_force_loop_f32_config_t *loop,
                               tribo_force_loop_f32_params_t       *made);
    tribo_status_t (*make_q31)(const struct tribo_loop_part        *part,
                               const tribo_force_loop_f32_config_t *loop,
                               float                                full_scale_n,
                               struct tribo_force_loop_q31_params  *made);
    const void *config;
    const void *sensorless; ///< of a method that has two
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

/// Of a loop in either arithmetic. The controller is `pi`, or sections: `tribo_paper_controller_f32`, or your own. With a controller of
/// your own between the halves of a tick any will do, e.g. kp = 1: it does not run.
struct tribo_force_loop_f32_config
{
    float sample_time_s; ///< of every tick, 1e-6 to 0.1 s
    float input_max_n;   ///< largest credible |r| and |y|, 1e-6 to 1e6 N
    float gain;          ///< eta, 0 to 2; 0 turns the compensation off, 1 overcompensates
    float usual_force_n; ///< |F| around which the rig usually works, 0 to 1e6 N; 0: tribo_force_loop_f32_usual_force_n
    tribo_controller_f32_config_t  controller; ///< its limits; sections for the same sample time, none with `pi`
    tribo_pi_t                     pi;         ///< all 0: sections
    tribo_compensator_f32_config_t compensator;
    tribo_loop_part_t              method; ///< all 0: the paper's; `config.method = tribo_feedforward_f32_use(...)`
    tribo_loop_guard_t             guard;  ///< all 0: none; `config.guard = tribo_guard_f32_use(...)`
};

/// Signals of one tick, for logging.
typedef struct
{
    float                           e_n;             ///< the controller's error; r - y with the paper's method
    float                           friction_term_n; ///< added to v; the paper's is gain f^[k-1]
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
    float turn_n;       ///< f has reversed after it returns by this much; 1e-9 to 1e6 N, about L/3
    float quick_time_s; ///< closer reversals may be hunting, 1e-6 to 1e3 s and up to 1e5 samples
    float stray_n;      ///< of an overshoot, 1e-9 to 1e6 N, about L/15 and over twice the noise's peaks
    float fade_time_s;  ///< 1e-6 to 1e3 s and up to 1e6 samples
} tribo_guard_f32_config_t;

/// The paper's loop: 1 ms, gain 0.85, friction and arm of Eqs. (7), (9), (10) with displacement in degrees, the H-infinity
/// controller of Eqs. (13), (14); u within +-2 N, |r| and |y| up to 2 N.
/// Its controller is for 1 ms alone: another sample_time_s needs sections of its own.
tribo_force_loop_f32_config_t tribo_force_loop_f32_paper(void);

/// The beginning of a config for a rig of your own. What depends on the rig is 0 and refused until it is given: sample_time_s,
/// input_max_n, sections and limits of the controller, breakaway in both directions (offset_n and slope), and the arm. The rest is as
/// in the paper's loop: the gain and the shape of friction, which the paper's method alone reads; its v0_n_per_s is a rate of
/// 4.5 % of the breakaway per second.
tribo_force_loop_f32_config_t tribo_force_loop_f32_rig(void);

/// The force around which the rig usually works: usual_force_n, or a quarter of the larger |limit| of u where that is 0.
static inline float tribo_force_loop_f32_usual_force_n(const tribo_force_loop_f32_config_t *config)
{
    const float up   = config->controller.u_max_n;
    const float down = -config->controller.u_min_n;
    return config->usual_force_n > 0.0f ? config->usual_force_n : 0.25f * (up > down ? up : down);
}

/// Checks `config` field by field and computes `params`. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_INPUT_MAX, TRIBO_ERR_GAIN, TRIBO_ERR_USUAL_FORCE, TRIBO_ERR_PI, TRIBO_ERR_CONTROLLER where there are sections beside a PI, or a status of tribo_controller_f32_init,
/// TRIBO_ERR_PAPER_SAMPLE_TIME for the paper's controller at another sample time than its own, a status of
/// tribo_compensator_f32_init, and then of the method and the guard, or TRIBO_ERR_PART for one of Q31. Writes no `params` unless
/// TRIBO_OK; those of the method may be made already where the guard is refused. Both must outlive `params`, which point to them. Not for
/// the tick.
tribo_status_t tribo_force_loop_f32_init(tribo_force_loop_f32_params_t       *params,
                                         const tribo_force_loop_f32_config_t *config);

/// The loop at rest at F = 0, counters 0; the second call of two. `keep_learned` keeps what an earlier run has learned, and what the guard has
/// latched and faded; the first start of a zeroed state has nothing to keep. Returns TRIBO_OK, TRIBO_ERR_NULL, or TRIBO_ERR_MEMORY where
/// the params name a method and state.memory is null: such a loop would be the controller alone, and count each tick as a bad input.
///
/// Name state.memory before each start, also where later params may name a method: the start takes the pointer as it is. Params without a
/// method leave the memory alone. A start of a running loop makes u jump. Without `keep_learned` it resets what a learner in the background
/// may be at work on, and wants that one to be idle.
tribo_status_t tribo_force_loop_f32_start(tribo_force_loop_f32_state_t        *state,
                                          const tribo_force_loop_f32_params_t *params,
                                          bool                                 keep_learned);

/// One tick: reference `r_n` and measured end-point force `y_n` in N give the manipulated input u in N. Cannot fail.
/// `signals` is written whole; it may be null.
float tribo_force_loop_f32_step(const tribo_force_loop_f32_params_t *params,
                                tribo_force_loop_f32_state_t        *state,
                                float                                r_n,
                                float                                y_n,
                                tribo_force_loop_f32_signals_t      *signals);

/// The tick in two halves, for a controller of your own between them: `e` to your controller, its output `v` to the second.
///
///     e = tribo_force_loop_f32_error(&params, &state, r, y);
///     u = tribo_force_loop_f32_command(&params, &state, my_controller(e), &excess);
///
/// Guard, retuning and bad inputs as in the tick, but a change from a method to none drops its term. The params' own controller does not run. `excess` is what the limit has taken, u less the
/// sum of v and the method's term, 0 within the limits: it is what the anti-windup of your controller wants to know. Without a method
/// u is v within the limits. A v that is not a number, or beyond 1e6 N, counts as a bad input and as 0. Cannot fail.
float tribo_force_loop_f32_error(const tribo_force_loop_f32_params_t *params,
                                 tribo_force_loop_f32_state_t        *state,
                                 float                                r_n,
                                 float                                y_n);

/// The second half of that tick: u in N for the output v of your controller.
float tribo_force_loop_f32_command(const tribo_force_loop_f32_params_t *params,
                                   tribo_force_loop_f32_state_t        *state,
                                   float                                v_n,
                                   float                               *excess_n);

/// The defaults, for forces about 1 N.
tribo_guard_f32_config_t tribo_guard_f32_default(void);

/// Parameters for a rig: breakaway at its usual force, lag from u to F, standard deviation of y, or 0 where that is unknown. Checks nothing.
tribo_guard_f32_config_t tribo_guard_f32_tuned(float breakaway_n, float lag_s, float noise_n, float sample_time_s);

/// A guard of a loop's config: the loop's init makes `params` of `config`.
tribo_loop_guard_t tribo_guard_f32_use(tribo_guard_f32_params_t *params, const tribo_guard_f32_config_t *config);

/// A guard beside a loop that is not this library's, with tribo_guard_f32_step. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME or
/// that of a row of TRIBO_GUARD_PARAMETERS. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_guard_f32_init(tribo_guard_f32_params_t       *params,
                                    const tribo_guard_f32_config_t *config,
                                    float                           sample_time_s);

/// No history, no cause, full friction.
void tribo_guard_f32_reset(tribo_guard_f32_state_t *state);

/// Clears cause and history; the fade rises to 1 again.
void tribo_guard_f32_restore(tribo_guard_f32_state_t *state);

/// One tick of the guard: reference, reading, and the friction in u. Returns the fade of friction for the next tick. Cannot fail:
/// with `good` false (r or y is not credible), or with a NaN or a force beyond TRIBO_F32_FORCE_MAX_N, it judges nothing. A loop
/// whose params have a guard calls it.
float tribo_guard_f32_step(const tribo_guard_f32_params_t *params,
                           tribo_guard_f32_state_t        *state,
                           float                           r_n,
                           float                           y_n,
                           float                           f_n,
                           bool                            good);

// --- what they hold: give it room; write only what a comment says ------------------------------------------------------

#define TRIBO_FORCE_LOOP_F32_PARAMS_VERSION 9 ///< of the params' fields and their meaning, for params made on a host

/// What the loop reads of a method. The memory of a method begins with this struct; all 0 is a method without a tick.
typedef struct
{
    float e_n;        ///< the controller's error of the last tick
    float y_n;        ///< the reading that `e_n` was made of
    float term_n;     ///< added to v in the last tick, without a pulse: a change of params goes on from it
    float friction_n; ///< added to u in this tick, for a guard
    bool  has_e;      ///< false: there is no `e_n` yet
    bool  has_y;      ///< false: `e_n` does not depend on y
} tribo_force_loop_f32_tick_t;

/// A method's part of a tick, called in this order. `memory` is state.memory and never null: a loop without it is the
/// controller alone. None can fail.
typedef struct
{
    /// The controller's error; writes what the loop reads, except `term_n`. `fade` is the guard's factor on friction, 0 to 1.
    float (*error)(const tribo_force_loop_f32_params_t *params, void *memory, float r_n, float y_n, float fade);

    /// The term to add to the controller's output `v_n`; writes `term_n`.
    float (*term)(const tribo_force_loop_f32_params_t *params, void *memory, float v_n);

    /// Called once u is known. `signals` is complete except for the compensator's, which are at rest for the method to fill.
    void (*after)(const tribo_force_loop_f32_params_t *params,
                  void                                *memory,
                  float                                v_n,
                  float                                u_n,
                  tribo_force_loop_f32_signals_t      *signals);

    /// After a change of params: the next tick shall add `term_n`. `anew`: another method ran the loop before.
    void (*enter)(void *memory, float term_n, bool anew);

    /// Before the first tick. Without `keep_learned` nothing is learned.
    void (*start)(void *memory, bool keep_learned);
} tribo_force_loop_f32_functions_t;

/// A compensation method other than the paper's. The params of a method begin with this struct, and `params->method` points to
/// them. They hold the address of one function, so that params made on a host can be constants of a program, and the library itself
/// holds no address.
typedef struct
{
    void (*functions)(tribo_force_loop_f32_functions_t *functions); ///< writes the method's functions
} tribo_force_loop_f32_method_t;

typedef struct
{
    float   position_n;
    int32_t sign; ///< sign of the last move, 0 before the first
} tribo_play_f32_state_t;

struct tribo_guard_f32_state
{
    uint8_t                running;       ///< 0 before the first tick
    uint8_t                turns, strays; ///< in succession
    tribo_guard_cause_t    cause;         ///< latched
    float                  fade;          ///< of friction, 0 to 1
    uint32_t               since;         ///< ticks since the last reversal, up to quick_ticks
    float                  work;          ///< W since then, N^2; constant from quick_ticks on
    float                  high_n, low_n; ///< largest and smallest error since then, and 0
    float                  r_n, y_n;      ///< of the last tick
    tribo_play_f32_state_t play;          ///< of f
};

/// Constants of a step, made by tribo_guard_f32_init. Const from then on; may be shared.
struct tribo_guard_f32_params
{
    /// tribo_guard_f32_step: a loop calls it through this pointer.
    float (*step)(const struct tribo_guard_f32_params *params,
                  tribo_guard_f32_state_t             *state,
                  float                                r_n,
                  float                                y_n,
                  float                                f_n,
                  bool                                 good);
    uint8_t  on; ///< 1, set by init. 0: the guard judges nothing, forgets its cause and removes its fading
    float    half_n;
    float    stray_n;
    float    work;      ///< of hunting, N^2
    float    fade_step; ///< change of the fade in a tick
    uint32_t quick_ticks;
};

/// Constants of a tick, made by tribo_force_loop_f32_init. Const from then on; may be shared by loops.
struct tribo_force_loop_f32_params
{
    float                                input_max_n; ///< largest credible |r| and |y|
    float                                gain;        ///< eta
    tribo_controller_f32_params_t        controller;
    tribo_compensator_f32_params_t       compensator;
    const tribo_force_loop_f32_method_t *method; ///< null: the paper's, by the compensator
    const tribo_guard_f32_params_t      *guard;  ///< null: none
};

/// All that a tick leaves to the next. Zero it, name the memory, and start it.
struct tribo_force_loop_f32_state
{
    /// Of the method that the params name, e.g. `&memory.state.tick` of a tribo_feedforward_f32_memory_t; null: no method. Of one loop
    /// alone, and it must outlive the loop. tribo_force_loop_f32_start leaves it as it is.
    tribo_force_loop_f32_tick_t         *memory;
    uintptr_t                            memory_seal; ///< ~memory; otherwise `memory` is corrupt and not used
    const tribo_force_loop_f32_params_t *active;      ///< params of the last tick; null after a start
    uintptr_t                            active_seal; ///< ~active, likewise
    tribo_guard_f32_state_t              guard;       ///< of a guard that the params name
    float                                friction_n;  ///< f^ of the last tick
    uint32_t bad_inputs; ///< bad r or y, corrupt pointers above, ticks of a method without memory; stops at UINT32_MAX
    tribo_controller_f32_state_t  controller; ///< with limited_ticks
    tribo_compensator_f32_state_t compensator;
};

#ifdef __cplusplus
}
#endif

#endif
