/// The force loop in the arithmetic that the image is built for: single precision, or Q31 if DRIVE_ARITH_Q31 is defined.
///
/// The rest of the drive handles a force as loop_force_t and calculates with none. What depends on the arithmetic is in
/// arith_f32.h and arith_q31.h, inline:
///
///     loop_word, loop_from_word    the bits of a force, for telemetry and checksums, and back
///     loop_from_q31, loop_to_q31   a force from a fraction of `full_scale_n` in Q31, and back, saturated; not for a NaN.
///                                  In Q31 these are the force itself, without any float
///     loop_is_nan                  false in Q31
///     loop_is_credible             whether the loop accepts a reference or reading; false for a NaN
///
/// DRIVE_FEEDFORWARD is 1, or 0 in an image without the feed-forward and the guard (TRIBO_DRIVE_FEEDFORWARD of
/// CMake).

#ifndef DRIVE_LOOP_H
#define DRIVE_LOOP_H

#ifdef DRIVE_ARITH_Q31
#include "app/arith_q31.h"
#else
#include "app/arith_f32.h"
#endif

typedef LOOP(params_t) loop_params_t;
typedef LOOP(state_t) loop_state_t;
typedef LOOP(signals_t) loop_signals_t;
#if DRIVE_FEEDFORWARD
typedef FEED(params_t) loop_feedforward_params_t;
typedef FEED(memory_t) loop_memory_t;
typedef GUARD(state_t) loop_guard_state_t;

/// Of the guard beside the loop (tribo/force_loop_guard_*.h).
typedef struct
{
    bool on; ///< false: it judges nothing, and lets back what an earlier guard has faded
    GUARD(params_t) params;
} loop_guard_params_t;
#else
typedef uint8_t loop_memory_t; ///< not used
#endif

void loop_reset(loop_state_t *state);

/// After a reset: `memory` for a feed-forward, which keeps what it has learned; null: none.
void loop_attach(loop_state_t *state, loop_memory_t *memory);

/// Nothing learned yet, for params with a feed-forward; nothing happens for others.
void loop_forget(const loop_params_t *params, loop_memory_t *memory);

#if DRIVE_FEEDFORWARD
/// What a feed-forward has learned of breakaway in one direction, in physical units.
typedef struct
{
    float L_n, doubt, travel_n; ///< see tribo/feedforward_f32.h
    bool  at_bound;
} loop_learned_t;

/// In `direction` (TRIBO_BREAKAWAY_POSITIVE or _NEGATIVE) at the force `at`; zeros for params without a feed-forward.
loop_learned_t loop_learned(const loop_params_t *params,
                            const loop_memory_t *memory,
                            uint32_t             direction,
                            loop_force_t         at,
                            float                full_scale_n);
#endif

/// One tick. Cannot fail.
loop_force_t loop_step(const loop_params_t *params,
                       loop_state_t        *state,
                       loop_force_t         r,
                       loop_force_t         y,
                       loop_signals_t      *signals);

#if DRIVE_FEEDFORWARD
/// Whether what is learned has stayed at a bound, in `direction`; latched until loop_trust.
bool loop_stays_at_bound(const loop_memory_t *memory, uint32_t direction);
void loop_trust(loop_memory_t *memory);

/// It is not on, and has nothing to let back: loop_guard_watch would change nothing.
static inline bool loop_guard_rests(const loop_guard_params_t *params, const loop_guard_state_t *guard)
{
    return !params->on && guard->share == LOOP_ALL;
}

/// After a tick with `r` and `y` that gave `signals`: what the guard concludes, for the next one. Cannot fail.
void loop_guard_watch(const loop_guard_params_t *params,
                      loop_guard_state_t        *guard,
                      const loop_params_t       *loop_params,
                      loop_state_t              *loop,
                      loop_force_t               r,
                      loop_force_t               y,
                      const loop_signals_t      *signals);

/// Nothing seen and no cause.
void loop_guard_reset(loop_guard_state_t *guard);

/// Before a start: nothing seen. A cause stays latched.
void loop_guard_begin(loop_guard_state_t *guard);

/// Before `memory` is used by a loop that goes on: its share of friction is the guard's.
void loop_guard_enter(const loop_guard_state_t *guard, loop_memory_t *memory);

/// No cause any more: friction comes back within fade_time_s.
void loop_guard_restore(loop_guard_state_t *guard);

/// Why it has faded friction.
tribo_guard_cause_t loop_guard_cause(const loop_guard_state_t *guard);

/// The share of friction that is added to u, 0 to 1.
float loop_guard_share(const loop_guard_state_t *guard);
#endif

/// The limits of u.
loop_force_t loop_u_min(const loop_params_t *params);
loop_force_t loop_u_max(const loop_params_t *params);

/// The largest credible reference or reading.
loop_force_t loop_input_max(const loop_params_t *params);

/// F^, the force of the arm that the loop commands.
loop_force_t loop_f_hat(const loop_signals_t *signals);

/// A tick's signals as tribo_signal_words.h orders them.
void loop_words(const loop_signals_t *signals, uint32_t words[TRIBO_SIGNAL_WORDS]);

#endif
