/// The friction-compensated force loop of Fig. 9 in Q31, one call a tick.
///
/// Forces are Q31 with the full scale FS of the params; choose FS no smaller than the largest force and limit. A
/// difference r - y or a net force beyond FS saturates without harm, because friction is at breakaway there and u at
/// its limit. For any r and y, u is within u_min to u_max. A reference or a reading beyond input_max_n, or at a limit
/// of the scale (q31.h), is a bad input: the loop counts the tick and runs it with e = 0, as force_loop_f32.h says. The
/// states of the parts count saturations.
///
/// Retune while running: pass a pointer to other params at any tick; u does not jump unless a new limit requires it.
/// That tick costs about five ticks and reads the old params and their table once more. Free both when state.active is
/// the new pointer. All params of a loop have one full scale and one sample time, which the state does not know.
///
/// Methods, a change of method, and the guard work as force_loop_f32.h says.
///
/// No float, no heap, no division of more than 32 bits. Every target computes the same bits. Not synchronized: one
/// state, one tick.

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
    int32_t                         friction_term; ///< added to v, Q31; with the paper's method gain f^[k-1]
    tribo_controller_q31_signals_t  controller;    ///< controller term v, u, limited
    tribo_compensator_q31_signals_t compensator;   ///< F^, n, L, rise, f^, Q1, Q2, Q
} tribo_force_loop_q31_signals_t;

/// A loop's config in N, and the members that Q31 needs in addition. Name a method and a guard of Q31 in it:
/// `config.loop.method = tribo_feedforward_q31_use(...)`.
typedef struct
{
    tribo_force_loop_f32_config_t loop;
    float                         full_scale_n; ///< the force that 2^31 stands for, 1e-3 to 1e6 N
    tribo_breakaway_point_q31_t  *table;        ///< room for the points of the breakaway table; null without a table
    tribo_headroom_q31_t         *headroom;     ///< the init writes it unless it is null
} tribo_force_loop_q31_config_t;

/// Does what tribo_force_loop_f32_init does, in Q31. Also returns TRIBO_ERR_FULL_SCALE, or a status of
/// tribo_controller_q31_init. Unless it returns TRIBO_OK it writes only the table and the params of method and guard.
/// Not for the tick.
tribo_status_t tribo_force_loop_q31_init(tribo_force_loop_q31_params_t       *params,
                                         const tribo_force_loop_q31_config_t *config);

/// Does what tribo_force_loop_f32_start does, in Q31.
tribo_status_t tribo_force_loop_q31_start(tribo_force_loop_q31_state_t        *state,
                                          const tribo_force_loop_q31_params_t *params,
                                          bool                                 keep_learned);

/// Runs one tick: returns the manipulated input u for the reference `r` and the measured end-point force `y`, all Q31.
/// Cannot fail. Writes all of `signals`, which may be null.
int32_t tribo_force_loop_q31_step(const tribo_force_loop_q31_params_t *params,
                                  tribo_force_loop_q31_state_t        *state,
                                  int32_t                              r,
                                  int32_t                              y,
                                  tribo_force_loop_q31_signals_t      *signals);

/// Does what tribo_force_loop_f32_error does, in Q31. Every error and v is credible.
int32_t tribo_force_loop_q31_error(const tribo_force_loop_q31_params_t *params,
                                   tribo_force_loop_q31_state_t        *state,
                                   int32_t                              r,
                                   int32_t                              y);

/// Does what tribo_force_loop_f32_command does, in Q31.
int32_t tribo_force_loop_q31_command(const tribo_force_loop_q31_params_t *params,
                                     tribo_force_loop_q31_state_t        *state,
                                     int32_t                              v,
                                     int32_t                             *excess);

/// Does what tribo_guard_f32_reset does.
void tribo_guard_q31_reset(tribo_guard_q31_state_t *state);

/// Does what tribo_guard_f32_restore does.
void tribo_guard_q31_restore(tribo_guard_q31_state_t *state);

/// Names the guard in a loop's config, as tribo_guard_f32_use does for float32.
tribo_loop_guard_t tribo_guard_q31_use(tribo_guard_q31_params_t *params, const tribo_guard_f32_config_t *config);

