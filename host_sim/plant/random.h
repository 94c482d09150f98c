/// Random numbers that are the same on every machine: xoshiro256** seeded by splitmix64 (Blackman & Vigna, "Scrambled
/// linear pseudorandom number generators", 2018), and normal deviates by Marsaglia's polar method with our own logarithm,
/// because libm's last bit differs from machine to machine.

#ifndef SIM_RANDOM_H
#define SIM_RANDOM_H

#include <stdbool.h>
#include <stdint.h>

typedef struct
{
    uint64_t word[4];
    double   spare; ///< the polar method makes two at a time
    bool     has_spare;
} sim_random_t;

void sim_random_seed(sim_random_t *random, uint64_t seed);

uint64_t sim_random_bits(sim_random_t *random);

/// Returns a normal deviate of mean 0 and standard deviation 1.
double sim_random_normal(sim_random_t *random);

#endif
