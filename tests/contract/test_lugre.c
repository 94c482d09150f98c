#include PARTS_HEADER
#include "lugre_paper.h"
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define H 1e-3

static tribo_lugre_f32_config_t    config;
static tribo_friction_f32_config_t law;
static tribo_arm_f32_config_t      arm_config;
static lugre_t                     lugre;
static arm_t                       arm;

static void init_at(double h)
{
    law.pulse_width_s = (float)h; // not read
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, lugre_init(&lugre, &config, &arm_config, &law, h));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, arm_init(&arm, &arm_config, h));
}

void setUp(void)
{
    config     = lugre_paper();
    arm_config = tribo_force_loop_f32_paper().compensator.arm;
    law        = tribo_force_loop_f32_paper().compensator.friction;
    init_at(H);
}

void tearDown(void)
{
}

/// One tick of module and arm, as in the compensator.
static double tick(double u)
{
    const double f = lugre_step(&lugre, u, arm_force(&arm));
    (void)arm_step(&arm, lugre_n(&lugre) - f);
    return f;
}

/// Arm and Eq. (12) by explicit Euler steps in double: bristles soft enough for steps of 20 us.
typedef struct
{
    double position, speed, z;
} reference_t;

static double reference_step(reference_t *reference, double u, double step_s)
{
    const double F  = (double)arm_config.stiffness * reference->position;
    const double L  = 0.007 + 0.3 * fabs(F);
    const double w  = reference->speed;
    const double dz = w - (double)config.stiffness * fabs(w) * reference->z / L;
    double       f = (double)config.stiffness * reference->z + (double)config.damping * dz + (double)config.viscous * w;
    f              = fmin(L, fmax(-L, f));
    reference->position += step_s * w;
    reference->speed += step_s * (u - F - (double)arm_config.damping * w - f) / (double)arm_config.inertia;
    reference->z += step_s * dz;
    return f;
}

static void test_soft_bristles_follow_the_equation(void)
{
    config.stiffness = 200.0f;
    config.damping   = 0.3f;
    config.viscous   = 0.0f;
    init_at(1.0e-4);
    reference_t reference = {0};
    double      largest   = 0.0;
    for (int k = 0; k < 20000; k++) // 2 s
    {
        const double u = 0.3 * sin(2.0 * k * 1e-4) + 0.05 * sin(9.0 * k * 1e-4);
        const double f = tick(u);
        double       g = 0.0;
        for (int i = 0; i < 5; i++)
        {
            g = reference_step(&reference, u, 2e-5);
        }
        largest = fmax(largest, fabs(f - g));
    }
    const double F = (double)arm_config.stiffness * reference.position;
    printf("f within %.5f N of Eq. (12); F %.5f, %.5f N at the end\n", largest, arm_force(&arm), F);
    TEST_ASSERT_TRUE(largest < 0.02 * 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(0.002, F, arm_force(&arm));
}

static void test_the_papers_stiffness_holds_at_1_kHz_and_slides_with_breakaway(void)
{
    double f = 0.0;
    for (int k = 0; k < 1000; k++)
    {
        f = tick(0.0069 * k / 1000.0); // below L(0)
    }
    TEST_ASSERT_DOUBLE_WITHIN(5e-6, 0.0, arm_force(&arm)); // bristles yield a little
    TEST_ASSERT_DOUBLE_WITHIN(5e-6, lugre_n(&lugre), f);
    for (int k = 0; k < 3000; k++)
    {
        f = tick(0.0069 + 0.5 * k / 3000.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.007 + 0.3 * arm_force(&arm), f);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.5069, arm_force(&arm) + f);
    // Back inside stiction F stays, once the arm has come to rest: 0.034 deg/s for I/b.
    const double stood = arm_force(&arm);
    for (int k = 0; k < 1000; k++)
    {
        (void)tick(0.5069 - 0.2 * k / 1000.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(6e-4, stood, arm_force(&arm));
}

/// One step from bristles Z and drive r at u and F, with the equations of lugre_f32.h in double.
static void check_step(double Z, double drive, double u, double F)
{
    tribo_arm_f32_params_t arm_params;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_f32_init(&arm_params, &arm_config, (float)H));
    const tribo_breakaway_f32_t *const of = u - F < 0.0 ? &law.negative : &law.positive;

    const double gamma_d = (double)arm_params.gamma_d;
    const double beta    = (double)config.damping / ((double)config.stiffness * H);
    const double c       = (double)config.stiffness * gamma_d / (double)arm_config.stiffness;
    const double b       = (double)config.viscous * gamma_d / ((double)arm_config.stiffness * H);
    const double n1      = u - F + (double)arm_params.gamma_g * drive;
    const double a       = (1.0 + beta) * c;
    const double L       = (double)of->offset_n + (double)of->slope * fabs(F);
    const double stuck   = 1.0 + fabs(n1 - Z) * c / (1.0 + a + b) / L;
    const double P       = ((1.0 + beta) / stuck - beta) * Z;
    const double r       = (n1 - P) / (1.0 + b + a / stuck);
    const double D       = 1.0 + c * fabs(r) / L;
    TEST_ASSERT_TRUE(fabs(n1 - r) < L);

    lugre_set(&lugre, Z, drive);
    TEST_ASSERT_DOUBLE_WITHIN(LUGRE_TOLERANCE_N, n1 - r, lugre_step(&lugre, u, F));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(r) + LUGRE_TOLERANCE_N / 100.0, r, lugre_drive(&lugre));
    TEST_ASSERT_DOUBLE_WITHIN(LUGRE_BRISTLE_N, (Z + c * r) / D, lugre_bristle(&lugre));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, u - F, lugre_n(&lugre));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, L, lugre_L(&lugre));
}

