// Set-up, and what only the Q31 arithmetic has. What both promise: tests/contract/test_feedforward.c.

#include "feedforward/words_q31.h"
#include "tribo/feedforward_q31.h"

#include "random.h"
#include "unity.h"

#include <math.h>

#define H  1.0e-3f
#define FS 2.0f

static tribo_force_loop_f32_config_t  loop_config;
static tribo_feedforward_f32_config_t config;
static tribo_force_loop_q31_params_t  loop;
static tribo_feedforward_q31_params_t params;
static tribo_friction_f32_params_t    friction;
static tribo_breakaway_point_q31_t    table[TRIBO_BREAKAWAY_POINTS_MAX];
static tribo_feedforward_q31_memory_t memory;

static tribo_status_t init(float input_max, float full_scale)
{
    const tribo_arm_f32_config_t *const arm = &loop_config.compensator.arm;
    return tribo_feedforward_q31_init(&params, &config, arm, &friction, input_max, 0.5f, H, full_scale);
}

static void init_with(tribo_loop_part_t method)
{
    tribo_force_loop_q31_config_t whole = {.loop = loop_config, .full_scale_n = FS, .table = table};
    whole.loop.method                   = method;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_force_loop_q31_init(&loop, &whole));
}

/// Params of a loop, whose method runs without it.
static void init_loop(void)
{
    init_with(tribo_feedforward_q31_use(&params, &config));
    tribo_feedforward_q31_reset(&memory.state);
}

static tribo_force_loop_q31_functions_t fed;

void setUp(void)
{
    tribo_feedforward_q31_method(&fed);
    loop_config = tribo_force_loop_f32_paper();
    config      = tribo_feedforward_f32_default();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, tribo_friction_f32_init(&friction, &loop_config.compensator.friction, H));
    init_loop();
}

static void check(float *field, float value, tribo_status_t status)
{
    const tribo_feedforward_q31_params_t before = params;
    const float                          kept   = *field;
    *field                                      = value;
    TEST_ASSERT_EQUAL_INT(status, init(2.0f, FS));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    *field = kept;
}

static void test_feedforward_init_names_the_field(void)
{
    const tribo_arm_f32_config_t *const arm = &loop_config.compensator.arm;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_feedforward_q31_init(NULL, &config, arm, &friction, 2.0f, 0.5f, H, FS));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, tribo_feedforward_q31_init(&params, NULL, arm, &friction, 2.0f, 0.5f, H, FS));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_FULL_SCALE, init(2.0f, 0.0f));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_INPUT_MAX, init(2.1f, FS));
    check(&config.reversal_n, 1e-6f, TRIBO_ERR_REVERSAL_WIDTH);
    check(&config.reversal_n, 0.6f, TRIBO_ERR_REVERSAL_WIDTH);
    check(&config.presliding_n, 1e-4f, TRIBO_ERR_PRESLIDING);
    check(&config.presliding_n, 0.6f, TRIBO_ERR_PRESLIDING);
    check(&config.actuator_pole_rad_per_s, 0.015f, TRIBO_ERR_ACTUATOR_POLE); // over 65,536 ticks
    check(&loop_config.compensator.arm.damping, 1e6f, TRIBO_ERR_ACTUATOR_POLE);
    config.actuator_pole_rad_per_s = 0.0154f; // 64,943 ticks
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, FS));
}

static void test_the_offset_is_bounded_by_four_inputs_or_full_scale(void)
{
    TEST_ASSERT_EQUAL_INT32(INT32_C(1) << 29, params.offset_max);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(0.25f, FS));
    TEST_ASSERT_EQUAL_INT32(INT32_C(1) << 28, params.offset_max);
}

static void test_a_lag_of_many_ticks_leads_as_it_should(void)
{
    config.actuator_pole_rad_per_s = 0.5f; // 2,000 ticks
    config.reversal_n              = 0.5e-3f;
    init_loop();
    int32_t r = 0;
    for (int k = 0; k < 9000; k++) // the filter of the rate has 1,606 ticks
    {
        r += 107374; // 0.1 mN a tick, 0.1 N/s
        (void)fed.error(&loop, &memory, r, r, UINT32_MAX);
    }
    const double ahead = (double)(memory.state.lin - memory.state.reached) / 536870912.0 * (double)FS;
    TEST_ASSERT_DOUBLE_WITHIN(5e-3 * 0.2, 0.1 * (2.0 + 0.0288 / 3.84), ahead);
}

