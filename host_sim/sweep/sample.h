/// The samples of an axis as probabilities, and their values in a distribution. Each axis has its own random numbers, from the
/// study's seed and the axis's name, so that adding or removing an axis leaves the others unchanged.

#ifndef SIM_SAMPLE_H
#define SIM_SAMPLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Fills `probability[count]`, each above 0 and below 1. Monte Carlo: independent. Latin hypercube: one in each of `count` equal parts,
/// the parts in random order. False if there is no memory.
bool sim_sample(double *probability, size_t count, uint64_t seed, const char *name, bool latin);

/// The quantile of the standard normal distribution for p, and its inverse.
double sim_normal_value(double p);
double sim_normal_probability(double x);

#endif
