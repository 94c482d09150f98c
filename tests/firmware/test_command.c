// Commands over a serial line: a stop by one byte, a start by nothing less than its line.

#include "app/command.h"
#include "unity.h"

#include <string.h>

static command_reader_t reader;

void setUp(void)
{
    reader = (command_reader_t){0};
}

/// The last command of a text, COMMAND_NONE if there is none.
static command_t take(const char *text)
{
    command_t last = COMMAND_NONE;
    for (; *text != '\0'; text++)
    {
        const command_t command = command_take(&reader, (uint8_t)*text);
        last                    = command != COMMAND_NONE ? command : last;
    }
    return last;
}

static void test_each_line_is_its_command(void)
{
    TEST_ASSERT_EQUAL_INT(COMMAND_START, take("start\n"));
    TEST_ASSERT_EQUAL_INT(COMMAND_ACKNOWLEDGE, take("ack\r\n"));
    TEST_ASSERT_EQUAL_INT(COMMAND_REPORT, take("?\r"));
    TEST_ASSERT_EQUAL_INT(COMMAND_UP, take("+\n"));
    TEST_ASSERT_EQUAL_INT(COMMAND_DOWN, take("-\n"));
    TEST_ASSERT_EQUAL_INT(COMMAND_NONE, take("\n\r\n"));
    TEST_ASSERT_EQUAL_INT(COMMAND_START, take("\nstart\n"));
}

static void test_a_single_byte_is_a_stop_or_nothing(void)
{
    for (unsigned byte = 0; byte <= UINT8_MAX; byte++)
    {
        setUp();
        TEST_ASSERT_EQUAL_INT(byte == 'x' ? COMMAND_STOP : COMMAND_NONE, command_take(&reader, (uint8_t)byte));
    }
}

static void test_a_stop_acts_within_a_line_and_spoils_it(void)
{
    TEST_ASSERT_EQUAL_INT(COMMAND_NONE, take("sta"));
    TEST_ASSERT_EQUAL_INT(COMMAND_STOP, take("x"));
    TEST_ASSERT_EQUAL_INT(COMMAND_NONE, take("rt\n"));
    TEST_ASSERT_EQUAL_INT(COMMAND_STOP, take("xstart\n"));
    TEST_ASSERT_EQUAL_INT(COMMAND_STOP, take("a line that is too long x"));
    TEST_ASSERT_EQUAL_INT(COMMAND_START, take("\nstart\n"));
}

static void test_no_line_that_differs_in_a_byte_starts(void)
{
    const char *start = "start\n";
    for (size_t place = 0; place < 6; place++)
    {
        for (unsigned byte = 1; byte <= UINT8_MAX; byte++)
        {
            char changed[7];
            memcpy(changed, start, sizeof changed);
            changed[place] = (char)byte;
            if (byte == (uint8_t)start[place] || (place == 5 && byte == '\r'))
            {
                continue;
            }
            setUp();
            TEST_ASSERT_NOT_EQUAL_INT(COMMAND_START, take(changed));
        }
    }
}

static void test_no_line_with_a_byte_more_or_less_starts(void)
{
    static const char *const lines[] = {"tart\n",
                                        "sart\n",
                                        "strt\n",
                                        "stat\n",
                                        "star\n",
                                        "starts\n",
                                        "sstart\n",
                                        " start\n",
                                        "start \n",
                                        "start start\n"};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
    {
        setUp();
        TEST_ASSERT_EQUAL_INT(COMMAND_NONE, take(lines[i]));
    }
}

static void test_a_zero_byte_does_not_end_a_line(void)
{
    (void)take("ack");
    TEST_ASSERT_EQUAL_INT(COMMAND_NONE, command_take(&reader, 0));
    TEST_ASSERT_EQUAL_INT(COMMAND_NONE, take("\n"));
    TEST_ASSERT_EQUAL_INT(COMMAND_ACKNOWLEDGE, take("ack\n"));
}

static void test_a_long_line_keeps_its_terminator(void)
{
    (void)take("startstart");
    TEST_ASSERT_EQUAL_STRING("start", reader.line);
    TEST_ASSERT_EQUAL_CHAR('\0', reader.line[COMMAND_LENGTH_MAX]);
}

static void test_a_lost_byte_invalidates_only_its_line(void)
{
    (void)take("sta");
    command_spoil(&reader);
    TEST_ASSERT_EQUAL_INT(COMMAND_NONE, take("rt\n"));
    command_spoil(&reader);
    TEST_ASSERT_EQUAL_INT(COMMAND_NONE, take("start\n"));
    TEST_ASSERT_EQUAL_INT(COMMAND_START, take("start\n"));
}

static void test_half_a_line_ends_with_its_client(void)
{
    (void)take("sta");
    command_pause(&reader, COMMAND_SILENT_US); // somebody who types slowly
    TEST_ASSERT_EQUAL_INT(COMMAND_START, take("rt\n"));
    (void)take("sta");
    command_pause(&reader, COMMAND_SILENT_US + 1u);
    TEST_ASSERT_EQUAL_INT(COMMAND_NONE, take("rt\n"));
    (void)take("noise");
    command_pause(&reader, COMMAND_SILENT_US + 1u);
    TEST_ASSERT_EQUAL_INT(COMMAND_START, take("start\n"));
}

static void test_a_million_random_bytes_do_not_start(void)
{
    uint32_t random = 1; // xorshift32, seed 1
    for (unsigned i = 0; i < 1000000u; i++)
    {
        random ^= random << 13;
        random ^= random >> 17;
        random ^= random << 5;
        TEST_ASSERT_NOT_EQUAL_INT(COMMAND_START, command_take(&reader, (uint8_t)(random >> 24)));
    }
}

#include "runners/test_command.inc" // main
