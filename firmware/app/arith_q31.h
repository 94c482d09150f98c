/// The drive in Q31: a force is an int32_t, 2^31 being the full scale. The functions are described in loop.h.

#ifndef DRIVE_ARITH_Q31_H
#define DRIVE_ARITH_Q31_H

#include "tribo/force_loop_feedforward_q31.h"
#include "tribo/force_loop_guard_q31.h"
#include "tribo_signal_words.h"

#include <stdbool.h>
#include <stdint.h>

#define LOOP_ARITHMETIC "q31"
#define LOOP_IS_Q31     1
#define LOOP(name)      tribo_force_loop_q31_##name
#define FEED(name)      tribo_feedforward_q31_##name
#define GUARD(name)     tribo_guard_q31_##name
#define LEARNING(name)  tribo_breakaway_learning_q31_##name
#define LOOP_ATTACH     tribo_force_loop_feedforward_q31_attach
#define LOOP_GUARD      tribo_force_loop_guard_q31_watch
#define LOOP_ALL        UINT32_MAX // the share of friction without a guard
#define LOOP_N(field)   field      // a force in a struct of the library
#define LOOP_TO_WORDS   tribo_signal_words_q31

#define LEARNED_N(x, full_scale_n) ((float)(x) * ((full_scale_n) * (1.0f / 536870912.0f))) // 2^-29 full scales
#define LEARNED_DOUBT(x)           ((float)(x) * (1.0f / 2147483648.0f))

typedef int32_t loop_force_t;

static inline uint32_t loop_word(loop_force_t x)
{
    return (uint32_t)x;
}

static inline loop_force_t loop_from_word(uint32_t word)
{
    return (loop_force_t)word;
}

static inline loop_force_t loop_from_q31(int32_t x, float full_scale_n)
{
    (void)full_scale_n;
    return x;
}

static inline int32_t loop_to_q31(loop_force_t x, float full_scale_n)
{
    (void)full_scale_n;
    return x;
}

static inline bool loop_is_nan(loop_force_t x)
{
    (void)x;
    return false;
}

static inline bool loop_is_credible(const LOOP(params_t) * params, loop_force_t x)
{
    return x >= -params->input_max && x <= params->input_max;
}

#endif
