// The golden vectors of an independent double-precision implementation, played through friction and compensator.

#include ARITH_HEADER
#include "csv.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define ROWS_MAX 20001
#define H        1e-3

/// Q1, Q2, Q as bits, as asked and as found.
static unsigned char asked[ROWS_MAX];
static unsigned char found[ROWS_MAX];

static unsigned char bits(bool q1, bool q2, bool q)
{
    return (unsigned char)((q1 ? 1u : 0u) | (q2 ? 2u : 0u) | (q ? 4u : 0u));
}

/// True when the bit that a[i] has, b has too within two rows of i.
static bool has_near(const unsigned char *a, const unsigned char *b, int i, int rows, unsigned bit)
{
    for (int j = i > 2 ? i - 2 : 0; j <= i + 2 && j < rows; j++)
    {
        if (((a[i] ^ b[j]) & bit) == 0u)
        {
            return true;
        }
    }
    return false;
}

static int check_switches(int rows)
{
    int differ = 0;
    for (int i = 0; i < rows; i++)
    {
        differ += asked[i] != found[i];
        for (unsigned bit = 1; bit <= 4u; bit *= 2u)
        {
            TEST_ASSERT_TRUE_MESSAGE(has_near(asked, found, i, rows, bit),
                                     "a switch came more than 2 ticks early or late");
            TEST_ASSERT_TRUE_MESSAGE(has_near(found, asked, i, rows, bit), "a switch too many");
        }
    }
    return differ;
}

static tribo_compensator_f32_config_t asymmetric_gravity(void)
{
    tribo_compensator_f32_config_t config = tribo_force_loop_f32_paper().compensator;
    config.friction.positive              = (tribo_breakaway_f32_t){.offset_n = 0.01f, .slope = 0.25f};
    config.friction.negative              = (tribo_breakaway_f32_t){.offset_n = 0.005f, .slope = 0.35f};
    config.friction.gravity_n             = 0.004f;
    return config;
}

static void check_friction(const char *name, const tribo_friction_f32_config_t *config)
{
    csv_t      csv;
    friction_t friction;
    double     worst_f = 0.0;
    double     worst_n = 0.0;
    double     worst_L = 0.0;
    double     worst_v = 0.0;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, config, H));
    csv_open(&csv, name, "u_N,F_N,n_N,L_N,v_N_per_s,Q1,Q2,Q,f_N");
    while (csv_next(&csv))
    {
        const double         *c = csv.value;
        const friction_seen_t s = friction_step(&friction, c[0], c[1]);
        const int             i = csv.rows - 1;
        asked[i]                = bits(c[5] != 0.0, c[6] != 0.0, c[7] != 0.0);
        found[i]                = bits(s.q1, s.q2, s.q);
        worst_n                 = fmax(worst_n, fabs(s.n - c[2]));
        worst_v                 = fmax(worst_v, fabs(s.v - c[4]));
        // Near n = 0 the side may differ, and L with it.
        worst_L = fmax(worst_L, fabs(c[2]) > 1e-6 ? fabs(s.L - c[3]) : 0.0);
        worst_f = fmax(worst_f, asked[i] == found[i] ? fabs(s.f - c[8]) : 0.0);
    }
    TEST_ASSERT_EQUAL_INT(12000, csv.rows);
    const int differ = check_switches(csv.rows);
    printf("%s: f within %.1e N, %d of %d rows differ in logic\n", name, worst_f, differ, csv.rows);
    TEST_ASSERT_DOUBLE_WITHIN(GOLDEN_FRICTION_TOLERANCE_N, 0.0, worst_f);
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * ROUNDING, 0.0, worst_n);
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * ROUNDING, 0.0, worst_L);
    TEST_ASSERT_DOUBLE_WITHIN(4.0 * ROUNDING / H, 0.0, worst_v);
    TEST_ASSERT_LESS_OR_EQUAL_INT(csv.rows / 100, differ);
}

static void check_compensator(const char *name, const tribo_compensator_f32_config_t *config)
{
    csv_t         csv;
    compensator_t compensator;
    double        worst_f = 0.0;
    double        worst_F = 0.0;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, compensator_init(&compensator, config, H));
    csv_open(&csv, name, "u_N,F_hat_N,Q1,Q2,Q,f_N");
    while (csv_next(&csv))
    {
        const double            *c = csv.value;
        const compensator_seen_t s = compensator_step(&compensator, c[0]);
        const int                i = csv.rows - 1;
        asked[i]                   = bits(c[2] != 0.0, c[3] != 0.0, c[4] != 0.0);
        found[i]                   = bits(s.friction.q1, s.friction.q2, s.friction.q);
        worst_F                    = fmax(worst_F, asked[i] == found[i] ? fabs(s.F - c[1]) : 0.0);
        worst_f                    = fmax(worst_f, asked[i] == found[i] ? fabs(s.friction.f - c[5]) : 0.0);
    }
    TEST_ASSERT_EQUAL_INT(20000, csv.rows);
    const int differ = check_switches(csv.rows);
    printf("%s: F^ within %.1e N, f^ within %.1e N, %d of %d rows differ in logic\n",
           name,
           worst_F,
           worst_f,
           differ,
           csv.rows);
    TEST_ASSERT_DOUBLE_WITHIN(GOLDEN_COMPENSATOR_TOLERANCE_N, 0.0, worst_F);
    TEST_ASSERT_DOUBLE_WITHIN(GOLDEN_COMPENSATOR_TOLERANCE_N, 0.0, worst_f);
    TEST_ASSERT_LESS_OR_EQUAL_INT(csv.rows / 100, differ);
}

static void test_friction_gives_the_golden_vectors_of_the_papers_parameters(void)
{
    const tribo_friction_f32_config_t config = tribo_force_loop_f32_paper().compensator.friction;
    check_friction("friction_paper.csv", &config);
}

static void test_friction_gives_the_golden_vectors_of_asymmetric_friction_with_gravity(void)
{
    const tribo_compensator_f32_config_t config = asymmetric_gravity();
    check_friction("friction_asymmetric_gravity.csv", &config.friction);
}

static void test_friction_gives_the_golden_vectors_of_k_1_1(void)
{
    tribo_friction_f32_config_t config = tribo_force_loop_f32_paper().compensator.friction;
    config.k_min                       = 1.1f;
    config.k_max                       = 1.1f;
    check_friction("friction_k1p1.csv", &config);
}

static void test_compensator_gives_the_golden_vectors_of_the_papers_parameters(void)
{
    const tribo_compensator_f32_config_t config = tribo_force_loop_f32_paper().compensator;
    check_compensator("compensator_paper.csv", &config);
}

static void test_compensator_gives_the_golden_vectors_of_asymmetric_friction_with_gravity(void)
{
    const tribo_compensator_f32_config_t config = asymmetric_gravity();
    check_compensator("compensator_asymmetric_gravity.csv", &config);
}

#include "runners/test_golden.inc" // main
