#include "tribo/lugre_f32.h"

#include "random.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define H 1.0e-3f

static tribo_lugre_f32_config_t     config;
static tribo_friction_f32_config_t  law;
static tribo_arm_f32_config_t       arm_config;
static tribo_lugre_f32_params_t     params;
static tribo_friction_f32_params_t  friction;
static tribo_lugre_f32_state_t      state;
static tribo_friction_f32_signals_t seen;
static tribo_arm_f32_params_t       arm_params;
static tribo_arm_f32_state_t        arm;

static void init_at(float h)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_lugre_f32_init(&params, &config, &arm_config, h));
    law.pulse_width_s = h; // not read
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&friction, &law, h));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_f32_init(&arm_params, &arm_config, h));
    tribo_lugre_f32_reset(&state);
    tribo_arm_f32_reset(&arm);
}

void setUp(void)
{
    config     = tribo_lugre_f32_paper();
    arm_config = tribo_arm_f32_paper();
    law        = tribo_friction_f32_paper();
    init_at(H);
}

void tearDown(void)
{
}

/// One tick of module and arm, as in the compensator.
static float tick(float u)
{
    const float f = tribo_lugre_f32_step(&params, &friction, &state, u, arm.force_n, &seen);
    (void)tribo_arm_f32_step(&arm_params, &arm, seen.n_n - f);
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
    init_at(1.0e-4f);
    reference_t reference = {0};
    double      largest   = 0.0;
    for (int k = 0; k < 20000; k++) // 2 s
    {
        const double u = 0.3 * sin(2.0 * k * 1e-4) + 0.05 * sin(9.0 * k * 1e-4);
        const double f = (double)tick((float)u);
        double       g = 0.0;
        for (int i = 0; i < 5; i++)
        {
            g = reference_step(&reference, u, 2e-5);
        }
        largest = fmax(largest, fabs(f - g));
    }
    const double F = (double)arm_config.stiffness * reference.position;
    printf("f within %.5f N of Eq. (12); F %.5f, %.5f N at the end\n", largest, (double)arm.force_n, F);
    TEST_ASSERT_TRUE(largest < 0.02 * 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(0.002, F, (double)arm.force_n);
}

static void test_the_papers_stiffness_holds_at_1_kHz_and_slides_with_breakaway(void)
{
    for (int k = 0; k < 1000; k++)
    {
        (void)tick(0.0069f * (float)k / 1000.0f); // below L(0)
    }
    TEST_ASSERT_FLOAT_WITHIN(5e-6f, 0.0f, arm.force_n); // bristles yield a little
    TEST_ASSERT_FLOAT_WITHIN(5e-6f, seen.n_n, seen.f_n);
    for (int k = 0; k < 3000; k++)
    {
        (void)tick(0.0069f + 0.5f * (float)k / 3000.0f);
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 0.007f + 0.3f * arm.force_n, seen.f_n);
    TEST_ASSERT_FLOAT_WITHIN(2e-3f, 0.5069f, arm.force_n + seen.f_n);
    // Back inside stiction F stays, once the arm has come to rest: 0.034 deg/s for I/b.
    const float stood = arm.force_n;
    for (int k = 0; k < 1000; k++)
    {
        (void)tick(0.5069f - 0.2f * (float)k / 1000.0f);
    }
    TEST_ASSERT_FLOAT_WITHIN(6e-4f, stood, arm.force_n);
}

/// The numbers of a step as the header gives them.
static void test_one_step_is_the_headers(void)
{
    state.bristle_n = 0.05f;
    state.drive_n   = 1.0e-4f;

    const double gamma_d = (double)arm_params.gamma_d;
    const double h       = (double)H;
    const double beta    = (double)config.damping / ((double)config.stiffness * h);
    const double c       = (double)config.stiffness * gamma_d / (double)arm_config.stiffness;
    const double b       = (double)config.viscous * gamma_d / ((double)arm_config.stiffness * h);
    const double n1      = 0.31 - 0.25 + (double)arm_params.gamma_g * 1e-4;
    const double a       = (1.0 + beta) * c;
    const double L       = 0.007 + 0.3 * 0.25;
    const double stuck   = 1.0 + (n1 - 0.05) * c / (1.0 + a + b) / L;
    const double P       = ((1.0 + beta) / stuck - beta) * 0.05;
    const double r       = (n1 - P) / (1.0 + b + a / stuck);
    const double D       = 1.0 + c * r / L;

    TEST_ASSERT_FLOAT_WITHIN(1e-6f,
                             (float)(n1 - r),
                             tribo_lugre_f32_step(&params, &friction, &state, 0.31f, 0.25f, &seen));
    TEST_ASSERT_TRUE(n1 - r < L);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f * (float)r, (float)r, state.drive_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, (float)((0.05 + c * r) / D), state.bristle_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.06f, seen.n_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, (float)L, seen.L_n);
}

