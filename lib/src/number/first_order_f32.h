// First-order low passes in single precision, x += part (input - x), and their parts from poles and time constants.

#ifndef TRIBO_NUMBER_FIRST_ORDER_F32_H
#define TRIBO_NUMBER_FIRST_ORDER_F32_H

#include "ieee_f32.h"

/// 1 - e^-x for x >= 0: the step response of a pole p after a tick h, with x = p h.
/// E is a Taylor series of x / 2^m. Then m doublings, 1 - e^-2x = E (2 - E), keep the precision of a small x.
static inline float first_order_f32_part(float x)
{
    float    small    = x;
    uint32_t doubling = 0;
    while (small > 0.25f)
    {
        small *= 0.5f;
        doubling++;
    }
    float E = 0.0f;
    for (uint32_t i = 8; i > 0u; i--)
    {
        E = (1.0f - E) * small / (float)i; // 1 - e^-x = x (1 - x/2 (1 - x/3 ( ... )))
    }
    for (; doubling > 0u; doubling--)
    {
        E = E * (2.0f - E);
    }
    return E;
}

/// h/(T + h): the part of a low pass with time constant T.
static inline float first_order_f32_lag(float time_s, float sample_time_s)
{
    return sample_time_s / (time_s + sample_time_s);
}

static inline float first_order_f32_step(float x, float input, float part)
{
    return x + part * (input - x);
}

#endif
