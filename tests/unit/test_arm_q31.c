// What only the Q31 arithmetic has. What both promise: tests/contract/test_arm.c.

#include "tribo/force_loop_f32.h"

#include "friction/arm_f32.h"
#include "friction/arm_q31.h"

#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define H 1.0e-3f

static tribo_arm_f32_config_t config;
static tribo_arm_q31_params_t params;
static tribo_arm_q31_state_t  state;

static int32_t step(int32_t drive)
{
    tribo_arm_q31_step(&params, &state, drive);
    return tribo_arm_q31_force(&state);
}

static void init(float h)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_q31_init(&params, &config, h));
    tribo_arm_q31_reset(&state);
}

void setUp(void)
{
    config = tribo_force_loop_f32_paper().compensator.arm;
    init(H);
}

/// The end of the range on the side of `sign`.
static int32_t end_of(int sign)
{
    return sign < 0 ? -INT32_MAX : INT32_MAX;
}

/// Computes the same arm in double, from the quantised numbers.
typedef struct
{
    double F, G;
} exact_t;

static void exact_step(exact_t *x, double d)
{
    const double unit = 1.0 / 268435456.0;
    const double G    = x->G;
    x->F += ldexp((params.phi_d * d + params.phi_g * G) * unit, -params.shift);
    x->G = (params.gamma_d * d + params.gamma_g * G) * unit;
}

static void test_arm_has_the_coefficients_of_its_twin(void)
{
    tribo_arm_f32_params_t twin;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_f32_init(&twin, &config, H));
    const double unit = ldexp(1.0, -28);
    TEST_ASSERT_DOUBLE_WITHIN(unit, (double)twin.phi_d, ldexp(params.phi_d * unit, -params.shift));
    TEST_ASSERT_DOUBLE_WITHIN(unit, (double)twin.phi_g, params.phi_g * unit);
    TEST_ASSERT_DOUBLE_WITHIN(unit, (double)twin.gamma_d, ldexp(params.gamma_d * unit, -params.shift));
    TEST_ASSERT_DOUBLE_WITHIN(unit, (double)twin.gamma_g, params.gamma_g * unit);
}

static void test_arm_follows_its_equation_to_a_few_bits(void)
{
    exact_t  x = {0.0, 0.0};
    random_t r = {5};
    int32_t  u = 0;
    for (int k = 0; k < 20000; k++)
    {
        u               = k % 50 == 0 ? (int32_t)random_between(&r, -5e8, 5e8) : u;
        const int32_t d = u - tribo_arm_q31_force(&state);
        exact_step(&x, (double)d);
        const int32_t F = step(d);
        TEST_ASSERT_DOUBLE_WITHIN(64.0, x.F, (double)F);
        TEST_ASSERT_EQUAL_INT32(F, tribo_arm_q31_force(&state));
        x.F = ldexp((double)state.force, -28);
        x.G = (double)state.force_change;
    }
    TEST_ASSERT_EQUAL_UINT32(0, state.saturated);
}

// 2^-33 of full scale a tick.
static void test_arm_loses_nothing_of_a_slow_push(void)
{
    for (int32_t d = -1; d <= 1; d += 2)
    {
        int64_t sum = 0;
        tribo_arm_q31_reset(&state);
        for (int k = 0; k < 50000; k++)
        {
            sum += tribo_q31_shift_to_zero(params.phi_d * (int64_t)d + params.phi_g * (int64_t)state.force_change,
                                           params.shift);
            (void)step(d);
        }
        TEST_ASSERT_EQUAL_INT64(sum, state.force);
        TEST_ASSERT_TRUE(state.force * d > 0);
    }
}

static void test_arm_saturates_at_full_scale_and_counts(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        tribo_arm_q31_reset(&state);
        for (int k = 0; k < 1000; k++)
        {
            (void)step(end_of(sign));
        }
        TEST_ASSERT_EQUAL_INT32(end_of(sign), tribo_arm_q31_force(&state));
        TEST_ASSERT_TRUE(state.saturated > 100u);
        for (int k = 0; k < 1000; k++)
        {
            (void)step(-tribo_arm_q31_force(&state));
        }
        TEST_ASSERT_INT32_WITHIN(64, 0, tribo_arm_q31_force(&state));
    }
    state.saturated = UINT32_MAX;
    state.force     = INT64_C(1) << 59;
    (void)step(INT32_MAX);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, state.saturated);
}

// --- set-up ------------------------------------------------------------------------------------------------------