static void test_what_was_learned_ends_at_full_scale(void)
{
    loop_config.compensator.friction.positive.slope = 1.999f;
    loop_config.compensator.friction.negative.slope = 2.0f;
    init_loop();
    for (uint32_t d = 0; d < 2u; d++)
    {
        static const int32_t end[] = {INT32_MIN, -INT32_MAX, INT32_MAX};
        for (int i = 0; i < 3; i++)
        {
            const tribo_feedforward_learned_t at = tribo_feedforward_q31_learned(&loop, &memory.state, d, end[i]);
            TEST_ASSERT_FLOAT_WITHIN(1e-5f, FS, at.L_n);
            TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f, at.relative_variance);
        }
    }
}

static void test_no_sum_overflows_at_the_ends_of_the_scale(void)
{
    random_t             r                          = {31};
    static const int32_t end[]                      = {INT32_MIN, INT32_MAX, -INT32_MAX, 0, 1, -1, 1 << 30, -(1 << 30)};
    loop_config.compensator.friction.positive.slope = 2.0f; // L beyond full scale
    loop_config.compensator.friction.negative.slope = 0.9f;
    init_loop();
    for (int k = 0; k < 200000; k++)
    {
        tribo_force_loop_q31_signals_t seen = {.controller = {.limited = k % 5 == 0}};

        const int32_t v = end[random_bits(&r) % 8u];
        const int32_t e = fed.error(&loop, &memory, end[random_bits(&r) % 8u], end[random_bits(&r) % 8u], UINT32_MAX);
        const int32_t a = fed.term(&loop, &memory, v);
        fed.after(&loop, &memory, v, end[random_bits(&r) % 8u], &seen);
        TEST_ASSERT_TRUE(e >= -INT32_MAX && a >= -INT32_MAX);
        TEST_ASSERT_TRUE(memory.state.f <= 1 << 29 && memory.state.f >= -(1 << 29));
        TEST_ASSERT_TRUE(memory.state.b <= 1 << 29 && memory.state.b >= -(1 << 29));
    }
    TEST_ASSERT_EQUAL_UINT32(0, memory.state.forgotten);
}

/// A bit of the state flips every few ticks, while u is limited and while it is not. The sanitizers see what overflows.
static void run_with_flipping_bits(const tribo_force_loop_q31_method_t *method)
{
    tribo_force_loop_q31_functions_t functions;
    method->functions(&functions);
    random_t random = {83};
    for (int k = 0; k < 300000; k++)
    {
        tribo_force_loop_q31_signals_t seen = {.controller = {.limited = k % 512 < 256}};

        const int32_t r = (k % 2000 - 1000) * 2000000;
        const int32_t y = k % 7 == 0 ? INT32_MIN : r / 2;
        const int32_t v = (int32_t)random_bits(&random);
        const int32_t u = (int32_t)random_bits(&random);
        if (k % 6 == 0)
        {
            const uint64_t bit = random_bits(&random) % (8u * sizeof memory.state);
            ((uint8_t *)&memory.state)[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        }
        if (k % 6 == 3) // all forces depend on rs
        {
            memory.state.reached ^= (int32_t)(1u << random_bits(&random) % 32u);
        }
        const int32_t e = functions.error(&loop, &memory, r, y, UINT32_MAX);
        TEST_ASSERT_TRUE(e >= -INT32_MAX);
        (void)functions.term(&loop, &memory, v);
        functions.after(&loop, &memory, v, u, &seen);
        (void)tribo_feedforward_q31_learn(&loop, &memory);
    }
}

static void test_no_sum_overflows_with_flipped_bits(void)
{
    const tribo_sensorless_f32_config_t sensorless = tribo_sensorless_f32_default();
    run_with_flipping_bits(loop.method);
    init_with(tribo_sensorless_q31_use(&params, &config, &sensorless));
    run_with_flipping_bits(loop.method);
}

static void test_words_round_towards_zero_and_saturate(void)
{
    TEST_ASSERT_EQUAL_INT32(1, gained(3, 1u << 15));
    TEST_ASSERT_EQUAL_INT32(-1, gained(-3, 1u << 15));
    TEST_ASSERT_EQUAL_INT32(1 - (1 << 30), gained(INT32_MIN, UINT32_MAX));
    TEST_ASSERT_EQUAL_INT32((1 << 30) - 1, gained(1 << 30, 1u << 16));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, times(INT32_MIN, INT32_MAX));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, times(1 << 30, 1 << 30));
    TEST_ASSERT_EQUAL_INT32((1 << 29) - 1, bounded(1 << 29));
    TEST_ASSERT_EQUAL_INT32(1 - (1 << 29), bounded(-(1 << 29)));
    TEST_ASSERT_EQUAL_INT32(2, low_pass(0, 3, 1u << 31)); // half a unit is rounded up
    TEST_ASSERT_EQUAL_INT32(-2, low_pass(0, -3, 1u << 31));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX - 3, outside(INT32_MAX));
    TEST_ASSERT_EQUAL_INT32(3 - INT32_MAX, outside(INT32_MIN));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, size_of(INT32_MIN));
    TEST_ASSERT_INT32_WITHIN(1024, -(1 << 29), over(INT32_MIN, 1 << 20));
    TEST_ASSERT_EQUAL_INT32(1 << 28, finer(INT32_MAX));
    TEST_ASSERT_EQUAL_INT32(-64, finer(-1));
    TEST_ASSERT_INT32_WITHIN(256, NUMBER(3.9), number_of(1e9f));
}

