/// The friction-compensated force loop of Fig. 9 in Q31, one call a tick.
///
/// Forces are Q31 of the params' full scale FS; choose FS no smaller than the largest force and limit. A difference r - y or
/// a net force beyond FS saturates without harm: friction is at breakaway there and u at its limit. For any r and y, u is
/// within u_min to u_max. A reference or a reading beyond input_max_n, or at an end of the scale (q31.h), is a bad input:
/// the tick is counted and runs with e = 0, so u coasts on the controller's state. Saturations are counted in the states of the parts.
///
/// Retuning, as in f32: pass a pointer to other params at any tick; u does not jump unless a new limit requires it. It
/// takes about five ticks and reads the old params and their table once more; free both when state.active is the new
/// pointer. All params of a loop are for one full scale and one sample time: the state knows neither.
///
/// Other methods, a change of method, and the guard: as in f32.
///
/// No float, no heap, no division of more than 32 bits; the same bits on every target. Not synchronized.

#ifndef TRIBO_FORCE_LOOP_Q31_H
#define TRIBO_FORCE_LOOP_Q31_H

#include "tribo/controller_q31.h"
#include "tribo/force_loop_f32.h"
#include "tribo/friction_q31.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_force_loop_q31_params tribo_force_loop_q31_params_t;
typedef struct tribo_guard_q31_state       tribo_guard_q31_state_t;
typedef struct tribo_guard_q31_params      tribo_guard_q31_params_t;
typedef struct tribo_force_loop_q31_state  tribo_force_loop_q31_state_t;

/// Signals of one tick, for logging.
typedef struct
{
    int32_t                         e;             ///< the controller's error; r - y with the paper's method, Q31
    int32_t                         friction_term; ///< added to v, Q31; the paper's is gain f^[k-1]
    tribo_controller_q31_signals_t  controller;    ///< controller term v, u, limited
    tribo_compensator_q31_signals_t compensator;   ///< F^, n, L, rise, f^, Q1, Q2, Q
} tribo_force_loop_q31_signals_t;

/// A loop's config in N, and what Q31 adds. Method and guard are those of Q31: `config.loop.method = tribo_feedforward_q31_use(...)`.
typedef struct
{
    tribo_force_loop_f32_config_t loop;
    float                         full_scale_n; ///< 2^31, 1e-3 to 1e6 N
    tribo_breakaway_point_q31_t  *table;        ///< room for the points of a breakaway table; null where there is none
    tribo_headroom_q31_t         *headroom;     ///< written by the init; null: not asked for
} tribo_force_loop_q31_config_t;

/// Makes `params` of a loop. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_FULL_SCALE, a status of tribo_force_loop_f32_init, of
/// tribo_controller_q31_init, or of tribo_compensator_q31_init, and then of the method and the guard. Writes only the table, and params of
/// method and guard, unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_force_loop_q31_init(tribo_force_loop_q31_params_t       *params,
                                         const tribo_force_loop_q31_config_t *config);

/// As tribo_force_loop_f32_start.
tribo_status_t tribo_force_loop_q31_start(tribo_force_loop_q31_state_t        *state,
                                          const tribo_force_loop_q31_params_t *params,
                                          bool                                 keep_learned);

/// One tick: reference `r` and measured end-point force `y` give the manipulated input u, all Q31. Cannot fail.
/// `signals` is written whole; it may be null.
int32_t tribo_force_loop_q31_step(const tribo_force_loop_q31_params_t *params,
                                  tribo_force_loop_q31_state_t        *state,
                                  int32_t                              r,
                                  int32_t                              y,
                                  tribo_force_loop_q31_signals_t      *signals);

/// The tick in two halves, for a controller of your own between them: `e` to your controller, its output `v` to the second.
///
///     e = tribo_force_loop_q31_error(&params, &state, r, y);
///     u = tribo_force_loop_q31_command(&params, &state, my_controller(e), &excess);
///
/// Guard, retuning and bad inputs as in the tick. The params' own controller does not run. `excess` is what the limit has taken, u less the
/// sum of v and the method's term, 0 within the limits: it is what the anti-windup of your controller wants to know. Without a method
/// u is v within the limits. Cannot fail.
int32_t tribo_force_loop_q31_error(const tribo_force_loop_q31_params_t *params,
                                   tribo_force_loop_q31_state_t        *state,
                                   int32_t                              r,
                                   int32_t                              y);

/// The second half of that tick: u for the output v of your controller.
int32_t tribo_force_loop_q31_command(const tribo_force_loop_q31_params_t *params,
                                     tribo_force_loop_q31_state_t        *state,
                                     int32_t                              v,
                                     int32_t                             *excess);

/// No history, no cause, full friction.
void tribo_guard_q31_reset(tribo_guard_q31_state_t *state);

/// Clears cause and history; the fade rises to 1 again.
void tribo_guard_q31_restore(tribo_guard_q31_state_t *state);

/// As tribo_guard_f32_use.
tribo_loop_guard_t tribo_guard_q31_use(tribo_guard_q31_params_t *params, const tribo_guard_f32_config_t *config);