static void check_refused(tribo_status_t status, float h)
{
    tribo_arm_q31_params_t out;
    memset(&out, 0xa5, sizeof out);
    TEST_ASSERT_EQUAL_INT(status, tribo_arm_q31_init(&out, &config, h));
    TEST_ASSERT_EACH_EQUAL_HEX8(0xa5, &out, sizeof out);
}

static void test_arm_init_takes_no_null(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_arm_q31_init(NULL, &config, H));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_arm_q31_init(&params, NULL, H));
}

static void test_arm_init_refuses_what_it_cannot_hold_or_what_never_rests(void)
{
    config.stiffness = 120.0f; // K h^2/I = 1, fast: allowed
    init(H);
    config.damping = 0.0f;
    check_refused(TRIBO_ERR_DAMPING, H);
    // G changes by up to K h^2/I a tick; beyond 4 of it does not fit.
    config = (tribo_arm_f32_config_t){.inertia = 1.0f, .damping = 2.0e2f, .stiffness = 2.3e7f}; // gamma_d -4.3
    check_refused(TRIBO_ERR_ARM_TOO_FAST, H);
}

// From an undamped arm of two samples a period, whose gamma_d is negative, to slower ones.
static void test_arm_init_leaves_room_for_the_sum_of_its_products(void)
{
    int fast = 0;
    for (float stiffness = 1.0e6f; stiffness < 2.0e7f; stiffness *= 1.02f)
    {
        config = (tribo_arm_f32_config_t){.inertia = 1.0f, .damping = 1.0f, .stiffness = stiffness};
        if (tribo_arm_q31_init(&params, &config, H) == TRIBO_OK)
        {
            TEST_ASSERT_TRUE(ldexp(abs(params.phi_d), -28) + ldexp(abs(params.phi_g), -28) < 4.0);
            fast += params.gamma_d < 0;
        }
    }
    TEST_ASSERT_TRUE(fast > 10);
    config = (tribo_arm_f32_config_t){.inertia = 1.0f, .damping = 0.1f, .stiffness = 9.55595e6f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_q31_init(&params, &config, H));
    TEST_ASSERT_EQUAL_INT(0, params.shift);
    config = (tribo_arm_f32_config_t){.inertia = 1.0f, .damping = 1.0e6f, .stiffness = 1.0e-3f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_q31_init(&params, &config, H));
    TEST_ASSERT_EQUAL_INT(15, params.shift); // and no further
}

// A drive pushes such an arm by 1e-9 a tick; its conditions for stability differ by as little.
static void test_arm_init_takes_an_arm_as_slow_as_its_twin_does(void)
{
    for (float stiffness = 1.1e-3f; stiffness < 1.0f; stiffness *= 1.7f)
    {
        config = (tribo_arm_f32_config_t){.inertia = 1.0f, .damping = 1.0f, .stiffness = stiffness};
        init(H);
        config.damping = 1.0e-2f;
        init(H);
    }
}

static void test_arm_init_accepts_exactly_what_is_stable(void)
{
    random_t r        = {11};
    int      accepted = 0;
    for (int i = 0; i < 2000; i++)
    {
        config = (tribo_arm_f32_config_t){.inertia   = 1.0f,
                                          .damping   = (float)pow(10.0, random_between(&r, -1.0, 4.0)),
                                          .stiffness = (float)pow(10.0, random_between(&r, -2.0, 7.0))};
        if (tribo_arm_q31_init(&params, &config, H) != TRIBO_OK)
        {
            continue;
        }
        accepted++;
        const double one    = ldexp(1.0, 28);
        const double phi_d  = ldexp(params.phi_d / one, -params.shift);
        const double gg     = params.gamma_g / one;
        const double trace  = 1.0 - phi_d + gg;
        const double det    = (1.0 - phi_d) * gg + params.phi_g / one * ldexp(params.gamma_d / one, -params.shift);
        const double inside = fmin(1.0 - det, fmin(1.0 + det - trace, 1.0 + det + trace));
        TEST_ASSERT_TRUE(inside > 0.0);
    }
    TEST_ASSERT_TRUE(accepted > 1000);
}

