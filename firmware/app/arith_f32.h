/// The drive in single precision: a force is a float in N. The functions are described in loop.h.

#ifndef DRIVE_ARITH_F32_H
#define DRIVE_ARITH_F32_H

#include "tribo/force_loop_feedforward_f32.h"
#include "tribo/force_loop_guard_f32.h"
#include "tribo_signal_words.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#define LOOP_ARITHMETIC "f32"
#define LOOP_IS_Q31     0
#define LOOP(name)      tribo_force_loop_f32_##name
#define FEED(name)      tribo_feedforward_f32_##name
#define GUARD(name)     tribo_guard_f32_##name
#define LEARNING(name)  tribo_breakaway_learning_f32_##name
#define LOOP_ATTACH     tribo_force_loop_feedforward_f32_attach
#define LOOP_GUARD      tribo_force_loop_guard_f32_watch
#define LOOP_ALL        1.0f      // the share of friction without a guard
#define LOOP_N(field)   field##_n // a force in a struct of the library
#define LOOP_TO_WORDS   tribo_signal_words_f32

#define LEARNED_N(x, full_scale_n) ((void)(full_scale_n), (x))
#define LEARNED_DOUBT(x)           (x)

typedef float loop_force_t;

static inline uint32_t loop_word(loop_force_t x)
{
    uint32_t word;
    memcpy(&word, &x, sizeof word);
    return word;
}

static inline loop_force_t loop_from_word(uint32_t word)
{
    loop_force_t x;
    memcpy(&x, &word, sizeof x);
    return x;
}

static inline loop_force_t loop_from_q31(int32_t x, float full_scale_n)
{
    return (float)x * (full_scale_n * (1.0f / 2147483648.0f));
}

static inline int32_t loop_to_q31(loop_force_t x, float full_scale_n)
{
    const float scaled = x / full_scale_n * 2147483648.0f;
    return scaled >= 2147483648.0f ? INT32_MAX : scaled <= -2147483648.0f ? INT32_MIN : (int32_t)scaled;
}

static inline bool loop_is_nan(loop_force_t x)
{
    return (loop_word(x) & 0x7fffffffu) > 0x7f800000u;
}

static inline bool loop_is_credible(const LOOP(params_t) * params, loop_force_t x)
{
    return x >= -params->input_max_n && x <= params->input_max_n; // not for a NaN
}

#endif
