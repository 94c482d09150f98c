// A law or a table, two sections or another number: each has its own way through the code.

#include ARITH_HEADER
#include "plain_relays.h"
#include "random.h"
#include "unity.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#define H 1e-3

static friction_t friction;

void setUp(void)
{
}

void tearDown(void)
{
}

static friction_seen_t after(uint8_t armed, double n_before, double n)
{
    friction_start(&friction, armed, n_before);
    return friction_step(&friction, n, 0.0);
}

// L+ = 0.1 N, L- = 0.02 N, disarmed at 0.08 and 0.016.
static void test_friction_disarms_by_the_breakaway_of_the_side_where_n_was(void)
{
    static const tribo_breakaway_point_f32_t both[] = {{0.0f, 0.1f, 0.02f}, {1.0f, 0.1f, 0.02f}};
    tribo_friction_f32_config_t              config = tribo_friction_f32_paper();
    config.positive                                 = (tribo_breakaway_f32_t){.offset_n = 0.1f, .slope = 0.0f};
    config.negative                                 = (tribo_breakaway_f32_t){.offset_n = 0.02f, .slope = 0.0f};
    for (int by_table = 0; by_table < 2; by_table++)
    {
        config.table        = by_table != 0 ? both : NULL;
        config.table_length = 2;
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, &config, H));
        TEST_ASSERT_TRUE(after(TRIBO_RELAY_Q2, 0.05, -0.01).q2); // within 0.08, though beyond 0.016
        TEST_ASSERT_FALSE(after(TRIBO_RELAY_Q2, 0.09, -0.01).q2);
        TEST_ASSERT_FALSE(after(TRIBO_RELAY_Q1, -0.018, 0.01).q1); // beyond 0.016, though within 0.08
        TEST_ASSERT_TRUE(after(TRIBO_RELAY_Q1, -0.015, 0.01).q1);
    }
}

// Numbers of few bits, so that levels are exact and met: L+ = 1/2 + |F|, L- = 1/4 + |F|/2; c1 = 3/4, c2 = 1/2.
static void check_relays(random_t *r)
{
    plain_relays_t plain    = plain_relays_at_rest();
    double         before   = 0.0;
    int            switches = 0;
    for (int k = 0; k < 20000; k++)
    {
        const double F       = (double)(random_bits(r) % 5u) / 8.0 * (random_bits(r) % 2u == 0u ? 1.0 : -1.0);
        const double level[] = {0.5 + fabs(F), 0.25 + fabs(F) / 2.0};
        const double n       = random_bits(r) % 4u == 0u ? before : (double)((int)(random_bits(r) % 49u) - 24) / 32.0;
        const bool   set1    = n < 0.75 * level[0];
        const bool   set2    = n > -0.75 * level[1];
        const bool   reset1  = n > before && before < -0.5 * level[1];
        const bool   reset2  = n < before && before > 0.5 * level[0];
        const bool   line[]  = {set1, set2, reset1, reset2};
        const bool   q1      = plain.output[0];
        plain_relays_step(&plain, friction_pulse_width(&friction), line);

        const friction_seen_t seen = friction_step(&friction, F + n, F);
        TEST_ASSERT_TRUE(n == seen.n);
        TEST_ASSERT_EQUAL_INT(plain.output[0], seen.q1);
        TEST_ASSERT_EQUAL_INT(plain.output[1], seen.q2);
        TEST_ASSERT_EQUAL_INT(fabs(n) > fabs(before) && (n > 0.0 ? seen.q2 : seen.q1), seen.q);
        switches += q1 != plain.output[0];
        before = n;
    }
    TEST_ASSERT_TRUE(switches > 200);
}

static void test_friction_relays_are_those_of_its_comparators(void)
{
    static const tribo_breakaway_point_f32_t points[] = {{0.0f, 0.5f, 0.25f},
                                                         {0.125f, 0.625f, 0.3125f},
                                                         {0.25f, 0.75f, 0.375f},
                                                         {0.375f, 0.875f, 0.4375f},
                                                         {0.5f, 1.0f, 0.5f}};
    random_t                                 r        = {1};
    tribo_friction_f32_config_t              config   = tribo_friction_f32_paper();
    config.positive                                   = (tribo_breakaway_f32_t){.offset_n = 0.5f, .slope = 1.0f};
    config.negative                                   = (tribo_breakaway_f32_t){.offset_n = 0.25f, .slope = 0.5f};
    config.reset_level                                = 0.5f;
    config.table_length                               = 5;
    for (uint32_t width = 1; width <= 3u; width++)
    {
        config.pulse_width_s = (float)(width * H);
        for (int by_table = 0; by_table < 2; by_table++)
        {
            config.table = by_table != 0 ? points : NULL;
            TEST_ASSERT_EQUAL_INT(TRIBO_OK, friction_init(&friction, &config, H));
            TEST_ASSERT_EQUAL_UINT32(width, friction_pulse_width(&friction));
            check_relays(&r);
        }
    }
}