/// Jury's conditions on the quantised numbers, in integers: true when the arm that moves under a constant force, and G alone
/// when it sticks, die away.
static bool dies_away(const tribo_arm_q31_params_t *p)
{
    // F' = (1 - phi_d 2^-s) F + phi_g 2^-s G, G' = -gamma_d F + gamma_g G: over 2^28, and what couples them over 2^(56 + s).
    const int64_t one        = INT64_C(1) << 28;
    const double  coupling   = ldexp((double)((int64_t)p->phi_g * p->gamma_d), -56 - p->shift);
    const double  force_rest = ldexp(p->phi_d, -28 - p->shift); // what F loses a tick
    const double  speed_rest = ldexp((double)(one - p->gamma_g), -28);
    const double  at_1       = force_rest * speed_rest + coupling;
    const double  radius     = force_rest + speed_rest - force_rest * speed_rest - coupling; // 1 - determinant
    const double  at_minus_1 = (2.0 - force_rest) * (2.0 - speed_rest) + coupling;
    return at_1 > 0.0 && radius > 0.0 && at_minus_1 > 0.0 && llabs(p->gamma_g) < one;
}

// Arms at the edge of stability: undamped, critically damped, of a multiple of half a period a tick, slow.
static void test_arm_init_never_accepts_what_does_not_die_away(void)
{
    random_t r          = {12};
    int      counts[3]  = {0, 0, 0}; // accepted, too fast, not stable
    int      at_minus_1 = 0;
    for (int i = 0; i < RUNS(20000, 2000); i++)
    {
        const double near  = random_between(&r, -1.0, 1.0) * pow(10.0, random_between(&r, -7.0, -1.0));
        const double half  = acos(-1.0) * (1.0 + i % 6) * (1.0 + near);
        const double omega = i % 3 == 0 ? half : pow(10.0, random_between(&r, -4.6, 2.0));
        const double loss  = pow(10.0, random_between(&r, -9.5, 1.0));
        const double b     = i % 5 == 0 ? 0.0 : (i % 7 == 0 ? 2.0 * omega * (1.0 + 1e-3 * near) : loss);

        config = (tribo_arm_f32_config_t){.inertia   = 1.0f,
                                          .damping   = (float)(b / (double)H),
                                          .stiffness = (float)(omega * omega / (double)H / (double)H)};
        tribo_arm_f32_params_t twin;
        if (tribo_arm_f32_init(&twin, &config, H) != TRIBO_OK)
        {
            continue;
        }
        at_minus_1 += twin.gamma_g == -1.0f;
        const tribo_status_t status = tribo_arm_q31_init(&params, &config, H);
        counts[status == TRIBO_OK ? 0 : (status == TRIBO_ERR_ARM_TOO_FAST ? 1 : 2)]++;
        TEST_ASSERT_TRUE(status == TRIBO_OK || status == TRIBO_ERR_ARM_TOO_FAST || status == TRIBO_ERR_DAMPING);
        TEST_ASSERT_TRUE(status != TRIBO_OK || dies_away(&params));
        // Refused for its damping is only what rounding to float and to Q28 may have made undamped.
        TEST_ASSERT_TRUE(status != TRIBO_ERR_DAMPING || b < 3e-7 * (1.0 + omega));
    }
    TEST_ASSERT_TRUE(counts[0] > RUNS(5000, 500) && counts[1] > RUNS(50, 5) && counts[2] > RUNS(1000, 100));
    TEST_ASSERT_TRUE(at_minus_1 > RUNS(50, 5)); // where one of the conditions is 0 to the last bit
    // The determinant is a bit below 1.
    config = (tribo_arm_f32_config_t){.inertia = 1.0f, .damping = 1.61815806e-05f, .stiffness = 359446.656f};
    init(H);
}

// gamma_g is 1 in float: nothing slows the arm down when it sticks.
static void test_arm_init_refuses_what_rounds_to_no_damping(void)
{
    config = (tribo_arm_f32_config_t){.inertia = 1.0f, .damping = 1.0e-6f, .stiffness = 2.0e-3f};
    check_refused(TRIBO_ERR_DAMPING, H);
}

// With 2^s in them, the coefficients of the drive have all the bits that they can have.
static void test_arm_init_takes_the_largest_shift_that_fits(void)
{
    int shifts[16] = {0};
    int by_phi     = 0;
    for (float damping = 0.1f; damping < 3.0e3f; damping *= 9.0f)
    {
        for (float stiffness = 1.1e-3f; stiffness < 4.0e7f; stiffness *= RUNS(1.01f, 1.03f))
        {
            config = (tribo_arm_f32_config_t){.inertia = 1.0f, .damping = damping, .stiffness = stiffness};
            tribo_arm_f32_params_t twin;
            TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_arm_f32_init(&twin, &config, H));
            if (tribo_arm_q31_init(&params, &config, H) != TRIBO_OK)
            {
                continue;
            }
            // Each shift more doubles the drive's coefficient of F and quadruples that of G: it must not fit any more.
            const double push = ldexp(fabs((double)twin.gamma_d), 2 * params.shift);
            const double move = ldexp(fabs((double)twin.phi_d), params.shift);
            const bool   fits = 4.0 * push <= 1.0 && 2.0 * move + fabs((double)twin.phi_g) < 3.999;
            TEST_ASSERT_TRUE(params.shift == 15 || !fits);
            TEST_ASSERT_TRUE(params.shift == 0 || (push <= 1.0 && move + fabs((double)twin.phi_g) < 3.999));
            by_phi += params.shift < 15 && 4.0 * push <= 1.0;
            shifts[params.shift]++;
        }
    }
    TEST_ASSERT_TRUE(shifts[0] > 3 && shifts[5] > 3 && shifts[15] > 3 && by_phi > 3);
}

