/// Wraps the force loop in the arithmetic that the image is built for; tribo_arithmetic.h has its names.
///
/// DRIVE_FEEDFORWARD is 1, or 0 in an image without the feed-forward and the guard (CMake: TRIBO_DRIVE_FEEDFORWARD).

#ifndef DRIVE_LOOP_H
#define DRIVE_LOOP_H

#include "tribo_arithmetic.h"

typedef tribo_force_t loop_force_t;
typedef TRIBO(force_loop, params_t) loop_params_t;
typedef TRIBO(force_loop, state_t) loop_state_t;
typedef TRIBO(force_loop, signals_t) loop_signals_t;
#if DRIVE_FEEDFORWARD
typedef TRIBO(feedforward, memory_t) loop_memory_t;
#else
typedef uint8_t loop_memory_t; ///< not used
#endif

/// Params that the drive itself makes from a config in physical units. Must not move after set-up, because params point into it.
typedef struct
{
    loop_params_t params;
#if DRIVE_FEEDFORWARD
    TRIBO(feedforward, params_t) feedforward; ///< used if the config names a feed-forward
    TRIBO(guard, params_t) guard;
#endif
#if TRIBO_IS_Q31
    tribo_point_t table[TRIBO_BREAKAWAY_POINTS_MAX];
#endif
} loop_setup_t;

/// Checks `config` and computes `setup->params`. Make a method or a guard that `config` names in `setup` first. In f32
/// `full_scale_n` is ignored, and the params point to the breakaway table of `config`, which must outlive them. If the
/// config is refused, do not use `setup`. Not for the tick.
tribo_status_t loop_setup(loop_setup_t *setup, const tribo_force_loop_f32_config_t *config, float full_scale_n);

/// Starts the loop at rest, with `memory` for a feed-forward; null: none. Learned values stay, and so does the fade of a guard.
void loop_begin(loop_state_t *state, const loop_params_t *params, loop_memory_t *memory);

/// Returns whether the loop uses y.
bool loop_has_sensor(const loop_params_t *params);

/// A motion in widths of a reversal: float, or Q29.
typedef tribo_force_t loop_widths_t;

/// Returns the widths of one unit of a position whose travel by `units`, 1 or more, is surely a reversal. Not for the tick.
loop_widths_t loop_widths_per_unit(uint32_t units);

/// Passes the motion of a tick, in units of the position, to a loop without a force sensor. Call it before the tick.
void loop_motion(loop_memory_t *memory, int32_t intended, int32_t measured, loop_widths_t per_unit);

/// Learns from the last sample, if there is one. Does nothing for params without a feed-forward, or without a memory.
void loop_learn(const loop_params_t *params, loop_memory_t *memory);

/// The learner is called after the tick if the processor has an FPU, otherwise in the background, which the tick interrupts.
#if defined(__SOFTFP__) || defined(__riscv_float_abi_soft)
#define LOOP_LEARNS_IN_TICK 0
#else
#define LOOP_LEARNS_IN_TICK 1
#endif

/// Forgets all learned values. Does nothing for params without a feed-forward.
void loop_forget(const loop_params_t *params, loop_memory_t *memory);

#if DRIVE_FEEDFORWARD
/// Returns the values learned in `direction` (TRIBO_BREAKAWAY_POSITIVE or _NEGATIVE) at the force `at`; zeros for params
/// without a feed-forward.
tribo_feedforward_learned_t loop_learned(const loop_params_t *params,
                                         const loop_memory_t *memory,
                                         uint32_t             direction,
                                         loop_force_t         at);

/// Returns whether the learner has a sample and may be at work; do not change learned values then.
bool loop_is_learning(const loop_memory_t *memory);

/// Returns the share of the friction compensation that the guard has left in u, 0 to 1.
float loop_share(const loop_state_t *state);
#endif

#endif
