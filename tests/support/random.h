// Seeded random numbers, the same on every machine (splitmix64).

#ifndef TESTS_SUPPORT_RANDOM_H
#define TESTS_SUPPORT_RANDOM_H

#include <stdint.h>

typedef struct
{
    uint64_t state;
} random_t;

static inline uint64_t random_bits(random_t *r)
{
    r->state += 0x9e3779b97f4a7c15u;
    uint64_t z = r->state;
    z          = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z          = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/// Uniform over [min, max).
static inline double random_between(random_t *r, double min, double max)
{
    return min + (max - min) * ((double)(random_bits(r) >> 11) * 0x1.0p-53);
}

#endif