static void check_same(const loop_seen_t *a, const loop_seen_t *b)
{
    TEST_ASSERT_TRUE(a->u == b->u);
    TEST_ASSERT_TRUE(a->v == b->v);
    TEST_ASSERT_TRUE(a->e == b->e);
    TEST_ASSERT_TRUE(a->feedforward == b->feedforward);
    TEST_ASSERT_EQUAL_INT(a->limited, b->limited);
    TEST_ASSERT_TRUE(a->compensator.F == b->compensator.F);
    TEST_ASSERT_TRUE(a->compensator.friction.n == b->compensator.friction.n);
    TEST_ASSERT_TRUE(a->compensator.friction.L == b->compensator.friction.L);
    TEST_ASSERT_TRUE(a->compensator.friction.v == b->compensator.friction.v);
    TEST_ASSERT_TRUE(a->compensator.friction.f == b->compensator.friction.f);
    TEST_ASSERT_EQUAL_INT(a->compensator.friction.q1, b->compensator.friction.q1);
    TEST_ASSERT_EQUAL_INT(a->compensator.friction.q2, b->compensator.friction.q2);
    TEST_ASSERT_EQUAL_INT(a->compensator.friction.q, b->compensator.friction.q);
}

/// A tick by the way of any params.
static loop_seen_t loop_step_as_any(loop_t *x, double r, double y)
{
    const uint32_t usual_end  = x->params.usual_input_end;
    x->params.usual_input_end = 0;
    x->state.active           = &x->params;
    const loop_seen_t seen    = loop_step(x, r, y);
    x->params.usual_input_end = usual_end;
    return seen;
}

static bool loop_is_usual(const loop_t *x)
{
    return x->params.usual_input_end != 0u;
}

/// The loop by its own way, by the way of any params, and as its parts one after the other: the same to the last bit.
/// Returns the largest breakaway that it saw.
static double check_is_its_parts_joined(const tribo_force_loop_f32_config_t *config, bool usual)
{
    static loop_t loop;
    static loop_t any;
    parts_t       parts;
    double        largest = 0.0;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&any, config));
    parts_reset(&parts);
    for (int k = 0; k < 6000; k++)
    {
        const double jump = k % 1000 > 980 ? 1.4 : 0.0;
        const double r    = k % 700 == 699 ? 1.99 : 0.5 + 0.1 * sin(k * 0.002) - jump; // 1.99 N is a bad input
        const double y    = 0.5 + 0.0999 * sin(k * 0.002 - 0.001);

        const loop_seen_t seen   = loop_step(&loop, r, y);
        const loop_seen_t as_any = loop_step_as_any(&any, r, y);
        const loop_seen_t joined = parts_step(&parts, &loop, seen.e, seen.feedforward);
        check_same(&seen, &as_any);
        check_same(&seen, &joined);
        largest = fmax(largest, seen.compensator.friction.L);
    }
    TEST_ASSERT_EQUAL_INT(usual, loop_is_usual(&loop));
    TEST_ASSERT_TRUE(loop_limited_ticks(&loop) > 10u);
    TEST_ASSERT_EQUAL_UINT32(loop_limited_ticks(&loop), loop_limited_ticks(&any));
    TEST_ASSERT_EQUAL_UINT32(8, loop_bad_inputs(&loop));
    TEST_ASSERT_EQUAL_UINT32(8, loop_bad_inputs(&any));
    return largest;
}

static void test_loop_of_any_params_is_its_parts_joined(void)
{
    static const tribo_biquad_f32_section_t  sections[] = {TRIBO_BIQUAD_F32(1.6, -1.56, 0.0, -0.99999, 0.0),
                                                           TRIBO_BIQUAD_F32(1.0, -0.5, 0.0, -0.6, 0.0),
                                                           TRIBO_BIQUAD_F32(1.0, -0.2, 0.0, -0.5, 0.0),
                                                           TRIBO_BIQUAD_F32(1.0, -0.1, 0.0, -0.2, 0.0)};
    static const tribo_breakaway_point_f32_t table[]    = {{0.0f, 0.9f, 0.91f}, {1.0f, 0.92f, 0.93f}};
    tribo_force_loop_f32_config_t            config     = tribo_force_loop_f32_paper();
    config.input_max_n                                  = 1.9f;
    TEST_ASSERT_TRUE(check_is_its_parts_joined(&config, true) < 0.8);
    config.compensator.friction.table        = table;
    config.compensator.friction.table_length = 2;
    TEST_ASSERT_TRUE(check_is_its_parts_joined(&config, false) > 0.9); // of the table, not of the law
    config.compensator.friction.table          = NULL;
    config.compensator.friction.positive.slope = 1.25f;
    (void)check_is_its_parts_joined(&config, STEEP_IS_USUAL);
    config.compensator.friction.positive.slope = 0.3f;
    config.controller.sections                 = sections;
    for (uint32_t count = 1; count <= TRIBO_BIQUAD_SECTIONS_MAX; count++)
    {
        config.controller.section_count = count;
        (void)check_is_its_parts_joined(&config, count == 2u);
    }
}

