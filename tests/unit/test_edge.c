#include "csv.h"
#include "friction/relay.h"
#include "tribo/friction_f32.h"
#include "unity.h"

static tribo_edge_state_t edge;

void setUp(void)
{
    edge_reset(&edge, 0);
}

static void test_edge_gives_the_golden_pulses_for_an_input_that_toggles_fast(void)
{
    csv_t csv;
    csv_open(&csv, "edge_w3.csv", "x,pulse");
    while (csv_next(&csv))
    {
        const uint8_t x = (uint8_t)csv.value[0];
        TEST_ASSERT_EQUAL_UINT8_MESSAGE((uint8_t)csv.value[1], edge_step(&edge, 3, x), "row");
    }
    TEST_ASSERT_EQUAL_INT(2000, csv.rows);
}

static void test_edge_makes_a_pulse_of_every_width(void)
{
    for (uint8_t width = 1; width <= TRIBO_EDGE_WIDTH_MAX; width++)
    {
        edge_reset(&edge, 0);
        for (unsigned k = 0; k < 200u; k++)
        {
            const uint8_t expected = k >= 100u && k < 100u + width;
            TEST_ASSERT_EQUAL_UINT8(expected, edge_step(&edge, width, k >= 100u));
        }
    }
}

static void test_edge_sees_no_rise_in_a_line_that_rested_high(void)
{
    edge_reset(&edge, 1);
    for (unsigned k = 0; k < 70u; k++)
    {
        TEST_ASSERT_EQUAL_UINT8(0, edge_step(&edge, 3, 1));
    }
    TEST_ASSERT_EQUAL_UINT8(0, edge_step(&edge, 3, 0));
    TEST_ASSERT_EQUAL_UINT8(0, edge_step(&edge, 3, 1));
    TEST_ASSERT_EQUAL_UINT8(0, edge_step(&edge, 3, 1));
    TEST_ASSERT_EQUAL_UINT8(1, edge_step(&edge, 3, 1)); // compared with the low sample three ago
}

static void test_edge_keeps_its_eight_inputs_apart(void)
{
    edge_reset(&edge, 0xf0);
    TEST_ASSERT_EQUAL_UINT8(0x05, edge_step(&edge, 2, 0xa5));
    TEST_ASSERT_EQUAL_UINT8(0x0f, edge_step(&edge, 2, 0xff));
    TEST_ASSERT_EQUAL_UINT8(0x5a, edge_step(&edge, 2, 0xff));
    TEST_ASSERT_EQUAL_UINT8(0x00, edge_step(&edge, 2, 0xff));
}

static void test_edge_keeps_the_past_when_the_width_changes(void)
{
    (void)edge_step(&edge, 1, 1);
    for (unsigned k = 0; k < 9u; k++)
    {
        (void)edge_step(&edge, 1, 1);
    }
    TEST_ASSERT_EQUAL_UINT8(1, edge_step(&edge, 11, 1)); // low before the first step
    TEST_ASSERT_EQUAL_UINT8(0, edge_step(&edge, 11, 1));
}

static void test_edge_stays_inside_its_line_when_width_or_head_are_out_of_range(void)
{
    edge.head = 255;
    TEST_ASSERT_EQUAL_UINT8(1, edge_step(&edge, 3, 1));
    TEST_ASSERT_EQUAL_UINT8(64, edge.head);
    TEST_ASSERT_EQUAL_UINT8(0, edge_step(&edge, 64, 1)); // as width 0: against itself
    TEST_ASSERT_EQUAL_UINT8(0, edge_step(&edge, 0, 1));
}

#include "runners/test_edge.inc" // main
