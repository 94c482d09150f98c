#include "plant/random.h"

#include <math.h>

static uint64_t splitmix64(uint64_t *state)
{
    *state += 0x9E3779B97F4A7C15u;
    uint64_t z = *state;
    z          = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z          = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

void sim_random_seed(sim_random_t *random, uint64_t seed)
{
    *random = (sim_random_t){0};
    for (int i = 0; i < 4; i++)
    {
        random->word[i] = splitmix64(&seed);
    }
}

static uint64_t rotate_left(uint64_t x, unsigned count)
{
    return (x << count) | (x >> (64u - count));
}

uint64_t sim_random_bits(sim_random_t *random)
{
    uint64_t      *s      = random->word;
    const uint64_t result = rotate_left(s[1] * 5u, 7) * 9u;
    const uint64_t t      = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotate_left(s[3], 45);
    return result;
}

/// Returns a uniform number from -1 to 1.
static double even(sim_random_t *random)
{
    return ldexp((double)(sim_random_bits(random) >> 11), -52) - 1.0;
}

/// Returns ln(x) for 0 < x < 1 from exact operations only: x = m 2^e, ln(m) = 2 atanh((m - 1)/(m + 1)) as a series.
static double logarithm(double x)
{
    int    exponent;
    double m = frexp(x, &exponent);
    if (m < 0.70710678118654752)
    {
        m *= 2.0;
        exponent--;
    }
    const double s   = (m - 1.0) / (m + 1.0);
    const double s2  = s * s;
    double       sum = 0.0;
    for (int k = 21; k >= 1; k -= 2)
    {
        sum = sum * s2 + 1.0 / k;
    }
    return 2.0 * s * sum + exponent * 0.69314718055994531;
}

double sim_random_normal(sim_random_t *random)
{
    if (random->has_spare)
    {
        random->has_spare = false;
        return random->spare;
    }
    double x, y, square;
    do
    {
        x      = even(random);
        y      = even(random);
        square = x * x + y * y;
    } while (square >= 1.0 || square == 0.0);

    const double scale = sqrt(-2.0 * logarithm(square) / square);
    random->spare      = y * scale;
    random->has_spare  = true;
    return x * scale;
}
