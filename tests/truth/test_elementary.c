// The elementary functions of common/support against the C library's in long double, which has eleven bits more.

#include "random.h"
#include "support/elementary.h"

#include "unity.h"

#include <float.h>
#include <math.h>

#define COUNT 100000

static random_t random_state;

void setUp(void)
{
    random_state = (random_t){1};
}

/// In units of the last place of the result.
static double error_ulp(double found, long double expected)
{
    const double size = fabs((double)expected);
    const double ulp  = size < DBL_MIN ? DBL_TRUE_MIN : nextafter(size, HUGE_VAL) - size;
    return (double)fabsl(((long double)found - expected) / (long double)ulp);
}

static double worst_of(double (*function)(double), long double (*exact)(long double), double low, double high)
{
    double worst = 0.0;
    for (int i = 0; i < COUNT; i++)
    {
        const double x = random_between(&random_state, low, high);
        worst          = fmax(worst, error_ulp(function(x), exact((long double)x)));
    }
    return worst;
}

/// Returns the worst error near 0, where sums lose digits that differences keep.
static double worst_small(double (*function)(double), long double (*exact)(long double))
{
    double worst = 0.0;
    for (int i = 0; i < COUNT; i++)
    {
        const double x = ldexp(random_between(&random_state, -1.0, 1.0), -(i % 60));
        worst          = fmax(worst, error_ulp(function(x), exact((long double)x)));
    }
    return worst;
}

static void test_long_double_is_the_better_number(void)
{
    TEST_ASSERT_GREATER_OR_EQUAL_INT(64, LDBL_MANT_DIG);
}

static void test_exp_is_within_0_9_ulp(void)
{
    TEST_ASSERT_TRUE(worst_of(common_exp, expl, -708.0, 709.7) < 0.9);
    TEST_ASSERT_TRUE(worst_small(common_exp, expl) < 0.9);
    TEST_ASSERT_TRUE(common_exp(0.0) == 1.0);
    TEST_ASSERT_TRUE(common_exp(-746.0) == 0.0 && isinf(common_exp(710.0)) && isnan(common_exp((double)NAN)));
}

static void test_expm1_is_within_0_9_ulp(void)
{
    TEST_ASSERT_TRUE(worst_of(common_expm1, expm1l, -45.0, 45.0) < 0.9);
    TEST_ASSERT_TRUE(worst_of(common_expm1, expm1l, -1.0, 1.0) < 0.9);
    TEST_ASSERT_TRUE(worst_small(common_expm1, expm1l) < 0.9);
    TEST_ASSERT_TRUE(signbit(common_expm1(-0.0)) && common_expm1(-1e9) == -1.0 && isinf(common_expm1(1e9)));
    TEST_ASSERT_TRUE(isnan(common_expm1((double)NAN)));
}

static void test_tanh_is_within_0_9_ulp(void)
{
    TEST_ASSERT_TRUE(worst_of(common_tanh, tanhl, -20.0, 20.0) < 0.9);
    TEST_ASSERT_TRUE(worst_of(common_tanh, tanhl, -1.0, 1.0) < 0.9);
    TEST_ASSERT_TRUE(worst_small(common_tanh, tanhl) < 0.9);
    TEST_ASSERT_TRUE(common_tanh(1e9) == 1.0 && common_tanh(-HUGE_VAL) == -1.0 && isnan(common_tanh((double)NAN)));
}

static void test_sin_and_cos_are_within_0_9_ulp(void)
{
    TEST_ASSERT_TRUE(worst_of(common_sin, sinl, -10.0, 10.0) < 0.9);
    TEST_ASSERT_TRUE(worst_of(common_cos, cosl, -10.0, 10.0) < 0.9);
    TEST_ASSERT_TRUE(worst_of(common_sin, sinl, -1e6, 1e6) < 0.9);
    TEST_ASSERT_TRUE(worst_of(common_cos, cosl, -1e6, 1e6) < 0.9);
    TEST_ASSERT_TRUE(worst_small(common_sin, sinl) < 0.9);
    TEST_ASSERT_TRUE(fabs(common_sin(1e300)) <= 1.0 && isnan(common_sin(HUGE_VAL)) && isnan(common_cos((double)NAN)));
}

static void test_log_is_within_0_9_ulp(void)
{
    TEST_ASSERT_TRUE(worst_of(common_log, logl, 0.5, 2.0) < 0.9);
    TEST_ASSERT_TRUE(worst_of(common_log, logl, 0.0, 1e9) < 0.9);
    TEST_ASSERT_TRUE(common_log(1.0) == 0.0 && isinf(common_log(0.0)) && isnan(common_log(-1.0)));
    TEST_ASSERT_TRUE(isinf(common_log(HUGE_VAL)) && isnan(common_log((double)NAN)));
}

static void test_pow_is_within_0_9_ulp(void)
{
    double worst = 0.0;
    for (int i = 0; i < COUNT; i++)
    {
        const double x = random_between(&random_state, 0.0, 2.0),
                     y = random_between(&random_state, -1.0, 1.0) * fmin(1e3, 10.0 / fabs(log(x)));
        worst          = fmax(worst, error_ulp(common_pow(x, y), powl((long double)x, (long double)y)));
    }
    TEST_ASSERT_TRUE(worst < 0.9);
    TEST_ASSERT_TRUE(common_pow(3.0, 2.0) == 9.0 && common_pow(0.0, 2.0) == 0.0 && common_pow(0.0, 0.0) == 1.0);
    TEST_ASSERT_TRUE(isinf(common_pow(0.0, -1.0)) && isnan(common_pow(-1.0, 2.0)) && common_pow(10.0, -400.0) == 0.0);
}

#include "runners/test_elementary.inc" // main
