/// The force loop in the arithmetic that the image is built for: single precision, or Q31 with DRIVE_ARITH_Q31 defined.
///
/// The rest of the drive handles a force as loop_force_t and looks at it only through the functions here.

#ifndef DRIVE_LOOP_H
#define DRIVE_LOOP_H

#include "tribo/force_loop_f32.h"
#include "tribo/force_loop_q31.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef DRIVE_ARITH_Q31
typedef int32_t                        loop_force_t; ///< Q31 of the full scale
typedef tribo_force_loop_q31_params_t  loop_params_t;
typedef tribo_force_loop_q31_state_t   loop_state_t;
typedef tribo_force_loop_q31_signals_t loop_signals_t;
#else
typedef float                          loop_force_t; ///< N
typedef tribo_force_loop_f32_params_t  loop_params_t;
typedef tribo_force_loop_f32_state_t   loop_state_t;
typedef tribo_force_loop_f32_signals_t loop_signals_t;
#endif

/// One tick as 32-bit words, the same places in both arithmetics: forces as their bits.
typedef enum
{
    LOOP_WORD_BITS, ///< 1 limited, 2 Q1, 4 Q2, 8 Q
    LOOP_WORD_E,
    LOOP_WORD_CONTROLLER,
    LOOP_WORD_FEEDFORWARD,
    LOOP_WORD_U,
    LOOP_WORD_F_HAT,
    LOOP_WORD_N,
    LOOP_WORD_L,
    LOOP_WORD_RATE, ///< v in f32; v h, the rise in a tick, in q31
    LOOP_WORD_FRICTION,
    LOOP_WORDS
} loop_word_t;

/// "f32" or "q31".
const char *loop_arithmetic(void);

void loop_reset(loop_state_t *state);

/// One tick. Cannot fail.
loop_force_t loop_step(const loop_params_t *params,
                       loop_state_t        *state,
                       loop_force_t         r,
                       loop_force_t         y,
                       loop_signals_t      *signals);

/// A force of a part of `full_scale_n`, which is Q31. Without any float in q31, where it is the force itself.
loop_force_t loop_force(int32_t part, float full_scale_n);

/// And back: the force as a part of full scale, which is where it ends. Not for a NaN.
int32_t loop_part(loop_force_t x, float full_scale_n);

bool loop_is_nan(loop_force_t x);

/// Whether the loop takes x for a good reference or reading; false for NaN.
bool loop_is_credible(const loop_params_t *params, loop_force_t x);

/// The limits of u.
loop_force_t loop_u_min(const loop_params_t *params);
loop_force_t loop_u_max(const loop_params_t *params);

/// The bits of a force, for telemetry and checksums, and back.
uint32_t     loop_word(loop_force_t x);
loop_force_t loop_from_word(uint32_t word);

/// Whether the last tick's u stood at a limit.
bool loop_is_limited(const loop_signals_t *signals);

void loop_words(const loop_signals_t *signals, uint32_t words[LOOP_WORDS]);

uint32_t loop_limited_ticks(const loop_state_t *state);
uint32_t loop_bad_inputs(const loop_state_t *state);

#endif
