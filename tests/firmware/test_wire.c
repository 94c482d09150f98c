// What crosses the wire to an emulated drive arrives whole and in the order that both ends expect.

#include "app/loop.h"
#include "app/scaling.h"
#include "tribo_wire.h"
#include "unity.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#define FULL_SCALE_N 4.0f

static const tribo_biquad_f32_section_t sections[] = {TRIBO_BIQUAD_F32(2.0, 1.0, 0.125, 0.5, 0.0625),
                                                      TRIBO_BIQUAD_F32(1.0, 0.25, 0.5, 0.75, 0.25),
                                                      TRIBO_BIQUAD_F32(1.5, 0.375, 0.0625, 0.125, 0.03125)};

static const tribo_breakaway_point_f32_t table[] = {{.force_n = 0.125f, .positive_n = 0.03f, .negative_n = 0.04f},
                                                    {.force_n = 0.5f, .positive_n = 0.1f, .negative_n = 0.2f}};

static tribo_force_loop_f32_config_t config;

/// No two fields are alike, and none is the paper's.
void setUp(void)
{
    config = (tribo_force_loop_f32_config_t){
        .sample_time_s = 0.002f,
        .input_max_n   = 1.75f,
        .gain          = 0.625f,
        .controller    = {.sections = sections, .section_count = 3, .u_min_n = -1.25f, .u_max_n = 1.5f},
        .compensator   = {.friction = {.positive = {.offset_n = 0.011f, .slope = 0.21f},
                                       .negative = {.offset_n = 0.013f, .slope = 0.23f}},
                          .arm      = {.inertia = 1.3e-4f, .damping = 0.031f, .stiffness = 4.1f}}};
#define OTHER(group, symbol, member, key, unit, low, high, standard, ...)                                              \
    config.compensator.friction.member = 0.97f * (float)(standard) + 0.001f;
    TRIBO_FRICTION_PARAMETERS(OTHER)
#undef OTHER
}

/// The bytes between members are the same in all.
static loop_setup_t *set_up(loop_setup_t *setup, const tribo_force_loop_f32_config_t *from)
{
    memset(setup, 0, sizeof *setup);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_setup(setup, from, FULL_SCALE_N));
    return setup;
}

/// Sends the config through words and compares the params that both ends make from it. A breakaway table is compared by
/// itself, because params point to the copy of their own end.
static void check_loop_arrives(void)
{
    static loop_setup_t  here, there;
    static tribo_setup_t sent, received;
    uint32_t             words[TRIBO_SETUP_WORDS];
    memset(&sent, 0, sizeof sent);
    memset(&received, 0xff, sizeof received); // nothing may be left from before
    sent.loop.config = config;
    tribo_setup_to_words(&sent, words);
    tribo_setup_from_words(&received, words);
    set_up(&here, &config);
    set_up(&there, &received.loop.config);

    const uint32_t points = here.params.compensator.friction.table_length;
    TEST_ASSERT_EQUAL_UINT32(points, there.params.compensator.friction.table_length);
    if (points > 0u)
    {
        TEST_ASSERT_EQUAL_MEMORY(here.params.compensator.friction.table,
                                 there.params.compensator.friction.table,
                                 points * sizeof *here.params.compensator.friction.table);
    }
    here.params.compensator.friction.table  = NULL;
    there.params.compensator.friction.table = NULL;
#ifdef TRIBO_ARITHMETIC_Q31
    const size_t members =
        offsetof(tribo_force_loop_q31_params_t, compensator.arm.shift) + 1u; // without the last's padding
#else
    const size_t members = sizeof here.params;
#endif
    TEST_ASSERT_EQUAL_MEMORY(&here.params, &there.params, members);
}

static void test_every_field_of_the_loops_config_arrives(void)
{
    check_loop_arrives();
}

static void test_a_breakaway_table_arrives(void)
{
    config.compensator.friction.table        = table;
    config.compensator.friction.table_length = 2;
    check_loop_arrives();
}

/// Returns `config` as it arrives through words.
static tribo_status_t status_there(void)
{
    static tribo_setup_t sent, received;
    static loop_setup_t  there;
    uint32_t             words[TRIBO_SETUP_WORDS];
    sent.loop.config = config;
    tribo_setup_to_words(&sent, words);
    tribo_setup_from_words(&received, words);
    return loop_setup(&there, &received.loop.config, FULL_SCALE_N);
}

static void test_a_length_without_a_table_is_refused_at_the_other_end_too(void)
{
    config.compensator.friction.table_length = 2;
    TEST_ASSERT_NOT_EQUAL_INT(TRIBO_OK, status_there());
}