static void test_arm_does_not_pass_full_scale_by_a_bit(void)
{
    const int64_t most = (int64_t)INT32_MAX * (INT64_C(1) << 28);
    tribo_arm_q31_reset(&state);
    state.force        = most;
    state.force_change = 2 << params.shift; // the first bits beyond
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, step(0));
    TEST_ASSERT_EQUAL_INT64(most, state.force);
    TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
}

static void test_arm_moves_in_mirror_image_to_the_last_bit(void)
{
    for (uint32_t shift = 0; shift <= 15u; shift++)
    {
        tribo_arm_q31_params_t p = params;
        tribo_arm_q31_state_t  mirror;
        uint32_t               word = 1;
        p.shift                     = (uint8_t)shift;
        tribo_arm_q31_reset(&state);
        tribo_arm_q31_reset(&mirror);
        for (int k = 0; k < 1000; k++)
        {
            word            = word * 1664525u + 1013904223u;
            const int32_t d = (int32_t)word / 256;
            tribo_arm_q31_step(&p, &state, d);
            tribo_arm_q31_step(&p, &mirror, -d);
            TEST_ASSERT_EQUAL_INT64(-state.force, mirror.force);
            TEST_ASSERT_EQUAL_INT32(-state.force_change, mirror.force_change);
        }
    }
}

// C divides towards zero, too.
static void test_arm_rounds_towards_zero_to_the_last_bit(void)
{
    static const int32_t gammas[] = {1, 2, (INT32_C(1) << 28) - 1, INT32_C(1) << 28, (INT32_C(1) << 28) + 1};
    static const int32_t drives[] = {0, 1, 2, 3, (INT32_C(1) << 28) - 1, INT32_C(1) << 28, (INT32_C(1) << 28) + 1};
    for (uint32_t shift = 0; shift <= 15u; shift++)
    {
        for (uint32_t i = 0; i < 5u * 7u * 2u; i++)
        {
            const int32_t d    = drives[i / 5u % 7u] * (i < 35u ? 1 : -1);
            const int64_t push = (int64_t)gammas[i % 5u] * d;
            const int64_t move = push / (INT64_C(1) << shift);

            const tribo_arm_q31_params_t p = {.phi_d   = gammas[i % 5u],
                                              .gamma_d = gammas[i % 5u],
                                              .shift   = (uint8_t)shift};
            tribo_arm_q31_reset(&state);
            tribo_arm_q31_step(&p, &state, d);
            TEST_ASSERT_EQUAL_INT32(push / (INT64_C(1) << 28), state.force_change);
            TEST_ASSERT_EQUAL_INT64(move, state.force);
        }
    }
}

// An arm that swings by up to twice the drive in a sample, from rest: the clamp is on the side of the drive.
static void test_arm_clamps_on_the_side_that_it_is_driven_to(void)
{
    config.stiffness = 960.0f; // K h^2/I = 8
    init(H);
    for (int sign = -1; sign <= 1; sign += 2)
    {
        tribo_arm_q31_reset(&state);
        TEST_ASSERT_EQUAL_INT32(end_of(sign), step(end_of(sign)));
        TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
    }
}

static void test_arm_clamps_from_full_scale_on(void)
{
    for (int sign = -1; sign <= 1; sign += 2)
    {
        tribo_arm_q31_reset(&state);
        state.force = sign < 0 ? -(INT64_C(1) << 59) - 1 : INT64_C(1) << 59;
        (void)step(0);
        TEST_ASSERT_EQUAL_INT64(sign * INT64_C(2147483647) * (INT64_C(1) << 28), state.force);
        TEST_ASSERT_EQUAL_UINT32(1, state.saturated);
    }
}

#include "runners/test_arm_q31.inc" // main
