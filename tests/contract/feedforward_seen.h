// What the feed-forward saw, in N, whatever arithmetic it ran in.

#ifndef TESTS_CONTRACT_FEEDFORWARD_SEEN_H
#define TESTS_CONTRACT_FEEDFORWARD_SEEN_H

#include <stdbool.h>
#include <stdint.h>

typedef struct
{
    double   e, lin, f, b, added, sigma;
    double   z, travel, reached;
    bool     turns;
    double   rho[2], off[2]; // of L+ and L-, in prior spreads
    double   L[2];           // weighted, at rs
    double   relative_variance[2];
    uint32_t bad;
} feedforward_seen_t;

/// What was learned of one direction.
typedef struct
{
    double L, relative_variance, travel;
    bool   at_bound;
    bool   stays_at_bound;
} feedforward_learned_t;

#endif
