#include "support/elementary.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

// A number of twice the length: the sum of two numbers, the second far below the last bit of the first.
typedef struct
{
    double high, low;
} long_t;

/// Returns a + b exactly (Knuth).
static inline long_t add(double a, double b)
{
    const double sum  = a + b;
    const double of_b = sum - a;
    return (long_t){sum, (a - (sum - of_b)) + (b - of_b)};
}

/// Returns a b exactly (Dekker), from halves of 26 bits, whose products fit.
static inline long_t multiply(double a, double b)
{
    const double split = 134217729.0; // 2^27 + 1
    const double a_far = split * a, b_far = split * b;
    const double a_high = a_far - (a_far - a), b_high = b_far - (b_far - b);
    const double a_low = a - a_high, b_low = b - b_high;
    const double product = a * b;
    return (long_t){product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

/// Returns a / b.
static inline long_t divide(long_t a, long_t b)
{
    const double inverse  = 1.0 / b.high;
    const double quotient = a.high * inverse;
    const long_t back     = multiply(quotient, b.high);
    const double rest     = (((a.high - back.high) - back.low) + a.low) - quotient * b.low;
    return add(quotient, rest * inverse);
}

/// Returns c[0] + c[1] x + ... for a multiple of four terms, in short chains that a processor computes in parallel.
static inline double series(const double c[], int count, double x)
{
    const double square = x * x, fourth = square * square;
    double       sum = 0.0;
    for (int i = count - 4; i >= 0; i -= 4)
    {
        sum = sum * fourth + ((c[i] + c[i + 1] * x) + square * (c[i + 2] + c[i + 3] * x));
    }
    return sum;
}

#define SERIES(c, x) series(c, (int)(sizeof(c) / sizeof(c)[0]), x)

// --- exponential ---------------------------------------------------------------------------------------------------

// ln(2) in two parts; the first is exact when multiplied by a whole number of 20 bits.
#define LN2_FIRST   0x1.62e42feep-1
#define LN2_SECOND  0x1.a39ef35793c76p-33
#define LN2_INVERSE 0x1.71547652b82fep+0

#define EXP_MAX 709.782712893384     ///< largest x for which e^x is finite
#define EXP_MIN (-745.1332191019412) ///< smallest x for which e^x is not 0

/// e^x as 2^power (1 + part).
typedef struct
{
    int    power;
    long_t part;
} exponential_t;

/// Returns the whole number nearest to x, |x| < 2^31.
static inline int nearest(double x)
{
    return (int)(x + (x < 0.0 ? -0.5 : 0.5));
}

/// Returns 2^power, which must be a normal number.
static inline double power_of_2(int power)
{
    const uint64_t bits = (uint64_t)(1023 + power) << 52;
    double         value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/// Returns x 2^power, in two factors because the result may be subnormal.
static inline double scale(double x, int power)
{
    return x * power_of_2(power / 2) * power_of_2(power - power / 2);
}

/// Returns e^x for EXP_MIN <= x <= EXP_MAX. It reduces x to |r| <= ln(2)/2, then e^r - 1 = r + r^2/2 + r^3/3! + ... + r^14/14!.
static exponential_t exponential(long_t x)
{
    static const double inverse[] = {1.0 / 6.0,
                                     1.0 / 24.0,
                                     1.0 / 120.0,
                                     1.0 / 720.0,
                                     1.0 / 5040.0,
                                     1.0 / 40320.0,
                                     1.0 / 362880.0,
                                     1.0 / 3628800.0,
                                     1.0 / 39916800.0,
                                     1.0 / 479001600.0,
                                     1.0 / 6227020800.0,
                                     1.0 / 87178291200.0};

    const int    power  = nearest(x.high * LN2_INVERSE);
    const long_t r      = add(x.high - power * LN2_FIRST, x.low - power * LN2_SECOND);
    const double square = r.high * r.high;
    const long_t sum    = add(r.high, 0.5 * square);
    const double rest   = r.high * square * SERIES(inverse, r.high) + r.low * (1.0 + r.high);
    return (exponential_t){power, add(sum.high, sum.low + rest)};
}

double common_exp(double x)
{
    if (!(x >= EXP_MIN && x <= EXP_MAX))
    {
        return x > EXP_MAX ? HUGE_VAL : x < EXP_MIN ? 0.0 : x;
    }
    const exponential_t e   = exponential((long_t){x, 0.0});
    const long_t        sum = add(1.0, e.part.high);
    return scale(sum.high + (sum.low + e.part.low), e.power);
}

/// Returns e^x - 1 as a long number, for |x| <= 41.
static long_t less_one(double x)
{
    const exponential_t e    = exponential((long_t){x, 0.0});
    const long_t        rest = add(1.0, -power_of_2(-e.power));
    const long_t        sum  = add(rest.high, e.part.high);
    const long_t        all  = add(sum.high, sum.low + (rest.low + e.part.low));
    return (long_t){all.high * power_of_2(e.power), all.low * power_of_2(e.power)};
}

double common_expm1(double x)
{
    if (!(fabs(x) <= 41.0))
    {
        return x < 0.0 ? -1.0 : common_exp(x); // the smaller of e^x and 1 is below the last bit
    }
    if (fabs(x) < 0x1p-54)
    {
        return x; // keeps -0.0
    }
    const long_t e = less_one(x);
    return e.high + e.low;
}

/// Returns tanh(x) as (e^2x - 1) / (e^2x + 1).
double common_tanh(double x)
{
    if (!(fabs(x) < 19.1))
    {
        return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x;
    }
    if (fabs(x) < 0x1p-28)
    {
        return x;
    }
    const long_t e     = less_one(2.0 * x);
    const long_t above = add(2.0, e.high);
    const long_t tanh  = divide(e, (long_t){above.high, above.low + e.low});
    return tanh.high;
}

// --- logarithm and power -------------------------------------------------------------------------------------------

/// Returns ln(x) for a finite x > 0: x = 2^power m with m near 1, s = (m - 1)/(m + 1), ln(m) = 2 (s + s^3/3 + s^5/5 + ...).
static long_t logarithm(double x)
{
    static const double inverse[] = {1.0 / 3.0,
                                     1.0 / 5.0,
                                     1.0 / 7.0,
                                     1.0 / 9.0,
                                     1.0 / 11.0,
                                     1.0 / 13.0,
                                     1.0 / 15.0,
                                     1.0 / 17.0,
                                     1.0 / 19.0,
                                     1.0 / 21.0,
                                     1.0 / 23.0,
                                     1.0 / 25.0};

    int    power;
    double m = frexp(x, &power);
    if (m < 0.70710678118654752)
    {
        m *= 2.0;
        power--;
    }
    const long_t s      = divide((long_t){m - 1.0, 0.0}, add(m, 1.0));
    const double square = s.high * s.high;
    const long_t first  = add(power * LN2_FIRST, 2.0 * s.high);
    const double rest   = power * LN2_SECOND + 2.0 * (s.low + s.high * square * SERIES(inverse, square));
    return add(first.high, first.low + rest);
}

double common_log(double x)
{
    if (!(x > 0.0 && x < HUGE_VAL))
    {
        return x == 0.0 ? -HUGE_VAL : x > 0.0 ? x : (double)NAN;
    }
    const long_t ln = logarithm(x);
    return ln.high;
}

double common_pow(double x, double y)
{
    if (!(x > 0.0 && x < HUGE_VAL && fabs(y) < 1e15))
    {
        const bool grows = (x > 1.0) == (y > 0.0);
        return y == 0.0 || x == 1.0 ? 1.0 : !(x >= 0.0) || isnan(y) ? (double)NAN : grows ? HUGE_VAL : 0.0;
    }
    const long_t ln      = logarithm(x);
    const long_t product = multiply(y, ln.high);
    const long_t all     = add(product.high, product.low + y * ln.low);
    if (!(all.high >= EXP_MIN && all.high <= EXP_MAX))
    {
        return all.high > 0.0 ? HUGE_VAL : 0.0;
    }
    const exponential_t e   = exponential(all);
    const long_t        sum = add(1.0, e.part.high);
    return scale(sum.high + (sum.low + e.part.low), e.power);
}

// --- circle --------------------------------------------------------------------------------------------------------

// pi/2 in three parts; the first two are exact when multiplied by a whole number of 20 bits.
#define QUARTER_FIRST   0x1.921fb544p+0
#define QUARTER_SECOND  0x1.0b4611a6p-34
#define QUARTER_THIRD   0x1.3198a2e037073p-69
#define QUARTER_INVERSE 0x1.45f306dc9c883p-1
#define CIRCLE          0x1.921fb54442d18p+2

/// An angle x = turn pi/2 + r, |r| <= pi/4.
typedef struct
{
    unsigned quarter; ///< turn modulo 4
    long_t   r;
} angle_t;

static angle_t reduce(double x)
{
    const double near = fabs(x) <= 1e6 ? x : fmod(x, CIRCLE);
    const double turn = floor(near * QUARTER_INVERSE + 0.5);
    const long_t r    = add(near - turn * QUARTER_FIRST, -turn * QUARTER_SECOND);
    return (angle_t){(unsigned)(int)turn & 3u, add(r.high, r.low - turn * QUARTER_THIRD)};
}

static double sine(long_t r)
{
    static const double inverse[] = {-1.0 / 6.0,
                                     1.0 / 120.0,
                                     -1.0 / 5040.0,
                                     1.0 / 362880.0,
                                     -1.0 / 39916800.0,
                                     1.0 / 6227020800.0,
                                     -1.0 / 1307674368000.0,
                                     1.0 / 355687428096000.0};

    const double square = r.high * r.high;
    return r.high + (r.low * (1.0 - 0.5 * square) + r.high * square * SERIES(inverse, square));
}

static double cosine(long_t r)
{
    static const double inverse[] = {1.0 / 24.0,
                                     -1.0 / 720.0,
                                     1.0 / 40320.0,
                                     -1.0 / 3628800.0,
                                     1.0 / 479001600.0,
                                     -1.0 / 87178291200.0,
                                     1.0 / 20922789888000.0,
                                     -1.0 / 6402373705728000.0};

    const double square = r.high * r.high;
    const long_t sum    = add(1.0, -0.5 * square);
    return sum.high + (sum.low + square * square * SERIES(inverse, square) - r.high * r.low);
}

static double of_quarter(unsigned quarter, long_t r)
{
    const double value = (quarter & 1u) != 0u ? cosine(r) : sine(r);
    return (quarter & 2u) != 0u ? -value : value;
}

double common_sin(double x)
{
    if (!(fabs(x) < HUGE_VAL))
    {
        return (double)NAN;
    }
    const angle_t angle = reduce(x);
    return fabs(x) < 0x1p-27 ? x : of_quarter(angle.quarter, angle.r);
}

double common_cos(double x)
{
    if (!(fabs(x) < HUGE_VAL))
    {
        return (double)NAN;
    }
    const angle_t angle = reduce(x);
    return of_quarter(angle.quarter + 1u, angle.r);
}
