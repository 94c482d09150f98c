// Included before every source of native.py's build: the library's f32 source with double in place of float.
//
// An experiment inside stiction moves n by 1e-7 N in a step of 0.1 ms, a few units in the last place of a float. In float,
// v, the sign of dn/dt and so the relays would depend on rounding. The equations, their order and their approximations
// remain the library's.

#ifndef TRIBO_IDENTIFY_WIDE_H
#define TRIBO_IDENTIFY_WIDE_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define TRIBO_NUMBER_IEEE_F32_H // skips the library's ieee_f32.h

// The library computes 2^-x with the exponent field of a float. This stays so, and k is within 6e-8.
static inline uint32_t bits_f32(double x)
{
    const union
    {
        float    value;
        uint32_t bits;
    } same = {.value = (float)x};
    return same.bits;
}

static inline double from_bits_f32(uint32_t bits)
{
    const union
    {
        uint32_t bits;
        float    value;
    } same = {.bits = bits};
    return (double)same.value;
}

static inline double magnitude(double x)
{
    return fabs(x);
}

static inline bool within(double x, double min, double max)
{
    return x >= min && x <= max;
}

static inline bool exceeds(double x, double max)
{
    return !(fabs(x) <= max);
}

static inline uint32_t less(double a, double b)
{
    return a < b;
}

static inline double limit_f32(double x, double min, double max)
{
    return fmax(fmin(x, max), min);
}

static inline void count(uint32_t *counter)
{
    const uint32_t next = *counter + 1u;
    if (next != 0u)
    {
        *counter = next;
    }
}

#define float double

#endif