static void test_the_last_bits_of_inputs_mirror_too(void)
{
    static tribo_feedforward_q31_memory_t mirror;
    random_t                              r  = {41};
    int32_t                               at = 0;
    tribo_feedforward_q31_reset(&mirror.state);
    for (int k = 0; k < 20000; k++)
    {
        tribo_force_loop_q31_signals_t seen = {.controller = {.limited = false}};

        at += (int32_t)random_between(&r, -1e5, 1.1e5);
        const int32_t y = at + (int32_t)random_between(&r, -1e6, 1e6);
        const int32_t v = (int32_t)random_between(&r, -1e8, 1e8);
        const int32_t e = fed.error(&loop, &memory, at, y, UINT32_MAX);
        TEST_ASSERT_EQUAL_INT32(-e, fed.error(&loop, &mirror, -at, -y, UINT32_MAX));
        const int32_t a = fed.term(&loop, &memory, v);
        TEST_ASSERT_EQUAL_INT32(-a, fed.term(&loop, &mirror, -v));
        fed.after(&loop, &memory, v, v + a, &seen);
        fed.after(&loop, &mirror, -v, -v - a, &seen);
        (void)tribo_feedforward_q31_learn(&loop, &memory);
        (void)tribo_feedforward_q31_learn(&loop, &mirror);
    }
}

static void test_a_soft_heavily_damped_arm_is_refused(void)
{
    loop_config.compensator.arm.damping   = 3.3f; // b/(K h) is 33,000
    loop_config.compensator.arm.stiffness = 0.1f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_DAMPING, init(2.0f, FS));
    loop_config.compensator.arm.damping = 3.2f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, init(2.0f, FS));
}

static void test_the_width_of_a_step_ends_where_the_rate_does(void)
{
    const tribo_arm_f32_config_t *const arm = &loop_config.compensator.arm;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK,
                          tribo_feedforward_q31_init(&params, &config, arm, &friction, 2.0f, 0.5f, 0.01f, FS));
    TEST_ASSERT_EQUAL_INT32(536870912 / 128, params.step); // 0.02 N, of which 0.0156 N fit
}

static void test_what_does_not_run_adds_no_friction(void)
{
    memory.state.tick.friction = 1000;
    (void)fed.error(&loop, &memory, INT32_MIN, 0, UINT32_MAX);
    TEST_ASSERT_EQUAL_INT32(0, memory.state.tick.friction);
}

#include "runners/test_feedforward_q31.inc" // main
