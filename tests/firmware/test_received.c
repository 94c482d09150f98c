// What a line's interrupt hands to the tick, and the stops that it counts.

#include "port/received.h"
#include "port/trip.h"
#include "unity.h"

static received_t ring;
static uint8_t    bytes[2u * RECEIVED_BYTES];

void setUp(void)
{
    ring = (received_t){.in = 0};
}

static void put(uint32_t from, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
    {
        received_put(&ring, (uint8_t)(from + i), true);
    }
}

static void test_bytes_come_in_their_order_also_where_the_ring_and_its_indices_wrap(void)
{
    ring.in = ring.out = UINT32_MAX - 100u;
    for (uint32_t from = 0; from < 600u; from += 43u)
    {
        put(from, 43u);
        TEST_ASSERT_EQUAL_INT(20, received_take(&ring, bytes, 20u));
        TEST_ASSERT_EQUAL_INT(23, received_take(&ring, bytes + 20, sizeof bytes - 20u));
        for (uint32_t i = 0; i < 43u; i++)
        {
            TEST_ASSERT_EQUAL_HEX8((uint8_t)(from + i), bytes[i]);
        }
    }
    TEST_ASSERT_EQUAL_INT(0, received_take(&ring, bytes, sizeof bytes));
}

static void test_a_full_ring_is_no_error_and_one_byte_more_is(void)
{
    put(0, RECEIVED_BYTES);
    TEST_ASSERT_EQUAL_INT((int)RECEIVED_BYTES, received_take(&ring, bytes, sizeof bytes));
    put(0, RECEIVED_BYTES + 1u);
    TEST_ASSERT_EQUAL_INT(MODBUS_LINE_ERROR, received_take(&ring, bytes, sizeof bytes));
    TEST_ASSERT_EQUAL_INT(0, received_take(&ring, bytes, sizeof bytes)); // all of them are gone
    put(7, 1);
    TEST_ASSERT_EQUAL_INT(1, received_take(&ring, bytes, sizeof bytes));
    TEST_ASSERT_EQUAL_HEX8(7, bytes[0]);
}

static void test_a_bad_byte_drops_the_received_bytes_and_is_reported_once(void)
{
    put(1, 3);
    received_put(&ring, 4, false);
    put(5, 3);
    TEST_ASSERT_EQUAL_INT(MODBUS_LINE_ERROR, received_take(&ring, bytes, sizeof bytes));
    TEST_ASSERT_EQUAL_INT(0, received_take(&ring, bytes, sizeof bytes));
}

static void test_a_stop_is_taken_once_also_where_its_count_wraps(void)
{
    trip_t trip = {.count = 0};
    TEST_ASSERT_FALSE(trip_take(&trip));
    for (int i = 0; i < 300; i++)
    {
        trip_count(&trip);
        TEST_ASSERT_TRUE(trip_has_come(&trip));
        TEST_ASSERT_TRUE(trip_take(&trip));
        TEST_ASSERT_FALSE(trip_has_come(&trip));
        TEST_ASSERT_FALSE(trip_take(&trip));
    }
}

#include "runners/test_received.inc" // main