static void test_one_step_is_the_headers(void)
{
    check_step(0.05, 1.0e-4, 0.31, 0.25);
}

/// Downwards, with breakaway of its own.
static void test_one_step_down_takes_the_other_breakaway(void)
{
    law.negative = (tribo_breakaway_f32_t){.offset_n = 0.02f, .slope = 0.5f};
    init_at(H);
    check_step(0.01, 0.0, 0.15, 0.25);
}

static void test_directions_may_differ_and_gravity_adds(void)
{
    law.negative  = (tribo_breakaway_f32_t){.offset_n = 0.02f, .slope = 0.1f};
    law.gravity_n = 0.05f;
    init_at(H);
    const double up = lugre_step(&lugre, 0.5, 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.007 + 0.3 * 0.1, up);
    TEST_ASSERT_TRUE(lugre_L(&lugre) == up);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.45, lugre_n(&lugre));
    double down = 0.0;
    for (int k = 0; k < 5; k++)
    {
        down = lugre_step(&lugre, -0.5, 0.1);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, -(0.02 + 0.1 * 0.1), down);
    TEST_ASSERT_TRUE(lugre_L(&lugre) == -down);
}

static void test_it_is_a_mirror_image_of_itself(void)
{
    static lugre_t mirror;
    random_t       seed = {3};
    mirror              = lugre;
    for (int k = 0; k < 20000; k++)
    {
        // Some of them within the stiction of small numbers.
        const double scale = k % 3 == 0 ? 1.0 : 1e-6;
        const double u     = random_between(&seed, -0.6, 0.6) * scale;
        const double F     = random_between(&seed, -0.5, 0.5) * scale;
        const double f     = lugre_step(&lugre, u, F);
        TEST_ASSERT_TRUE(lugre_step(&mirror, -u, -F) == -f);
        TEST_ASSERT_TRUE(lugre_bristle(&mirror) == -lugre_bristle(&lugre));
        TEST_ASSERT_TRUE(fabs(f) <= lugre_L(&lugre));
    }
}

/// Friction within L, bristles within the largest L, the arm within what drives it.
static void test_it_is_stable_at_any_sample_time(void)
{
    static const double times[] = {1.0e-5, 1.0e-4, 1.0e-3, 1.0e-2};
    random_t            seed    = {5};
    for (unsigned i = 0; i < sizeof times / sizeof times[0]; i++)
    {
        if (i == 0)
        {
            config.damping = 100.0f; // beta at most 1000
        }
        init_at(times[i]);
        double largest = 0.0;
        double u       = 0.0;
        for (int k = 0; k < RUNS(20000, 5000); k++)
        {
            u              = k % 50 == 0 ? random_between(&seed, -1.0, 1.0) : u;
            const double L = 0.007 + 0.3 * fabs(arm_force(&arm));
            largest        = fmax(largest, L);
            const double f = tick(u);
            TEST_ASSERT_TRUE(fabs(f) <= L * 1.0000002 + 2e-9);
            TEST_ASSERT_TRUE(fabs(f) <= lugre_L(&lugre));
            TEST_ASSERT_TRUE(fabs(lugre_bristle(&lugre)) <= largest * 1.000001);
            TEST_ASSERT_TRUE(fabs(arm_force(&arm)) < 1.5);
        }
        config.damping = lugre_paper().damping;
    }
}

