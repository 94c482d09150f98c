#include "sweep/sample.h"

#include "plant/random.h"

#include <math.h>
#include <stdlib.h>

/// FNV-1a.
static uint64_t hash(const char *text)
{
    uint64_t value = 0xcbf29ce484222325u;
    for (; *text != '\0'; text++)
    {
        value = (value ^ (unsigned char)*text) * 0x100000001b3u;
    }
    return value;
}

/// Above 0 and below 1.
static double between_0_and_1(sim_random_t *random)
{
    return ldexp((double)(sim_random_bits(random) >> 12) + 0.5, -52);
}

/// Fisher and Yates.
static void shuffle(sim_random_t *random, uint32_t *order, size_t count)
{
    for (size_t i = 0; i < count; i++)
    {
        const size_t j = (size_t)(between_0_and_1(random) * (double)(i + 1));
        order[i]       = order[j];
        order[j]       = (uint32_t)i;
    }
}

bool sim_sample(double *probability, size_t count, uint64_t seed, const char *name, bool latin)
{
    sim_random_t random;
    uint32_t    *order = latin ? calloc(count, sizeof *order) : NULL;
    if (latin && order == NULL)
    {
        return false;
    }
    sim_random_seed(&random, seed ^ hash(name));
    if (latin)
    {
        shuffle(&random, order, count);
    }
    for (size_t i = 0; i < count; i++)
    {
        const double p = between_0_and_1(&random);
        probability[i] = latin ? (order[i] + p) / (double)count : p;
    }
    free(order);
    return true;
}

double sim_normal_probability(double x)
{
    return 0.5 * erfc(-x * 0.70710678118654752);
}

/// By bisection, to more digits than a study writes.
double sim_normal_value(double p)
{
    double low = -40.0, high = 40.0;
    for (int i = 0; i < 100; i++)
    {
        const double middle = 0.5 * (low + high);
        if (sim_normal_probability(middle) < p)
        {
            low = middle;
        }
        else
        {
            high = middle;
        }
    }
    return 0.5 * (low + high);
}
