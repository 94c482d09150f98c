/// The force loop in the arithmetic that the image is built for; tribo_arithmetic.h has its names.
///
/// DRIVE_FEEDFORWARD is 1, or 0 in an image without the feed-forward and the guard (TRIBO_DRIVE_FEEDFORWARD of
/// CMake).

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

/// Params made in the drive itself, of a config in physical units. Must not move after set-up: params point into it.
typedef struct
{
    loop_params_t params;
#if DRIVE_FEEDFORWARD
    TRIBO(feedforward, params_t) feedforward; ///< if there is one
    TRIBO(guard, params_t) guard;
#endif
#if TRIBO_IS_Q31
    tribo_point_t table[TRIBO_BREAKAWAY_POINTS_MAX];
#endif
} loop_setup_t;

/// Checks `config` and computes `setup->params`; a method or a guard that it names is to be made in `setup`. f32 ignores `full_scale_n`, and its params point to the breakaway table of
/// `config`, which must outlive them. Where it is refused, nothing of `setup` may be used. Not for the tick.
tribo_status_t loop_setup(loop_setup_t *setup, const tribo_force_loop_f32_config_t *config, float full_scale_n);

/// The loop at rest, with `memory` for a feed-forward, null: none. What is learned stays; so does what a guard has latched and faded.
void loop_begin(loop_state_t *state, const loop_params_t *params, loop_memory_t *memory);

/// Whether the loop uses y.
bool loop_has_sensor(const loop_params_t *params);

/// Widths of a reversal: float, or Q29.
typedef tribo_force_t loop_widths_t;

/// For a position that is surely reversed by `units`, from 1 on. Not for the tick.
loop_widths_t loop_widths_per_unit(uint32_t units);

/// Before a tick of a loop without a sensor: the arm shall have moved by `intended` units in it, and has by `measured`.
void loop_motion(loop_memory_t *memory, int32_t intended, int32_t measured, loop_widths_t per_unit);

/// Learns from the last sample, if there is one; nothing happens for params without a feed-forward, or without a memory.
void loop_learn(const loop_params_t *params, loop_memory_t *memory);

/// Where the learner is called: after the tick where the processor has an FPU, else in the background, which the tick interrupts.
#if defined(__SOFTFP__) || defined(__riscv_float_abi_soft)
#define LOOP_LEARNS_IN_TICK 0
#else
#define LOOP_LEARNS_IN_TICK 1
#endif

/// Nothing learned yet, for params with a feed-forward; nothing happens for others.
void loop_forget(const loop_params_t *params, loop_memory_t *memory);

#if DRIVE_FEEDFORWARD
/// In `direction` (TRIBO_BREAKAWAY_POSITIVE or _NEGATIVE) at the force `at`; zeros for params without a feed-forward.
tribo_feedforward_learned_t loop_learned(const loop_params_t *params,
                                         const loop_memory_t *memory,
                                         uint32_t             direction,
                                         loop_force_t         at);

/// The learner has a sample, and may be at work: leave what is learned alone.
bool loop_is_learning(const loop_memory_t *memory);

/// The share of friction that the guard has left in u, 0 to 1.
float loop_share(const loop_state_t *state);
#endif

#endif