/// A table takes the law's place, point for point.
static void test_a_table_gives_breakaway_as_the_law_does(void)
{
    static const tribo_breakaway_point_f32_t points[] = {{0.0f, 0.007f, 0.007f}, {1.0f, 0.307f, 0.307f}};
    static lugre_t                           by_law;

    by_law           = lugre;
    law.table        = points;
    law.table_length = 2;
    init_at(H);
    for (int k = 0; k < 3000; k++)
    {
        const double u = 0.4 * sin(0.004 * k);
        const double f = lugre_step(&lugre, u, 0.8 * u);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, lugre_step(&by_law, u, 0.8 * u), f);
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, lugre_L(&by_law), lugre_L(&lugre));
    }
}

static void test_reset_is_at_rest(void)
{
    (void)tick(0.3);
    (void)tick(-1.9);
    lugre_reset(&lugre);
    const lugre_t fresh = lugre;
    TEST_ASSERT_TRUE(lugre_bristle(&lugre) == 0.0 && lugre_drive(&lugre) == 0.0);
    TEST_ASSERT_TRUE(lugre_step(&lugre, 0.0, 0.0) == 0.0);
    TEST_ASSERT_EQUAL_MEMORY(&fresh.state, &lugre.state, sizeof lugre.state);
}

static void check_refused(tribo_status_t status)
{
    const lugre_t before = lugre;
    TEST_ASSERT_EQUAL_INT(status, lugre_init(&lugre, &config, &arm_config, &law, H));
    TEST_ASSERT_EQUAL_MEMORY(&before.params, &lugre.params, sizeof lugre.params);
    config     = lugre_paper();
    arm_config = tribo_force_loop_f32_paper().compensator.arm;
}

static void test_init_names_the_field_that_is_wrong(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, lugre_init(&lugre, &config, &arm_config, &law, (double)NAN));
    arm_config.stiffness = 0.0f;
    check_refused(TRIBO_ERR_STIFFNESS);
    config.stiffness = NAN;
    check_refused(TRIBO_ERR_BRISTLE_STIFFNESS);
    config.stiffness = 0.0f;
    check_refused(TRIBO_ERR_BRISTLE_STIFFNESS);
    config.stiffness = 1.0e9f;
    check_refused(TRIBO_ERR_BRISTLE_STIFFNESS);
    config.damping = -1.0f;
    check_refused(TRIBO_ERR_BRISTLE_DAMPING);
    config.damping = 1.1e5f;
    check_refused(TRIBO_ERR_BRISTLE_DAMPING);
    config.viscous = -0.1f;
    check_refused(TRIBO_ERR_BRISTLE_VISCOUS);
    config.viscous = NAN;
    check_refused(TRIBO_ERR_BRISTLE_VISCOUS);
    config.viscous = 1.0e8f; // b over 1000
    check_refused(TRIBO_ERR_BRISTLE_VISCOUS);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_soft_bristles_follow_the_equation);
    RUN_TEST(test_the_papers_stiffness_holds_at_1_kHz_and_slides_with_breakaway);
    RUN_TEST(test_one_step_is_the_headers);
    RUN_TEST(test_one_step_down_takes_the_other_breakaway);
    RUN_TEST(test_directions_may_differ_and_gravity_adds);
    RUN_TEST(test_it_is_a_mirror_image_of_itself);
    RUN_TEST(test_it_is_stable_at_any_sample_time);
    RUN_TEST(test_a_table_gives_breakaway_as_the_law_does);
    RUN_TEST(test_reset_is_at_rest);
    RUN_TEST(test_init_names_the_field_that_is_wrong);
    return UNITY_END();
}