/// The other way, with breakaway of its own.
static void test_one_step_down_takes_the_other_breakaway(void)
{
    law.negative = (tribo_breakaway_f32_t){.offset_n = 0.02f, .slope = 0.5f};
    init_at(H);
    state.bristle_n = 0.01f;

    const double gamma_d = (double)arm_params.gamma_d;
    const double beta    = (double)config.damping / ((double)config.stiffness * (double)H);
    const double c       = (double)config.stiffness * gamma_d / (double)arm_config.stiffness;
    const double b       = (double)config.viscous * gamma_d / ((double)arm_config.stiffness * (double)H);
    const double n       = 0.15 - 0.25;
    const double a       = (1.0 + beta) * c;
    const double L       = 0.02 + 0.5 * 0.25;
    const double stuck   = 1.0 + (0.01 - n) * c / (1.0 + a + b) / L;
    const double P       = ((1.0 + beta) / stuck - beta) * 0.01;
    const double r       = (n - P) / (1.0 + b + a / stuck);
    TEST_ASSERT_TRUE(r < 0.0 && r - n < L);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f,
                             (float)(n - r),
                             tribo_lugre_f32_step(&params, &friction, &state, 0.15f, 0.25f, &seen));
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, (float)((0.01 + c * r) / (1.0 - c * r / L)), state.bristle_n);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, (float)L, seen.L_n);
}

static void test_directions_may_differ_and_gravity_adds(void)
{
    law.negative  = (tribo_breakaway_f32_t){.offset_n = 0.02f, .slope = 0.1f};
    law.gravity_n = 0.05f;
    init_at(H);
    TEST_ASSERT_EQUAL_FLOAT(0.007f + 0.3f * 0.1f, tribo_lugre_f32_step(&params, &friction, &state, 0.5f, 0.1f, &seen));
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.45f, seen.n_n);
    TEST_ASSERT_EQUAL_FLOAT(0.007f + 0.3f * 0.1f, seen.L_n);
    for (int k = 0; k < 5; k++)
    {
        (void)tribo_lugre_f32_step(&params, &friction, &state, -0.5f, 0.1f, &seen);
    }
    TEST_ASSERT_EQUAL_FLOAT(-(0.02f + 0.1f * 0.1f), seen.f_n);
    TEST_ASSERT_EQUAL_FLOAT(0.02f + 0.1f * 0.1f, seen.L_n);
}

static void test_it_is_a_mirror_image_of_itself(void)
{
    tribo_lugre_f32_state_t      mirror = state;
    tribo_friction_f32_signals_t other;
    random_t                     seed = {3};
    for (int k = 0; k < 5000; k++)
    {
        const float u = (float)random_between(&seed, -0.6, 0.6);
        const float F = (float)random_between(&seed, -0.5, 0.5);
        const float f = tribo_lugre_f32_step(&params, &friction, &state, u, F, &seen);
        TEST_ASSERT_TRUE(f == -tribo_lugre_f32_step(&params, &friction, &mirror, -u, -F, &other));
        TEST_ASSERT_TRUE(state.bristle_n == -mirror.bristle_n);
    }
}

/// Any input, any sample time: friction within L, bristles within the largest L, the arm within what drives it.
static void test_it_is_stable_at_any_sample_time(void)
{
    static const float times[] = {1.0e-5f, 1.0e-4f, 1.0e-3f, 1.0e-2f};
    random_t           seed    = {5};
    for (unsigned i = 0; i < sizeof times / sizeof times[0]; i++)
    {
        if (i == 0)
        {
            config.damping = 100.0f; // beta at most 1000
        }
        init_at(times[i]);
        float largest = 0.0f;
        float u       = 0.0f;
        for (int k = 0; k < 20000; k++)
        {
            u             = k % 50 == 0 ? (float)random_between(&seed, -1.0, 1.0) : u;
            const float L = 0.007f + 0.3f * fabsf(arm.force_n);
            largest       = fmaxf(largest, L);
            const float f = tick(u);
            TEST_ASSERT_TRUE(fabsf(f) <= L);
            TEST_ASSERT_TRUE(fabsf(state.bristle_n) <= largest * 1.000001f);
            TEST_ASSERT_TRUE(fabsf(arm.force_n) < 1.5f);
        }
        config.damping = tribo_lugre_f32_paper().damping;
    }
}

