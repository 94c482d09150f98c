/// The friction-compensated force loop of Fig. 9 in Q31, one call a tick.
///
/// Forces are Q31 of the full scale FS that the params were made for (quantize_q31.h); take FS at least the largest
/// force and limit. A difference r - y or a net force beyond FS saturates without harm: friction is at
/// breakaway there and u at its limit. Whatever r and y are, u is within u_min to u_max. A reference or a sensor beyond
/// input_max_n is a bad input: the tick runs with e = 0, so u coasts on the controller's state, and is counted.
/// Saturations are counted where they happen, in the states of the parts.
///
/// Retuning, as in f32: hand in a pointer to other params at any tick; u does not jump unless a new limit requires it.
/// It takes about five ticks and needs the old params once more, with their table: both may go when state.active is the
/// new pointer. All params of a loop are for one full scale, as for one sample time: the state has no notion of either.
///
/// Methods other than the paper's, and a change of method: as in f32.
///
/// No float, no heap, no division of more than 32 bits; the same bits on every target. Not synchronized.

#ifndef TRIBO_FORCE_LOOP_Q31_H
#define TRIBO_FORCE_LOOP_Q31_H

#include "tribo/compensator_q31.h"
#include "tribo/controller_q31.h"
#include "tribo/feedforward_q31.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TRIBO_FORCE_LOOP_Q31_PARAMS_VERSION 4 ///< of the params' fields and what they mean, for params made on a host

typedef struct tribo_force_loop_q31_method tribo_force_loop_q31_method_t;

/// What a tick reads, made by tribo_force_loop_q31_init. Const from then on; may be shared by loops.
typedef struct
{
    int32_t                               input_max; ///< largest credible |r| and |y|, Q31
    int32_t                               gain;      ///< eta, Q29, 0 to 2
    tribo_controller_q31_params_t         controller;
    tribo_compensator_q31_params_t        compensator;
    const tribo_force_loop_q31_method_t  *method;      ///< null: the paper's
    const tribo_feedforward_q31_params_t *feedforward; ///< of force_loop_feedforward_q31.h
    const tribo_lugre_q31_params_t       *lugre;       ///< of force_loop_lugre_q31.h
} tribo_force_loop_q31_params_t;

/// What a feed-forward keeps, attached to a loop (force_loop_feedforward_q31.h).
typedef struct
{
    tribo_feedforward_q31_state_t   state;
    tribo_feedforward_q31_signals_t signals; ///< of the last tick
} tribo_feedforward_q31_memory_t;

typedef struct
{
    const tribo_force_loop_q31_params_t *active;      ///< params of the last tick; null after a reset
    uintptr_t                            active_seal; ///< ~active, or `active` is corrupt and not followed
    tribo_feedforward_q31_memory_t      *memory;      ///< of the feed-forward; null: none
    uintptr_t                            memory_seal; ///< ~memory, likewise
    int32_t                              friction;    ///< f^ of the last tick, Q31
    uint32_t                             bad_inputs;  ///< ticks with a bad r or y since reset; stops at UINT32_MAX
    uint32_t                             saturated;   ///< errors and feedforwards clamped; stops at UINT32_MAX
    tribo_controller_q31_state_t         controller;  ///< with limited_ticks
    tribo_compensator_q31_state_t        compensator;
} tribo_force_loop_q31_state_t;

/// What one tick saw, for logging.
typedef struct
{
    int32_t                         e;           ///< error r - y, Q31
    int32_t                         feedforward; ///< what is added to v, Q31; the paper's is gain f^[k-1]
    tribo_controller_q31_signals_t  controller;  ///< controller term v, u, limited
    tribo_compensator_q31_signals_t compensator; ///< F^, n, L, rise, f^, Q1, Q2, Q
} tribo_force_loop_q31_signals_t;

/// A way to compensate friction other than the paper's.
struct tribo_force_loop_q31_method
{
    /// A whole tick, see tribo_force_loop_q31_step.
    int32_t (*step)(const tribo_force_loop_q31_params_t *params,
                    tribo_force_loop_q31_state_t        *state,
                    int32_t                              r,
                    int32_t                              y,
                    tribo_force_loop_q31_signals_t      *signals);

    /// What u would be in this tick but for its limit, within 32 bits; asked by another method that takes over in it.
    int32_t (*wanted)(const tribo_force_loop_q31_params_t *params,
                      tribo_force_loop_q31_state_t        *state,
                      int32_t                              r,
                      int32_t                              y);

    /// Hands over to the paper's method in front of the controller's step: tribo_force_loop_q31_hand_over.
    void (*hand_over)(const tribo_force_loop_q31_params_t *from,
                      const tribo_force_loop_q31_params_t *params,
                      tribo_force_loop_q31_state_t        *state,
                      int32_t                              r,
                      int32_t                              y,
                      int32_t                              e);
};

/// Everything at rest at F = 0, counters 0, no feed-forward attached.
/// Call it before the first tick: a zeroed state is not at rest (the relays would switch).
void tribo_force_loop_q31_reset(tribo_force_loop_q31_state_t *state);

/// One tick: reference `r` and measured end-point force `y` give the manipulated input u, all Q31. Cannot fail.
/// `signals` is written whole; it may be null.
int32_t tribo_force_loop_q31_step(const tribo_force_loop_q31_params_t *params,
                                  tribo_force_loop_q31_state_t        *state,
                                  int32_t                              r,
                                  int32_t                              y,
                                  tribo_force_loop_q31_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