/// `usual` params and others in turns, at limits and with bad inputs.
static void test_loop_is_the_same_without_signals(void)
{
    static const tribo_breakaway_point_f32_t table[]  = {{0.0f, 0.9f, 0.91f}, {1.0f, 0.92f, 0.93f}};
    static loop_t                            seen     = {0};
    static loop_t                            unseen   = {0};
    static loop_t                            of_table = {0};
    tribo_force_loop_f32_config_t            config   = tribo_force_loop_f32_paper();
    uint32_t                                 usual    = 0;
    config.input_max_n                                = 1.9f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&seen, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&unseen, &config));
    config.compensator.friction.table        = table;
    config.compensator.friction.table_length = 2;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&of_table, &config));
    for (int k = 0; k < 6000; k++)
    {
        const double  jump = k % 1000 > 980 ? 1.4 : 0.0;
        const double  r    = k % 700 == 699 ? 1.99 : 0.5 + 0.1 * sin(k * 0.002) - jump; // 1.99 N is a bad input
        const double  y    = 0.5 + 0.0999 * sin(k * 0.002 - 0.001);
        const loop_t *by   = k / 500 % 4 == 3 ? &of_table : &seen;

        const double u = loop_step_by(&seen, by, r, y).u;
        TEST_ASSERT_TRUE(u == loop_step_unseen_by(&unseen, by, r, y));
        TEST_ASSERT_EQUAL_MEMORY(&seen.state, &unseen.state, sizeof seen.state);
        usual += loop_is_usual(by);
    }
    TEST_ASSERT_TRUE(usual > 3000u && usual < 5000u);
    TEST_ASSERT_TRUE(loop_limited_ticks(&unseen) > 10u);
    TEST_ASSERT_EQUAL_UINT32(8, loop_bad_inputs(&unseen));
}

// A change of params looks at what friction was under the old ones: nothing of that look may stay.
static void test_loop_leaves_its_compensator_to_the_new_params_alone(void)
{
    static loop_t                 loop;
    static loop_t                 other;
    static compensator_t          alone;
    random_t                      r      = {3};
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    int                           armed  = 0;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, compensator_init(&alone, &config.compensator, H));
    config.gain                                   = 0.3f;
    config.controller.u_max_n                     = 1.1f;
    config.compensator.friction.positive.offset_n = 0.07f;
    config.compensator.friction.set_level         = 0.3f;
    config.compensator.friction.reset_level       = 0.4f;
    config.compensator.friction.pulse_width_s     = 0.011f;
    config.compensator.arm.damping                = 0.02f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&other, &config));
    for (int k = 0; k < 20000; k++)
    {
        const loop_t *by  = k / 3 % 2 == 0 ? &loop : &other;
        const double  r_n = 0.5 + 0.2 * sin(k * 0.01) + random_between(&r, -0.02, 0.02);
        const double  y_n = 0.5 + 0.19 * sin(k * 0.01 - 0.1);
        const double  u   = loop_step_by(&loop, by, k % 100 < 10 ? -r_n : r_n, y_n).u;
        alone.params      = by->params.compensator;
        (void)compensator_step(&alone, u);
        TEST_ASSERT_EQUAL_MEMORY(&alone.state, &loop.state.compensator, sizeof alone.state);
        armed += loop.state.compensator.friction.relay.latch.held % 4u != 0u;
    }
    TEST_ASSERT_TRUE(armed > 500);
}

static void test_loop_takes_inputs_up_to_their_very_maximum(void)
{
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    static loop_t                 loop;
    config.input_max_n = 1.5f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&loop, &config));
    for (int sign = -1; sign <= 1; sign += 2)
    {
        TEST_ASSERT_TRUE(loop_step(&loop, sign * 1.5, 0.0).e == sign * 1.5);
        TEST_ASSERT_TRUE(loop_step(&loop, 0.0, sign * 1.5).e == -sign * 1.5);
    }
    TEST_ASSERT_EQUAL_UINT32(0, loop_bad_inputs(&loop));
    TEST_ASSERT_TRUE(loop_step(&loop, 1.5 + 1e-6, 0.0).e == 0.0);
    TEST_ASSERT_TRUE(loop_step(&loop, 0.0, -1.5 - 1e-6).e == 0.0);
    TEST_ASSERT_EQUAL_UINT32(2, loop_bad_inputs(&loop));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_friction_disarms_by_the_breakaway_of_the_side_where_n_was);
    RUN_TEST(test_friction_relays_are_those_of_its_comparators);
    RUN_TEST(test_loop_of_any_params_is_its_parts_joined);
    RUN_TEST(test_loop_is_the_same_without_signals);
    RUN_TEST(test_loop_leaves_its_compensator_to_the_new_params_alone);
    RUN_TEST(test_loop_takes_inputs_up_to_their_very_maximum);
    return UNITY_END();
}
