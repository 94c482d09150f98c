// What cost.c has to know of the q31 loop.

#ifndef TESTS_TARGET_COST_Q31_H
#define TESTS_TARGET_COST_Q31_H

#include "tribo/force_loop_feedforward_q31.h"
#include "tribo/force_loop_guard_q31.h"
#include "tribo/force_loop_lugre_q31.h"
#include "tribo/quantize_feedforward_q31.h"
#include "tribo/quantize_q31.h"

#include <stddef.h>

#define ARITH                            "q31"
#define TRIBO(noun, verb)                tribo_##noun##_q31_##verb
#define N(field)                         field // of params and signals
#define ADVANCE(params, state, e, nodes) ((void)(e), tribo_biquad_q31_advance(params, state, nodes, 0))
#define INIT(params, config, points)     tribo_force_loop_q31_init(params, points, config, FULL_SCALE_N, NULL)
#define INIT_FED(params, feedforward, config, feedforward_config)                                                      \
    tribo_force_loop_feedforward_q31_init(params, NULL, feedforward, config, feedforward_config, FULL_SCALE_N, NULL)
#define INIT_LUGRE(params, lugre, config, lugre_config)                                                                \
    tribo_force_loop_lugre_q31_init(params, NULL, lugre, config, lugre_config, FULL_SCALE_N, NULL)
#define ATTACH                     tribo_force_loop_feedforward_q31_attach
#define FULL_SCALE_N               2.0f
#define INIT_GUARD(params, config) tribo_guard_q31_init(params, config, 1e-3f, FULL_SCALE_N)

typedef int32_t                     number_t;
typedef tribo_breakaway_point_q31_t point_t;

static inline number_t number(int32_t millinewton)
{
    return (int32_t)((int64_t)millinewton * 2147483647 / 2000);
}

static inline number_t number_of_bits(uint32_t bits)
{
    return (int32_t)bits;
}

static inline uint32_t bits_of(number_t x)
{
    return (uint32_t)x;
}

/// `of_65536` parts of x, of 65536.
static inline number_t part(number_t x, int32_t of_65536)
{
    return (int32_t)((int64_t)x * of_65536 / 65536);
}

/// From x towards `target` by `of_65536` parts of the distance.
static inline number_t approach(number_t x, number_t target, int32_t of_65536)
{
    return (int32_t)(x + ((int64_t)target - x) * of_65536 / 65536);
}

#endif
