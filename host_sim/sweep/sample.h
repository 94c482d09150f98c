/// Where between 0 and 1 the samples of an axis lie, and which values of a distribution these are. Each axis has random numbers of its
/// own, from the study's seed and the axis's name, so that an axis more or less does not move the others.

#ifndef SIM_SAMPLE_H
#define SIM_SAMPLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Fills `probability[count]`, each above 0 and below 1. Monte Carlo: independent. Latin hypercube: one in each of `count` equal parts,
/// the parts in random order. False if there is no memory.
bool sim_sample(double *probability, size_t count, uint64_t seed, const char *name, bool latin);

/// The value that a standard normal deviate exceeds with 1 - p, and p of a value.
double sim_normal_value(double p);
double sim_normal_probability(double x);

#endif
