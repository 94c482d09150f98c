/// The friction-compensated force loop of Fig. 9, single precision: one call a tick.
///
///     y --> e = r - y --> controller --> (+ gain f^ of the last tick) --> limit --> u
///                              ^                                            |
///                              '------ anti-windup ------------------------+--> compensator --> f^
///
/// Forces are in N, u is scaled so that u = F at rest without friction. (Newton stands for whatever unit the plant was
/// identified in: N m serve as well.)
///
/// A tick is total: whatever r and y are, u is finite and within u_min_n to u_max_n. If one of them is bad (NaN,
/// infinite, beyond input_max_n) the tick runs with e = 0, so u coasts on the controller's state; it is
/// counted, and the loop goes on as before when the input does. Deciding when that is a fault is the drive's part.
///
/// Retuning: hand in a pointer to other validated params at any tick. The tick that first sees it takes the state
/// over without a bump in u, whatever has changed: cascade, gain, friction, arm (new limits hold at once). It needs
/// the old params once more and costs about three ticks: they may go when state.active is the new pointer. Params in use
/// must not be written to, nor a breakaway table that they point to, and all params of a loop are for one sample time.
///
/// Friction is compensated in the paper's way (off: gain 0), or in another one, which params.method selects and brings along: a
/// drive that does not use it does not link it. A change of params may change the method; u goes on from where it was.
///
/// A third and a fourth section, a breakaway table and a change of params are branches that cost more when they are taken;
/// docs/numbers.md says how much. No heap, no libm, no double, no globals; the same bits on every target. Not synchronized: one state, one tick.

#ifndef TRIBO_FORCE_LOOP_F32_H
#define TRIBO_FORCE_LOOP_F32_H

#include "tribo/compensator_f32.h"
#include "tribo/controller_f32.h"
#include "tribo/feedforward_f32.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct
{
    float                          sample_time_s; ///< of every tick, 1e-6 to 0.1 s
    float                          input_max_n;   ///< largest credible |r| and |y|, over 0 to 1e6 N
    float                          gain;          ///< eta, 0 to 2; 0 turns the compensation off, 1 overcompensates
    tribo_controller_f32_config_t  controller;    ///< made for the same sample time
    tribo_compensator_f32_config_t compensator;
} tribo_force_loop_f32_config_t;

#define TRIBO_FORCE_LOOP_F32_PARAMS_VERSION 4 ///< of the params' fields and what they mean, for params made on a host

typedef struct tribo_force_loop_f32_method tribo_force_loop_f32_method_t;

/// What a tick reads, made by tribo_force_loop_f32_init. Const from then on; may be shared by loops.
typedef struct
{
    float                                 input_max_n; ///< largest credible |r| and |y|
    float                                 gain;        ///< eta
    tribo_controller_f32_params_t         controller;
    tribo_compensator_f32_params_t        compensator;
    const tribo_force_loop_f32_method_t  *method;      ///< null: the paper's
    const tribo_feedforward_f32_params_t *feedforward; ///< of force_loop_feedforward_f32.h
    const tribo_lugre_f32_params_t       *lugre;       ///< of force_loop_lugre_f32.h
} tribo_force_loop_f32_params_t;

/// What a feed-forward keeps, attached to a loop (force_loop_feedforward_f32.h).
typedef struct
{
    tribo_feedforward_f32_state_t   state;
    tribo_feedforward_f32_signals_t signals; ///< of the last tick
} tribo_feedforward_f32_memory_t;

typedef struct
{
    const tribo_force_loop_f32_params_t *active;      ///< params of the last tick; null after a reset
    uintptr_t                            active_seal; ///< ~active, or `active` is corrupt and not followed
    tribo_feedforward_f32_memory_t      *memory;      ///< of the feed-forward; null: none
    uintptr_t                            memory_seal; ///< ~memory, likewise
    float                                friction_n;  ///< f^ of the last tick
    uint32_t                             bad_inputs;  ///< ticks with a bad r or y since reset; stops at UINT32_MAX
    tribo_controller_f32_state_t         controller;  ///< with limited_ticks
    tribo_compensator_f32_state_t        compensator;
} tribo_force_loop_f32_state_t;

/// What one tick saw, for logging.
typedef struct
{
    float                           e_n;           ///< error r - y
    float                           feedforward_n; ///< what is added to v; the paper's is gain f^[k-1]
    tribo_controller_f32_signals_t  controller;    ///< controller term v, u, limited
    tribo_compensator_f32_signals_t compensator;   ///< F^, n, L, v, f^, Q1, Q2, Q
} tribo_force_loop_f32_signals_t;

/// A way to compensate friction other than the paper's.
struct tribo_force_loop_f32_method
{
    /// A whole tick, see tribo_force_loop_f32_step.
    float (*step)(const tribo_force_loop_f32_params_t *params,
                  tribo_force_loop_f32_state_t        *state,
                  float                                r_n,
                  float                                y_n,
                  tribo_force_loop_f32_signals_t      *signals);

    /// What u would be in this tick but for its limit, asked by another method that takes over in it.
    float (*wanted)(const tribo_force_loop_f32_params_t *params,
                    tribo_force_loop_f32_state_t        *state,
                    float                                r_n,
                    float                                y_n);

    /// Hands over to the paper's method in front of the controller's step: tribo_force_loop_f32_hand_over.
    void (*hand_over)(const tribo_force_loop_f32_params_t *from,
                      const tribo_force_loop_f32_params_t *params,
                      tribo_force_loop_f32_state_t        *state,
                      float                                r_n,
                      float                                y_n,
                      float                                e_n);
};

/// The paper's loop: 1 ms, gain 0.85, Eqs. (7), (9), (10), the H-infinity controller of Eqs. (13), (14); u within
/// +-2 N, |r| and |y| up to 2 N.
tribo_force_loop_f32_config_t tribo_force_loop_f32_paper(void);

/// Checks `config` field by field and computes `params`. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_INPUT_MAX, TRIBO_ERR_GAIN, or what tribo_controller_f32_init and then
/// tribo_compensator_f32_init say. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_force_loop_f32_init(tribo_force_loop_f32_params_t       *params,
                                         const tribo_force_loop_f32_config_t *config);

/// Everything at rest at F = 0, counters 0, no feed-forward attached.
/// Call it before the first tick: a zeroed state is not at rest (the relays would switch).
void tribo_force_loop_f32_reset(tribo_force_loop_f32_state_t *state);

/// One tick: reference `r_n` and measured end-point force `y_n` in N give the manipulated input u in N. Cannot fail.
/// `signals` is written whole; it may be null.
float tribo_force_loop_f32_step(const tribo_force_loop_f32_params_t *params,
                                tribo_force_loop_f32_state_t        *state,
                                float                                r_n,
                                float                                y_n,
                                tribo_force_loop_f32_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