static void test_more_sections_than_fit_are_refused_at_the_other_end_too(void)
{
    tribo_biquad_f32_section_t many[TRIBO_BIQUAD_SECTIONS_MAX + 1];
    for (size_t i = 0; i <= TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        many[i] = sections[0];
    }
    config.controller.sections      = many;
    config.controller.section_count = TRIBO_BIQUAD_SECTIONS_MAX + 1;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SECTION_COUNT, status_there());
}

static void test_the_drives_own_config_arrives(void)
{
    static tribo_setup_t received;
    const tribo_setup_t  sent = {.period_us    = 1000,
                                 .late_us      = 100,
                                 .budget_us    = 500,
                                 .stuck_ticks  = 7,
                                 .full_scale_n = FULL_SCALE_N,
                                 .loop         = {.feeds_forward = true, .guarded = true}};
    uint32_t             words[TRIBO_SETUP_WORDS];
    tribo_setup_to_words(&sent, words);
    tribo_setup_from_words(&received, words);
    TEST_ASSERT_EQUAL_UINT32(1000, received.period_us);
    TEST_ASSERT_EQUAL_UINT32(100, received.late_us);
    TEST_ASSERT_EQUAL_UINT32(500, received.budget_us);
    TEST_ASSERT_EQUAL_UINT32(7, received.stuck_ticks);
    TEST_ASSERT_TRUE(received.full_scale_n == FULL_SCALE_N);
    TEST_ASSERT_TRUE(received.loop.feeds_forward && !received.loop.is_sensorless && received.loop.guarded);
}

/// The order is part of the self-test's CRC, so it is stated here once more, by hand.
static void test_signals_become_words_in_the_order_of_the_self_test(void)
{
    loop_signals_t signals = {
        .TRIBO_N(e)             = 1,
        .TRIBO_N(friction_term) = 3,
        .controller             = {.TRIBO_N(v) = 2, .TRIBO_N(u) = 4, .limited = true},
        .compensator            = {.TRIBO_N(force) = 5,
                                   .friction       = {.TRIBO_N(n) = 6, .TRIBO_N(L) = 7, .TRIBO_N(f) = 9, .relays = 5}},
    };
    uint32_t words[TRIBO_SIGNAL_WORDS];
#ifdef TRIBO_ARITHMETIC_Q31
    signals.compensator.friction.rise = 8;
#else
    signals.compensator.friction.v_n_per_s = 8.0f;
#endif
    tribo_signal_words(&signals, words);
    TEST_ASSERT_EQUAL_INT(10, TRIBO_SIGNAL_WORDS);
    TEST_ASSERT_EQUAL_HEX32(0xbu, words[0]);
    for (int i = 1; i < TRIBO_SIGNAL_WORDS; i++)
    {
        TEST_ASSERT_EQUAL_HEX32(tribo_force_word((loop_force_t)i), words[i]);
    }
}

/// A number as both converters make it, the host's in double and the drive's in float.
static void check_credible(const loop_params_t *params, float force_n, bool credible)
{
    TEST_ASSERT_EQUAL_INT(credible, tribo_force_is_credible(params, scaling_number(force_n, FULL_SCALE_N)));
    TEST_ASSERT_EQUAL_INT(credible,
                          tribo_force_is_credible(params, tribo_force_of_n((double)force_n, (double)FULL_SCALE_N)));
}

static void test_a_number_beyond_full_scale_is_not_credible_and_full_scale_is(void)
{
    static loop_setup_t setup;
    const float         below  = nextafterf(FULL_SCALE_N, 0.0f);
    const float         above  = nextafterf(FULL_SCALE_N, 2.0f * FULL_SCALE_N);
    const float         good[] = {0.0f, 0.5f, below, FULL_SCALE_N};
    const float         bad[]  = {above, 1.5f * FULL_SCALE_N, 1e9f, INFINITY, NAN};
    config                     = tribo_force_loop_f32_paper();
    config.input_max_n         = FULL_SCALE_N;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_setup(&setup, &config, FULL_SCALE_N));
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++)
    {
        check_credible(&setup.params, good[i], true);
        check_credible(&setup.params, -good[i], true);
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, good[i], scaling_value(scaling_number(good[i], FULL_SCALE_N), FULL_SCALE_N));
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    {
        check_credible(&setup.params, bad[i], false);
        check_credible(&setup.params, -bad[i], false);
    }
}

#include "runners/test_wire.inc" // main