/// Computes `params` of a guard for a loop of your own, which calls tribo_guard_q31_step. Returns TRIBO_OK,
/// TRIBO_ERR_FULL_SCALE or a status of tribo_guard_f32_init; turn_n and stray_n are 1e-6 FS to under FS. Writes nothing
/// unless TRIBO_OK.
tribo_status_t tribo_guard_q31_init(tribo_guard_q31_params_t       *params,
                                    const tribo_guard_f32_config_t *config,
                                    float                           sample_time_s,
                                    float                           full_scale_n);

/// Does what tribo_guard_f32_step does, in Q31, with a fade in Q32. It ignores a tick in which r or y is at a limit of
/// the scale.
uint32_t tribo_guard_q31_step(const tribo_guard_q31_params_t *params,
                              tribo_guard_q31_state_t        *state,
                              int32_t                         r,
                              int32_t                         y,
                              int32_t                         f,
                              bool                            good);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

#define TRIBO_FORCE_LOOP_Q31_PARAMS_VERSION                                                                            \
    9 ///< changes with the fields of params and their meaning, for params made on a host

/// What a method tells the loop. tribo_force_loop_f32_tick_t explains the members; forces are Q31.
typedef struct
{
    int32_t e, y, term, friction;
    bool    has_e, has_y;
} tribo_force_loop_q31_tick_t;

/// A method's functions in a tick. tribo_force_loop_f32_functions_t explains them; forces are Q31.
typedef struct
{
    /// `fade` is Q32; UINT32_MAX lets all friction through.
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

/// A compensation method other than the paper's, as tribo_force_loop_f32_method_t explains.
typedef struct
{
    void (*functions)(tribo_force_loop_q31_functions_t *functions); ///< writes the method's functions
} tribo_force_loop_q31_method_t;

typedef struct
{
    int32_t position;
    int32_t sign; ///< sign of the last move; 0 before the first move
} tribo_play_q31_state_t;

/// tribo_guard_f32_state explains the members. r, y and errors are 2^-28 full scales.
struct tribo_guard_q31_state
{
    uint8_t                running, turns, strays;
    tribo_guard_cause_t    cause;
    uint32_t               fade; ///< Q32; UINT32_MAX lets all friction through
    uint32_t               since;
    int64_t                work; ///< 2^-43 full scales squared
    int32_t                high, low, r, y;
    tribo_play_q31_state_t play; ///< 2^-29 full scales
};

/// Constants of a guard, computed by tribo_guard_q31_init. Constant from then on; several loops may share them.
struct tribo_guard_q31_params
{
    /// tribo_guard_q31_step, which a loop calls through this pointer.
    uint32_t (*step)(const struct tribo_guard_q31_params *params,
                     tribo_guard_q31_state_t             *state,
                     int32_t                              r,
                     int32_t                              y,
                     int32_t                              f,
                     bool                                 good);
    uint8_t  on;          ///< 1, set by init. 0: the guard judges nothing, forgets its cause and removes its fading
    int32_t  half;        ///< 2^-29 full scales
    int32_t  stray;       ///< 2^-28 full scales
    int64_t  work;        ///< limit of hunting, 2^-43 full scales squared
    uint32_t fade_step;   ///< change of the fade in a tick, Q32
    uint32_t quick_ticks; ///< up to 2^17
};

/// Constants of a loop, computed by tribo_force_loop_q31_init. Constant from then on; several loops may share them.
struct tribo_force_loop_q31_params
{
    int32_t                              input_max; ///< largest credible |r| and |y|, Q31; at most 2^31 - 2
    int32_t                              gain;      ///< eta, Q29, 0 to 2
    tribo_controller_q31_params_t        controller;
    tribo_compensator_q31_params_t       compensator;
    const tribo_force_loop_q31_method_t *method; ///< null: the paper's method, with `compensator`
    const tribo_guard_q31_params_t      *guard;  ///< null: no guard
};

/// Everything that a tick remembers for the next. tribo_force_loop_f32_state explains the members.
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
    tribo_controller_q31_state_t         controller; ///< contains limited_ticks
    tribo_compensator_q31_state_t        compensator;
};

#ifdef __cplusplus
}
#endif

#endif
