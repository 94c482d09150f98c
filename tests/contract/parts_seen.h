// What the parts saw, in N, whatever arithmetic they ran in.

#ifndef TESTS_CONTRACT_PARTS_SEEN_H
#define TESTS_CONTRACT_PARTS_SEEN_H

typedef struct
{
    double friction, force, change;
} observer_seen_t;

typedef struct
{
    double L, variance, weighted; // the variance is relative to the prior's
} learning_seen_t;

#endif
