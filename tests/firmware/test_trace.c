// The trace: what it keeps around a trigger, and that what is read is what was recorded.

#include "app/trace.h"
#include "unity.h"

#include <string.h>

#define RING_WORDS 60u

static trace_t      trace;
static uint32_t     ring[RING_WORDS + 1];
static uint32_t     tick;
static loop_force_t force;
static loop_force_t second;
static bool         is_fault;

void setUp(void)
{
    memset(ring, 0xee, sizeof ring);
    trace_init(&trace, ring, RING_WORDS);
    tick     = 1000;
    force    = 0;
    second   = 0;
    is_fault = false;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_HEX32(0xeeeeeeee, ring[RING_WORDS]);
}

static trace_setup_t two_channels(trace_trigger_t trigger, uint32_t after)
{
    return (trace_setup_t){.channels      = {&force, &second},
                           .channel_count = 2,
                           .decimation    = 1,
                           .after         = after,
                           .trigger       = trigger,
                           .watched       = &force,
                           .level         = (loop_force_t)10};
}

/// Channel 0 is `x`, channel 1 the tick's number.
static void step(int x)
{
    force  = (loop_force_t)x;
    second = tribo_force_of_word(tick);
    trace_step(&trace, tick++, is_fault);
}

static void assert_sample(uint32_t number, uint32_t expected_tick, int x)
{
    uint32_t words[2];
    TEST_ASSERT_TRUE(trace_read(&trace, number, words, 2));
    TEST_ASSERT_EQUAL_UINT32(expected_tick, words[1]);
    TEST_ASSERT_EQUAL_HEX32(tribo_force_word((loop_force_t)x), words[0]);
}

static void arm(const trace_setup_t *setup)
{
    TEST_ASSERT_TRUE(trace_arm(&trace, setup));
}

static void test_a_fault_keeps_what_was_before_it(void)
{
    const trace_setup_t setup = two_channels(TRACE_FAULT, 5);
    arm(&setup);
    for (int i = 0; i < 100; i++)
    {
        step(i);
    }
    is_fault = true;
    step(100);
    TEST_ASSERT_EQUAL_INT(TRACE_TRIGGERED, trace.state);
    for (int i = 101; i < 200; i++)
    {
        step(i);
    }
    TEST_ASSERT_EQUAL_INT(TRACE_DONE, trace.state);
    TEST_ASSERT_EQUAL_UINT32(1000, trace.first_tick);
    TEST_ASSERT_EQUAL_UINT32(100, trace.trigger_sample);
    TEST_ASSERT_EQUAL_UINT32(106, trace.count);
    TEST_ASSERT_EQUAL_UINT32(76, trace_first(&trace)); // 30 fit
    for (uint32_t i = 76; i < 106; i++)
    {
        assert_sample(i, 1000 + i, (int)i);
    }
}

static void test_a_fault_that_was_there_before_is_no_trigger(void)
{
    const trace_setup_t setup = two_channels(TRACE_FAULT, 0);
    is_fault                  = true;
    arm(&setup);
    step(0);
    step(0);
    TEST_ASSERT_EQUAL_INT(TRACE_ARMED, trace.state);
    is_fault = false;
    step(0);
    is_fault = true;
    step(0);
    TEST_ASSERT_EQUAL_INT(TRACE_DONE, trace.state);
    TEST_ASSERT_EQUAL_UINT32(4, trace.count);
}

static void test_a_level_is_reached_from_its_side_only(void)
{
    static const struct
    {
        trace_trigger_t trigger;
        int             from, to;
        bool            fires;
    } moves[] = {{TRACE_RISE, 9, 10, true},
                 {TRACE_RISE, 9, 11, true},
                 {TRACE_RISE, 10, 11, false},
                 {TRACE_RISE, 11, 9, false},
                 {TRACE_RISE, 8, 9, false},
                 {TRACE_FALL, 11, 10, true},
                 {TRACE_FALL, 11, 9, true},
                 {TRACE_FALL, 10, 9, false},
                 {TRACE_FALL, 9, 11, false},
                 {TRACE_FALL, 12, 11, false},
                 {TRACE_NEVER, 9, 11, false}};
    for (size_t i = 0; i < sizeof moves / sizeof moves[0]; i++)
    {
        const trace_setup_t setup = two_channels(moves[i].trigger, 0);
        arm(&setup);
        step(moves[i].from);
        TEST_ASSERT_EQUAL_INT(TRACE_ARMED, trace.state);
        step(moves[i].to);
        TEST_ASSERT_EQUAL_INT(moves[i].fires ? TRACE_DONE : TRACE_ARMED, trace.state);
    }
}

static void test_a_reversal_is_a_turn_not_a_start_or_a_rest(void)
{
    const trace_setup_t setup   = two_channels(TRACE_REVERSAL, 1);
    static const int    moves[] = {5, 5, 6, 6, 7, 7, 6};
    arm(&setup);
    for (size_t i = 0; i < sizeof moves / sizeof moves[0]; i++)
    {
        TEST_ASSERT_EQUAL_INT(TRACE_ARMED, trace.state);
        step(moves[i]);
    }
    TEST_ASSERT_EQUAL_INT(TRACE_TRIGGERED, trace.state);
    TEST_ASSERT_EQUAL_UINT32(6, trace.trigger_sample);
    step(8);
    TEST_ASSERT_EQUAL_INT(TRACE_DONE, trace.state);
    TEST_ASSERT_EQUAL_UINT32(6, trace.trigger_sample);
}

