// What cost.c has to know of the f32 loop.

#ifndef TESTS_TARGET_COST_F32_H
#define TESTS_TARGET_COST_F32_H

#include "tribo/force_loop_feedforward_f32.h"
#include "tribo/force_loop_guard_f32.h"
#include "tribo/force_loop_lugre_f32.h"

#include <string.h>

#define ARITH                            "f32"
#define TRIBO(noun, verb)                tribo_##noun##_f32_##verb
#define N(field)                         field##_n // of params and signals
#define ADVANCE(params, state, e, nodes) tribo_biquad_f32_advance(params, state, e, nodes, 0.0f)
#define INIT(params, config, points)     ((void)(points), tribo_force_loop_f32_init(params, config))
#define INIT_FED                         tribo_force_loop_feedforward_f32_init
#define INIT_LUGRE                       tribo_force_loop_lugre_f32_init
#define ATTACH                           tribo_force_loop_feedforward_f32_attach
#define INIT_GUARD(params, config)       tribo_guard_f32_init(params, config, 1e-3f)

typedef float                       number_t;
typedef tribo_breakaway_point_f32_t point_t;

static inline number_t number(int32_t millinewton)
{
    return (float)millinewton * 1e-3f;
}

static inline number_t number_of_bits(uint32_t bits)
{
    number_t x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t bits_of(number_t x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/// `of_65536` parts of x, of 65536.
static inline number_t part(number_t x, int32_t of_65536)
{
    return x * ((float)of_65536 * (1.0f / 65536.0f));
}

/// From x towards `target` by `of_65536` parts of the distance.
static inline number_t approach(number_t x, number_t target, int32_t of_65536)
{
    return x + part(target - x, of_65536);
}

#endif
