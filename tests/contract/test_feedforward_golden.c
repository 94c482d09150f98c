// The golden vectors of the feed-forward's double-precision reference, tick by tick: r, y, v and u are given, so no loop is
// needed and an error does not feed back.

#define FULL_SCALE_N 4.0 // of Q31, so that an input beyond input_max shows as such
#include ARITH_HEADER
#include "csv.h"
#include "runs.h"
#include "unity.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>

#define H         1e-3
#define COLUMNS   "k,r,y,v,asked,u,e,lin,f,b,sigma,z,rho_neg,off_neg,rho_pos,off_pos,L_neg,L_pos,bad"
#define POSITIVE  TRIBO_BREAKAWAY_POSITIVE
#define NEGATIVE  TRIBO_BREAKAWAY_NEGATIVE
#define INPUT_MAX 2.0
#define ROWS_MAX  RUNS(INT_MAX, 5000) // an emulated processor computes the host's bits (tests/identity, tests/lock_step)

enum
{
    K,
    R,
    Y,
    V,
    ASKED,
    U,
    E,
    LIN,
    F,
    B,
    SIGMA,
    Z,
    RHO_NEG,
    OFF_NEG,
    RHO_POS,
    OFF_POS,
    L_NEG,
    L_POS,
    BAD,
    COLUMN_COUNT
};

static const char *const shown[COLUMN_COUNT] = {[E]       = "e",
                                                [LIN]     = "lin",
                                                [F]       = "f",
                                                [B]       = "b",
                                                [SIGMA]   = "sigma",
                                                [Z]       = "z",
                                                [RHO_NEG] = "rho-",
                                                [OFF_NEG] = "off-",
                                                [RHO_POS] = "rho+",
                                                [OFF_POS] = "off+",
                                                [L_NEG]   = "L-",
                                                [L_POS]   = "L+",
                                                [BAD]     = "bad"};

void setUp(void)
{
}

void tearDown(void)
{
}

static void check(const char *name)
{
    tribo_feedforward_f32_config_t       config = tribo_feedforward_f32_default();
    const tribo_compensator_f32_config_t model  = tribo_compensator_f32_paper();
    static feedforward_t                 x;
    csv_t                                csv;
    double                               worst[COLUMN_COUNT] = {0.0};
    config.hold.gain                                         = 0.0f; // the reference has none
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, feedforward_init_scaled(&x, &config, &model, INPUT_MAX, H, 1.0));
    csv_open(&csv, name, COLUMNS);
    while (csv.rows < ROWS_MAX && csv_next(&csv))
    {
        const double *c       = csv.value;
        const bool    limited = fabs(c[U] - c[ASKED]) > 1e-8;
        (void)feedforward_before(&x, c[R], c[Y]);
        (void)feedforward_added(&x, c[V]);
        feedforward_after(&x, c[V], c[U], limited);
        const feedforward_seen_t s                   = feedforward_seen(&x);
        const double             found[COLUMN_COUNT] = {[E]       = s.e,
                                                        [LIN]     = s.lin,
                                                        [F]       = s.f,
                                                        [B]       = s.b,
                                                        [SIGMA]   = s.sigma,
                                                        [Z]       = s.z,
                                                        [RHO_NEG] = s.rho[NEGATIVE],
                                                        [OFF_NEG] = s.off[NEGATIVE],
                                                        [RHO_POS] = s.rho[POSITIVE],
                                                        [OFF_POS] = s.off[POSITIVE],
                                                        [L_NEG]   = s.L[NEGATIVE],
                                                        [L_POS]   = s.L[POSITIVE],
                                                        [BAD]     = s.bad};
        for (int i = E; i < COLUMN_COUNT; i++)
        {
            const double off = fabs(found[i] - c[i]);
            worst[i]         = off <= worst[i] ? worst[i] : off; // a NaN stays
        }
    }
    TEST_ASSERT_EQUAL_INT(RUNS(20000, ROWS_MAX), csv.rows);
    printf("%s, within:", name);
    for (int i = E; i < COLUMN_COUNT; i++)
    {
        printf(" %s %.1e", shown[i], worst[i]);
    }
    printf("\n");
    for (int i = E; i < COLUMN_COUNT; i++)
    {
        const bool   spreads = i >= RHO_NEG && i <= OFF_POS;
        const double most    = spreads ? GOLDEN_LEARNING_TOLERANCE : GOLDEN_FEEDFORWARD_TOLERANCE_N;
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(i == BAD ? 0.0 : most, 0.0, worst[i], shown[i]);
    }
}

static void test_feedforward_gives_the_golden_vectors_of_the_nominal_case(void)
{
    check("feedforward_nominal.csv");
}

static void test_feedforward_gives_the_golden_vectors_of_wrong_breakaway_and_noise(void)
{
    check("feedforward_mismatch_noise.csv");
}

static void test_feedforward_gives_the_golden_vectors_of_steps_limits_and_bad_inputs(void)
{
    check("feedforward_steps_limits_bad.csv");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_feedforward_gives_the_golden_vectors_of_the_nominal_case);
    RUN_TEST(test_feedforward_gives_the_golden_vectors_of_wrong_breakaway_and_noise);
    RUN_TEST(test_feedforward_gives_the_golden_vectors_of_steps_limits_and_bad_inputs);
    return UNITY_END();
}