static void test_a_bad_input_leaves_the_net_force_and_is_counted(void)
{
    (void)tribo_lugre_f32_step(&params, &friction, &state, 0.105f, 0.1f, &seen);
    const float n = seen.n_n;
    (void)tribo_lugre_f32_step(&params, &friction, &state, NAN, 0.1f, &seen);
    TEST_ASSERT_EQUAL_FLOAT(n, seen.n_n);
    TEST_ASSERT_EQUAL_FLOAT(0.037f, seen.L_n);
    (void)tribo_lugre_f32_step(&params, &friction, &state, -2.0e6f, 0.1f, &seen);
    TEST_ASSERT_EQUAL_FLOAT(n, seen.n_n);
    (void)tribo_lugre_f32_step(&params, &friction, &state, 0.1f, INFINITY, &seen);
    TEST_ASSERT_EQUAL_FLOAT(n, seen.n_n);
    TEST_ASSERT_EQUAL_FLOAT(0.007f, seen.L_n);
    TEST_ASSERT_EQUAL_UINT32(3, state.bad_inputs);
    TEST_ASSERT_TRUE(isfinite(seen.f_n) && isfinite(state.bristle_n));
}

/// A table takes the law's place, point for point.
static void test_a_table_gives_breakaway_as_the_law_does(void)
{
    static const tribo_breakaway_point_f32_t points[] = {{0.0f, 0.007f, 0.007f}, {1.0f, 0.307f, 0.307f}};

    const tribo_friction_f32_params_t by_law  = friction;
    tribo_lugre_f32_state_t           other   = state;
    tribo_friction_f32_signals_t      another = {.n_n = 0.0f};
    law.table                                 = points;
    law.table_length                          = 2;
    init_at(H);
    for (int k = 0; k < 3000; k++)
    {
        const float u = 0.4f * sinf(0.004f * (float)k);
        const float F = 0.8f * u;
        const float f = tribo_lugre_f32_step(&params, &friction, &state, u, F, &seen);
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, tribo_lugre_f32_step(&params, &by_law, &other, u, F, &another), f);
        TEST_ASSERT_FLOAT_WITHIN(1e-7f, another.L_n, seen.L_n);
    }
}

/// Of no step, but of a flipped bit.
static void test_a_corrupt_state_starts_again_from_rest(void)
{
    static const float corrupt[] = {NAN, INFINITY, -INFINITY, 1.0e30f, -3.0e38f};
    for (unsigned i = 0; i < 2u * sizeof corrupt / sizeof corrupt[0]; i++)
    {
        tribo_lugre_f32_reset(&state);
        *(i % 2u != 0u ? &state.bristle_n : &state.drive_n) = corrupt[i / 2u];
        const float f = tribo_lugre_f32_step(&params, &friction, &state, 0.105f, 0.1f, &seen);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, f);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, state.bristle_n);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, state.drive_n);
        (void)tribo_lugre_f32_step(&params, &friction, &state, 0.105f, 0.1f, &seen);
        TEST_ASSERT_FLOAT_WITHIN(1e-3f, 0.005f, seen.f_n);
    }
}

static void test_reset_is_at_rest(void)
{
    (void)tick(0.3f);
    (void)tick(NAN);
    tribo_lugre_f32_reset(&state);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, state.bristle_n);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, state.drive_n);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, state.n_n);
    TEST_ASSERT_EQUAL_UINT32(0, state.bad_inputs);
}

static void expect(tribo_status_t status)
{
    tribo_lugre_f32_params_t before;
    memset(&before, 0x5a, sizeof before);
    params = before;
    TEST_ASSERT_EQUAL_INT(status, tribo_lugre_f32_init(&params, &config, &arm_config, H));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof before);
    config     = tribo_lugre_f32_paper();
    arm_config = tribo_arm_f32_paper();
}

static void test_init_names_the_field_that_is_wrong(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_lugre_f32_init(NULL, &config, &arm_config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_lugre_f32_init(&params, NULL, &arm_config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_lugre_f32_init(&params, &config, NULL, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SAMPLE_TIME, tribo_lugre_f32_init(&params, &config, &arm_config, NAN));
    arm_config.stiffness = 0.0f;
    expect(TRIBO_ERR_STIFFNESS);
    config.stiffness = NAN;
    expect(TRIBO_ERR_BRISTLE_STIFFNESS);
    config.stiffness = 0.0f;
    expect(TRIBO_ERR_BRISTLE_STIFFNESS);
    config.stiffness = 1.0e9f;
    expect(TRIBO_ERR_BRISTLE_STIFFNESS);
    config.damping = -1.0f;
    expect(TRIBO_ERR_BRISTLE_DAMPING);
    config.damping = 1.1e5f;
    expect(TRIBO_ERR_BRISTLE_DAMPING);
    config.viscous = -0.1f;
    expect(TRIBO_ERR_BRISTLE_VISCOUS);
    config.viscous = NAN;
    expect(TRIBO_ERR_BRISTLE_VISCOUS);
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
    RUN_TEST(test_a_bad_input_leaves_the_net_force_and_is_counted);
    RUN_TEST(test_a_table_gives_breakaway_as_the_law_does);
    RUN_TEST(test_a_corrupt_state_starts_again_from_rest);
    RUN_TEST(test_reset_is_at_rest);
    RUN_TEST(test_init_names_the_field_that_is_wrong);
    return UNITY_END();
}
