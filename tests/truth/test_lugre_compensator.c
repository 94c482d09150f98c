// The library's LuGre, at 1 kHz in float and in Q31 with its arm model, against Eq. (12) by CVODE with the same input.

#include "controller/biquad_f32.h"
#include "controller/biquad_q31.h"
#include "guard/guard_q31.h"
#include "lugre_paper.h"
#include "friction/arm_q31.h"
#include "friction/lugre_f32.h"
#include "friction/lugre_q31.h"
#include "rig.h"
#include "tribo/force_loop_q31.h"
#include "tribo/friction_f32.h"
#include "tribo/friction_q31.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define H          1e-3
#define FULL_SCALE 2.0

static rig_t rig;

void setUp(void)
{
    rig_init(&rig, &sim_lugre_truth);
}

void tearDown(void)
{
}

/// Called at each millisecond of the reference, after the module's own tick.
typedef struct
{
    tribo_compensator_f32_params_t f32_params;
    tribo_lugre_f32_params_t       f32_lugre;
    tribo_compensator_f32_state_t  f32;
    tribo_compensator_q31_params_t q31_params;
    tribo_lugre_q31_params_t       q31_lugre;
    tribo_compensator_q31_state_t  q31;
    double                         past_u_n;
    double                         f_square, largest_f, largest_force, largest_force_q31;
    long                           count;
} compensator_t;

static void tick(void *context, const rig_sample_t *sample)
{
    compensator_t *own = context;
    const double   u   = 0.5 * (own->past_u_n + sample->u_n); // mean over the tick
    own->past_u_n      = sample->u_n;

    tribo_compensator_f32_signals_t seen_f32;
    tribo_compensator_q31_signals_t seen_q31;
    const float                     f = tribo_compensator_f32_step(&own->f32_params, &own->f32, (float)u, &seen_f32);
    (void)tribo_compensator_q31_step(&own->q31_params, &own->q31, TRIBO_Q31(u, FULL_SCALE), &seen_q31);

    const double f_error   = fabs((double)f - sample->f_n);
    const double q31_force = tribo_arm_q31_force(&own->q31.arm) / 2147483648.0 * FULL_SCALE;
    own->f_square += f_error * f_error;
    own->largest_f         = fmax(own->largest_f, f_error);
    own->largest_force     = fmax(own->largest_force, fabs((double)own->f32.arm.force_n - sample->force_n));
    own->largest_force_q31 = fmax(own->largest_force_q31, fabs(q31_force - sample->force_n));
    own->count++;
}

static compensator_t run(const rig_ramp_t *ramps, unsigned count)
{
    const tribo_lugre_f32_config_t       lugre  = lugre_paper();
    const tribo_compensator_f32_config_t config = tribo_force_loop_f32_paper().compensator;
    const float                          h      = (float)H;
    const float                          FS     = (float)FULL_SCALE;
    compensator_t                        own    = {0};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_compensator_f32_init(&own.f32_params, &config, h));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_lugre_f32_init(&own.f32_lugre, &lugre, &config.arm, h));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_compensator_q31_init(&own.q31_params, NULL, &config, h, FS));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_lugre_q31_init(&own.q31_lugre, &lugre, &config.arm, h));
    tribo_lugre_f32_attach(&own.f32_params, &own.f32_lugre);
    tribo_lugre_q31_attach(&own.q31_params, &own.q31_lugre);
    tribo_compensator_f32_reset(&own.f32);
    tribo_compensator_q31_reset(&own.q31);
    tribo_lugre_f32_reset(&own.f32.friction.lugre);
    tribo_lugre_q31_reset(&own.q31.friction.lugre);
    rig_run_reference(&rig, &cvode_defaults, H, ramps, count, tick, &own, NULL);
    printf("f^: rms error %.2e N, largest %.2e N; F^: largest %.2e N in float, %.2e N in Q31\n",
           sqrt(own.f_square / (double)own.count),
           own.largest_f,
           own.largest_force,
           own.largest_force_q31);
    return own;
}

/// The largest F of these ramps is 0.46 N, with L 0.144 N.
static void test_it_follows_the_equation_on_the_ramps_of_the_truth_models(void)
{
    const compensator_t own = run(rig_compare_ramps, rig_compare_count);
    TEST_ASSERT_TRUE(sqrt(own.f_square / (double)own.count) < 0.01 * 0.144);
    TEST_ASSERT_TRUE(own.largest_force < 0.01 * 0.46);
    TEST_ASSERT_TRUE(own.largest_force_q31 < 0.01 * 0.46);
}

/// The paper's benchmark: 0.4 to 0.6 N in 10 s and back.
static void test_it_follows_the_equation_on_a_triangle(void)
{
    const rig_ramp_t    ramps[] = {{0.6, 3.0}, {0.3, 10.0}, {0.6, 10.0}};
    const compensator_t own     = run(ramps, 3);
    TEST_ASSERT_TRUE(sqrt(own.f_square / (double)own.count) < 0.01 * 0.144);
    TEST_ASSERT_TRUE(own.largest_force < 0.01 * 0.46);
    TEST_ASSERT_TRUE(own.largest_force_q31 < 0.01 * 0.46);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_it_follows_the_equation_on_the_ramps_of_the_truth_models);
    RUN_TEST(test_it_follows_the_equation_on_a_triangle);
    return UNITY_END();
}
