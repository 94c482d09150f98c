// What a step saw, in N and N/s, whatever arithmetic it ran in.

#ifndef TESTS_CONTRACT_SEEN_H
#define TESTS_CONTRACT_SEEN_H

#include <stdbool.h>

typedef struct
{
    double n, L, v, f;
    bool   q1, q2, q;
} friction_seen_t;

typedef struct
{
    double          F;
    friction_seen_t friction;
} compensator_seen_t;

typedef struct
{
    double v, u;
    bool   limited;
} controller_seen_t;

typedef struct
{
    double             e, feedforward, v, u;
    bool               limited;
    compensator_seen_t compensator;
} loop_seen_t;

#endif
