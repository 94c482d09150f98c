#include "friction/relay.h"
#include "tribo/friction_f32.h"
#include "unity.h"

#include <stdbool.h>

static tribo_relay_state_t relay;

void setUp(void)
{
    relay_reset(&relay);
}

#define REST (TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2) // both comparators rest high

static void test_relay_starts_low_and_stays_low_at_rest(void)
{
    for (unsigned k = 0; k < 100u; k++)
    {
        TEST_ASSERT_EQUAL_UINT8(0, relay_step(&relay, 3, REST));
    }
}

static void test_relay_2_arms_when_its_set_event_rises_and_holds(void)
{
    for (unsigned k = 0; k < 10u; k++)
    {
        TEST_ASSERT_EQUAL_UINT8(0, relay_step(&relay, 3, TRIBO_RELAY_SET1)); // n below -L1
    }
    for (unsigned k = 0; k < 100u; k++)
    {
        TEST_ASSERT_EQUAL_UINT8(TRIBO_RELAY_Q2, relay_step(&relay, 3, REST)); // and back
    }
}

static void test_relay_1_is_the_mirror_image(void)
{
    for (unsigned k = 0; k < 10u; k++)
    {
        TEST_ASSERT_EQUAL_UINT8(0, relay_step(&relay, 3, TRIBO_RELAY_SET2));
    }
    for (unsigned k = 0; k < 100u; k++)
    {
        TEST_ASSERT_EQUAL_UINT8(TRIBO_RELAY_Q1, relay_step(&relay, 3, REST));
    }
    TEST_ASSERT_EQUAL_UINT8(0, relay_step(&relay, 3, REST | TRIBO_RELAY_RESET1));
}

static void test_relay_disarms_on_its_reset_event_and_holds(void)
{
    tribo_relay_latch_t latch = {TRIBO_RELAY_Q1 | TRIBO_RELAY_Q2};
    TEST_ASSERT_EQUAL_UINT8(TRIBO_RELAY_Q1, tribo_relay_latch_step(&latch, TRIBO_RELAY_RESET2));
    TEST_ASSERT_EQUAL_UINT8(TRIBO_RELAY_Q1, tribo_relay_latch_step(&latch, 0));
    TEST_ASSERT_EQUAL_UINT8(0, tribo_relay_latch_step(&latch, TRIBO_RELAY_RESET1));
    TEST_ASSERT_EQUAL_UINT8(0, tribo_relay_latch_step(&latch, 0));
}

// Fig. 12: the sample-and-hold takes the set pulse when (set or reset) rises, and only then.
static void test_relay_samples_the_set_pulse_only_when_its_trigger_rises(void)
{
    for (uint8_t before = 0; before < 4u; before++)
    {
        for (uint8_t now = 0; now < 4u; now++)
        {
            for (uint8_t held = 0; held < 2u; held++)
            {
                const bool trigger_before = before != 0u; // bit 0 set, bit 1 reset
                const bool trigger_now    = now != 0u;
                const bool set_now        = (now & 1u) != 0u;
                const bool expected       = trigger_now && !trigger_before ? set_now : held != 0u;

                tribo_relay_latch_t latch = {0};
                (void)tribo_relay_latch_step(&latch,
                                             (uint8_t)((before & 1u) | (uint8_t)((before >> 1) * TRIBO_RELAY_RESET1)));
                latch.held = (uint8_t)((latch.held & 0xf0u) | held);
                TEST_ASSERT_EQUAL_UINT8(
                    expected,
                    tribo_relay_latch_step(&latch, (uint8_t)((now & 1u) | (uint8_t)((now >> 1) * TRIBO_RELAY_RESET1))));
            }
        }
    }
}

static void test_relay_misses_a_reset_while_its_set_pulse_still_stands(void)
{
    for (unsigned k = 0; k < 3u; k++)
    {
        (void)relay_step(&relay, 3, TRIBO_RELAY_SET1);
    }
    TEST_ASSERT_EQUAL_UINT8(TRIBO_RELAY_Q2, relay_step(&relay, 3, REST));
    TEST_ASSERT_EQUAL_UINT8(TRIBO_RELAY_Q2, relay_step(&relay, 3, REST | TRIBO_RELAY_RESET2));
    // The set pulse ends after three samples; the trigger falls and can rise again.
    for (unsigned k = 0; k < 5u; k++)
    {
        TEST_ASSERT_EQUAL_UINT8(TRIBO_RELAY_Q2, relay_step(&relay, 3, REST));
    }
    TEST_ASSERT_EQUAL_UINT8(0, relay_step(&relay, 3, REST | TRIBO_RELAY_RESET2));
}

static void test_relay_ignores_events_that_it_does_not_know(void)
{
    tribo_relay_latch_t latch = {0};
    TEST_ASSERT_EQUAL_UINT8(0, tribo_relay_latch_step(&latch, 0xf0));
}

static void test_relay_forgets_what_cannot_be(void)
{
    tribo_relay_latch_t latch = {0xfeu};
    TEST_ASSERT_EQUAL_UINT8(TRIBO_RELAY_Q2, tribo_relay_latch_step(&latch, 0));
    TEST_ASSERT_EQUAL_UINT8(TRIBO_RELAY_Q2, latch.held);
}

#include "runners/test_relay.inc" // main