static void test_decimation_takes_every_nth_tick(void)
{
    trace_setup_t setup = two_channels(TRACE_FAULT, 2);
    setup.decimation    = 7;
    arm(&setup);
    for (int i = 0; i < 17; i++)
    {
        step(i);
    }
    TEST_ASSERT_EQUAL_UINT32(3, trace.count);
    is_fault = true;
    step(17); // between two samples
    TEST_ASSERT_EQUAL_UINT32(2, trace.trigger_sample);
    for (int i = 18; i < 100; i++)
    {
        step(i);
    }
    TEST_ASSERT_EQUAL_UINT32(5, trace.count);
    for (uint32_t i = 0; i < 5; i++)
    {
        assert_sample(i, 1000 + 7 * i, (int)(7 * i));
    }
}

static void test_a_running_trace_is_read_as_long_as_it_holds_a_sample(void)
{
    const trace_setup_t setup = two_channels(TRACE_NEVER, 0);
    uint32_t            words[RING_WORDS];
    arm(&setup);
    TEST_ASSERT_FALSE(trace_read(&trace, 0, words, 1)); // none yet
    for (int i = 0; i < 100; i++)
    {
        step(i);
        TEST_ASSERT_EQUAL_UINT32(i < 30 ? 0 : i - 29, trace_first(&trace));
        assert_sample((uint32_t)i, 1000u + (uint32_t)i, i);
        assert_sample(trace_first(&trace), 1000u + trace_first(&trace), (int)trace_first(&trace));
        TEST_ASSERT_FALSE(trace_read(&trace, trace_first(&trace) - 1u, words, 1));
        TEST_ASSERT_FALSE(trace_read(&trace, (uint32_t)i + 1u, words, 1));
        TEST_ASSERT_FALSE(trace_read(&trace, (uint32_t)i, words, 3)); // its second sample is not there
        TEST_ASSERT_FALSE(trace_read(&trace, (uint32_t)i, words, 0));
    }
    TEST_ASSERT_TRUE(trace_read(&trace, 70, words, RING_WORDS)); // over the end of the ring
    for (uint32_t i = 0; i < 30; i++)
    {
        TEST_ASSERT_EQUAL_UINT32(1070 + i, words[2 * i + 1]);
    }
    trace_stop(&trace);
    step(100);
    assert_sample(70, 1070, 70);
    TEST_ASSERT_EQUAL_UINT32(100, trace.count);
}

static void test_numbers_of_samples_wrap(void)
{
    const trace_setup_t setup = two_channels(TRACE_FAULT, 3);
    arm(&setup);
    step(0);
    trace.count = UINT32_MAX - 5u; // as after years
    for (int i = 0; i < 50; i++)
    {
        is_fault = i == 30;
        step(i);
    }
    TEST_ASSERT_EQUAL_INT(TRACE_DONE, trace.state);
    TEST_ASSERT_EQUAL_UINT32(28, trace.count);
    TEST_ASSERT_EQUAL_UINT32(24, trace.trigger_sample);
    for (uint32_t i = 0; i < 30; i++)
    {
        assert_sample(27 - i, 1034 - i, 33 - (int)i);
    }
}

static void test_channels_that_do_not_fill_the_ring_evenly(void)
{
    trace_setup_t setup = two_channels(TRACE_NEVER, 0);
    for (uint32_t channels = 1; channels <= TRACE_CHANNELS_MAX; channels++)
    {
        setUp();
        for (uint32_t i = 0; i < channels; i++)
        {
            setup.channels[i] = &second;
        }
        setup.channel_count = channels;
        arm(&setup);
        for (int i = 0; i < 200; i++)
        {
            step(0);
        }
        const uint32_t capacity = RING_WORDS / channels;
        uint32_t       words[RING_WORDS];
        TEST_ASSERT_EQUAL_UINT32(200 - capacity, trace_first(&trace));
        TEST_ASSERT_TRUE(trace_read(&trace, 200 - capacity, words, capacity * channels));
        for (uint32_t i = 0; i < capacity * channels; i++)
        {
            TEST_ASSERT_EQUAL_UINT32(1200 - capacity + i / channels, words[i]);
        }
        tearDown();
    }
}

static void test_a_setup_out_of_range_changes_nothing(void)
{
    const trace_setup_t good = two_channels(TRACE_FAULT, 3);
    arm(&good);
    for (int i = 0; i < 10; i++)
    {
        step(i);
    }
    trace_setup_t bad[8];
    for (int i = 0; i < 8; i++)
    {
        bad[i] = good;
    }
    bad[0].channel_count = 0;
    bad[1].channel_count = TRACE_CHANNELS_MAX + 1u;
    bad[2].decimation    = 0;
    bad[3].after         = 30;
    bad[4].trigger       = TRACE_TRIGGERS;
    bad[5].trigger       = TRACE_RISE;
    bad[5].watched       = NULL;
    bad[6].trigger       = TRACE_REVERSAL;
    bad[6].watched       = NULL;
    bad[7].after         = UINT32_MAX;
    for (int i = 0; i < 8; i++)
    {
        TEST_ASSERT_FALSE(trace_arm(&trace, &bad[i]));
        assert_sample(9, 1009, 9);
        TEST_ASSERT_EQUAL_INT(TRACE_ARMED, trace.state);
    }
    bad[3].after = 29;
    arm(&bad[3]);
    TEST_ASSERT_EQUAL_UINT32(0, trace.count);
}

#include "runners/test_trace.inc" // main