/// As tribo_guard_f32_init. Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE or a status of tribo_guard_f32_init; turn_n and stray_n
/// are 1e-6 FS to under FS. Writes nothing unless TRIBO_OK.
tribo_status_t tribo_guard_q31_init(tribo_guard_q31_params_t       *params,
                                    const tribo_guard_f32_config_t *config,
                                    float                           sample_time_s,
                                    float                           full_scale_n);

/// One tick of the guard: reference, reading, and the friction in u, all Q31. Returns the fade of friction for the next tick, Q32.
/// Cannot fail: with `good` false (r or y is not credible), or r or y at an end of the scale, it judges nothing. A loop whose params have a guard calls it.
uint32_t tribo_guard_q31_step(const tribo_guard_q31_params_t *params,
                              tribo_guard_q31_state_t        *state,
                              int32_t                         r,
                              int32_t                         y,
                              int32_t                         f,
                              bool                            good);

// --- what they hold: give it room; write only what a comment says ------------------------------------------------------

#define TRIBO_FORCE_LOOP_Q31_PARAMS_VERSION 9 ///< of the params' fields and their meaning, for params made on a host

/// What the loop reads of a method: as tribo_force_loop_f32_tick_t, in Q31.
typedef struct
{
    int32_t e;
    int32_t y;
    int32_t term;
    int32_t friction;
    bool    has_e, has_y;
} tribo_force_loop_q31_tick_t;

/// A method's part of a tick: as tribo_force_loop_f32_functions_t. Forces are Q31.
typedef struct
{
    /// `fade` is Q32; UINT32_MAX is all of friction.
    int32_t (*error)(const tribo_force_loop_q31_params_t *params, void *memory, int32_t r, int32_t y, uint32_t fade);
    int32_t (*term)(const tribo_force_loop_q31_params_t *params, void *memory, int32_t v);
    void (*after)(const tribo_force_loop_q31_params_t *params,
                  void                                *memory,
                  int32_t                              v,
                  int32_t                              u,
                  tribo_force_loop_q31_signals_t      *signals);
    void (*enter)(void *memory, int32_t term, bool anew);
    void (*start)(void *memory, bool keep_learned);
} tribo_force_loop_q31_functions_t;

/// A compensation method: as tribo_force_loop_f32_method_t.
typedef struct
{
    void (*functions)(tribo_force_loop_q31_functions_t *functions); ///< writes the method's functions
} tribo_force_loop_q31_method_t;

typedef struct
{
    int32_t position;
    int32_t sign; ///< sign of the last move, 0 before the first
} tribo_play_q31_state_t;

struct tribo_guard_q31_state
{
    uint8_t                running;       ///< 0 before the first tick
    uint8_t                turns, strays; ///< in succession
    tribo_guard_cause_t    cause;         ///< latched
    uint32_t               fade;          ///< of friction, Q32; UINT32_MAX is all of it
    uint32_t               since;         ///< ticks since the last reversal, up to quick_ticks
    int64_t                work;          ///< W since then; constant from quick_ticks on
    int32_t                high, low;     ///< largest and smallest error since then, and 0
    int32_t                r, y;          ///< of the last tick
    tribo_play_q31_state_t play;          ///< of f
};

/// Constants of a step, made by tribo_guard_q31_init. Const from then on; may be shared.
struct tribo_guard_q31_params
{
    /// tribo_guard_q31_step: a loop calls it through this pointer.
    uint32_t (*step)(const struct tribo_guard_q31_params *params,
                     tribo_guard_q31_state_t             *state,
                     int32_t                              r,
                     int32_t                              y,
                     int32_t                              f,
                     bool                                 good);
    uint8_t  on;          ///< 1, set by init. 0: the guard judges nothing, forgets its cause and removes its fading
    int32_t  half;        ///< 2^-29 full scales
    int32_t  stray;       ///< 2^-28 full scales
    int64_t  work;        ///< of hunting, 2^-43 full scales squared
    uint32_t fade_step;   ///< change of the fade in a tick, Q32
    uint32_t quick_ticks; ///< up to 2^17
};

/// Constants of a tick, made by tribo_force_loop_q31_init. Const from then on; may be shared by loops.
struct tribo_force_loop_q31_params
{
    int32_t                              input_max; ///< largest credible |r| and |y|, Q31; at most 2^31 - 2
    int32_t                              gain;      ///< eta, Q29, 0 to 2
    tribo_controller_q31_params_t        controller;
    tribo_compensator_q31_params_t       compensator;
    const tribo_force_loop_q31_method_t *method; ///< null: the paper's, by the compensator
    const tribo_guard_q31_params_t      *guard;  ///< null: none
};

/// As tribo_force_loop_f32_state_t.
struct tribo_force_loop_q31_state
{
    tribo_force_loop_q31_tick_t         *memory;
    uintptr_t                            memory_seal;
    const tribo_force_loop_q31_params_t *active;
    uintptr_t                            active_seal;
    tribo_guard_q31_state_t              guard;
    int32_t                              friction; ///< f^ of the last tick, Q31
    uint32_t                             bad_inputs;
    uint32_t                             saturated;  ///< errors and friction terms clamped; stops at UINT32_MAX
    tribo_controller_q31_state_t         controller; ///< with limited_ticks
    tribo_compensator_q31_state_t        compensator;
};

#ifdef __cplusplus
}
#endif

#endif
