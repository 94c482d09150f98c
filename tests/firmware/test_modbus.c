// The Modbus server: frames of the specification, refusals, the silence that ends a frame, and a million frames of which only
// those with the right CRC may change a register.

#include "app/crc16.h"
#include "app/modbus.h"
#include "runs.h"
#include "unity.h"

#include <string.h>

#define UNIT      0x11u
#define REGISTERS 200u ///< from address 0

typedef struct
{
    uint16_t        values[REGISTERS];
    unsigned        writes, stops;
    modbus_status_t refusal; ///< of every write
} map_t;

static modbus_t modbus;
static map_t    map;
static unsigned reads;

static modbus_status_t read_map(void *context, uint16_t address, uint16_t count, uint16_t *values)
{
    const map_t *from = context;
    reads++;
    TEST_ASSERT_TRUE((unsigned)address + count <= 0x10000u); // as the server promises
    if ((unsigned)address + count > REGISTERS)
    {
        return MODBUS_ILLEGAL_ADDRESS;
    }
    memcpy(values, from->values + address, count * sizeof *values);
    return MODBUS_OK;
}

static modbus_status_t write_map(void *context, uint16_t address, uint16_t count, const uint16_t *values)
{
    map_t *to = context;
    TEST_ASSERT_TRUE((unsigned)address + count <= 0x10000u); // as the server promises
    if ((unsigned)address + count > REGISTERS)
    {
        return MODBUS_ILLEGAL_ADDRESS;
    }
    if (to->refusal == MODBUS_OK)
    {
        memcpy(to->values + address, values, count * sizeof *values);
        to->writes++;
    }
    return to->refusal;
}

/// What clients that may only stop can do: write a 2 to register 1.
static modbus_status_t stop_map(void *context, uint16_t address, uint16_t count, const uint16_t *values)
{
    map_t     *to      = context;
    const bool is_stop = address == 1u && count == 1u && values[0] == 2u;
    to->stops += is_stop;
    return is_stop ? MODBUS_OK : MODBUS_BUSY;
}

static const modbus_registers_t registers = {.context = &map, .read = read_map, .write = write_map, .stop = stop_map};

void setUp(void)
{
    modbus_init(&modbus, UNIT, 115200, 1000);
    map   = (map_t){.refusal = MODBUS_OK};
    reads = 0;
    for (unsigned i = 0; i < REGISTERS; i++)
    {
        map.values[i] = (uint16_t)(0x1000u + i);
    }
}

/// Bit by bit, as the specification's appendix describes it.
static uint16_t slow_crc(const uint8_t *bytes, size_t size)
{
    unsigned crc = 0xffffu;
    for (size_t i = 0; i < size; i++)
    {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++)
        {
            crc = (crc & 1u) != 0u ? (crc >> 1) ^ 0xa001u : crc >> 1;
        }
    }
    return (uint16_t)crc;
}

static size_t seal(uint8_t *frame, size_t size)
{
    const uint16_t crc = slow_crc(frame, size);
    frame[size]        = (uint8_t)crc;
    frame[size + 1]    = (uint8_t)(crc >> 8);
    return size + 2;
}

/// Executes `request` of `size` bytes with its CRC added; the answer without its CRC, which is checked.
static size_t ask_as(modbus_source_t source, const uint8_t *request, size_t size, uint8_t *answer)
{
    uint8_t frame[MODBUS_FRAME_MAX + 2];
    memcpy(frame, request, size);
    const size_t length = modbus_execute(&modbus, &registers, source, frame, seal(frame, size), answer);
    if (length == 0)
    {
        return 0;
    }
    TEST_ASSERT_EQUAL_HEX16(slow_crc(answer, length - 2), answer[length - 2] | answer[length - 1] << 8);
    return length - 2;
}

static size_t ask(const uint8_t *request, size_t size, uint8_t *answer)
{
    return ask_as(MODBUS_MASTER, request, size, answer);
}

#define ASSERT_ANSWER(request, ...)                                                                                    \
    do                                                                                                                 \
    {                                                                                                                  \
        static const uint8_t expected[] = {__VA_ARGS__};                                                               \
        uint8_t              answer[MODBUS_FRAME_MAX];                                                                 \
        TEST_ASSERT_EQUAL_size_t(sizeof expected, ask(request, sizeof(request), answer));                              \
        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, answer, sizeof expected);                                               \
    } while (0)

#define REQUEST(...) ((const uint8_t[]){__VA_ARGS__})

static void test_the_crc_is_that_of_the_specification(void)
{
    TEST_ASSERT_EQUAL_HEX16(0x4b37, crc16((const uint8_t *)"123456789", 9));
    TEST_ASSERT_EQUAL_HEX16(0xffff, crc16((const uint8_t *)"", 0));
    TEST_ASSERT_EQUAL_HEX16(0x1241, crc16(REQUEST(2, 7), 2)); // the serial line guide's example
    for (unsigned byte = 0; byte <= UINT8_MAX; byte++)
    {
        const uint8_t bytes[3] = {(uint8_t)byte, 0x5a, (uint8_t)~byte};
        TEST_ASSERT_EQUAL_HEX16(slow_crc(bytes, 3), crc16(bytes, 3));
    }
}

// The four examples of the application protocol specification, with its addresses and values.

static void test_function_3_reads(void)
{
    map.values[0x6b] = 0x022b;
    map.values[0x6c] = 0x0000;
    map.values[0x6d] = 0x0064;
    ASSERT_ANSWER(REQUEST(UNIT, 3, 0x00, 0x6b, 0x00, 0x03), UNIT, 3, 6, 0x02, 0x2b, 0x00, 0x00, 0x00, 0x64);
}

static void test_function_6_writes_one(void)
{
    ASSERT_ANSWER(REQUEST(UNIT, 6, 0x00, 0x01, 0x00, 0x03), UNIT, 6, 0x00, 0x01, 0x00, 0x03);
    TEST_ASSERT_EQUAL_HEX16(0x1000, map.values[0]);
    TEST_ASSERT_EQUAL_HEX16(3, map.values[1]);
    TEST_ASSERT_EQUAL_HEX16(0x1002, map.values[2]);
}

static void test_function_16_writes_several(void)
{
    ASSERT_ANSWER(REQUEST(UNIT, 16, 0x00, 0x01, 0x00, 0x02, 4, 0x00, 0x0a, 0x01, 0x02),
                  UNIT,
                  16,
                  0x00,
                  0x01,
                  0x00,
                  0x02);
    TEST_ASSERT_EQUAL_HEX16(0x1000, map.values[0]);
    TEST_ASSERT_EQUAL_HEX16(0x000a, map.values[1]);
    TEST_ASSERT_EQUAL_HEX16(0x0102, map.values[2]);
    TEST_ASSERT_EQUAL_HEX16(0x1003, map.values[3]);
}

static void test_function_23_writes_and_then_reads(void)
{
    ASSERT_ANSWER(
        REQUEST(UNIT, 23, 0x00, 0x03, 0x00, 0x06, 0x00, 0x0e, 0x00, 0x03, 6, 0x00, 0xff, 0x00, 0xfe, 0x00, 0xfd),
        UNIT,
        23,
        12,
        0x10,
        3,
        0x10,
        4,
        0x10,
        5,
        0x10,
        6,
        0x10,
        7,
        0x10,
        8);
    TEST_ASSERT_EQUAL_HEX16(0x00ff, map.values[14]);
    TEST_ASSERT_EQUAL_HEX16(0x00fd, map.values[16]);
    ASSERT_ANSWER(REQUEST(UNIT, 23, 0, 20, 0, 1, 0, 20, 0, 1, 2, 0xab, 0xcd), UNIT, 23, 2, 0xab, 0xcd);
}

static void test_a_frame_of_the_greatest_size_fits(void)
{
    uint8_t answer[MODBUS_FRAME_MAX];
    TEST_ASSERT_EQUAL_size_t(253, ask(REQUEST(UNIT, 3, 0, 0, 0, 125), 6, answer));
    uint8_t request[7 + 2 * MODBUS_WRITE_MAX] = {UNIT, 16, 0, 0, 0, MODBUS_WRITE_MAX, 2 * MODBUS_WRITE_MAX};
    TEST_ASSERT_EQUAL_size_t(6, ask(request, sizeof request, answer));
    TEST_ASSERT_EQUAL_HEX16(0, map.values[MODBUS_WRITE_MAX - 1]);
    TEST_ASSERT_EQUAL_HEX16(0x1000 + MODBUS_WRITE_MAX, map.values[MODBUS_WRITE_MAX]);
}

static void test_wrong_requests_get_the_specifications_exceptions(void)
{
    ASSERT_ANSWER(REQUEST(UNIT, 4, 0, 0, 0, 1), UNIT, 0x84, 1);           // another function
    ASSERT_ANSWER(REQUEST(UNIT, 3, 0, 0, 0, 0), UNIT, 0x83, 3);           // no register
    ASSERT_ANSWER(REQUEST(UNIT, 3, 0, 0, 0, 126), UNIT, 0x83, 3);         // too many
    ASSERT_ANSWER(REQUEST(UNIT, 3, 0, 0, 0, 1, 0), UNIT, 0x83, 3);        // a byte too many
    ASSERT_ANSWER(REQUEST(UNIT, 3, 0, 0, 0), UNIT, 0x83, 3);              // one too few
    ASSERT_ANSWER(REQUEST(UNIT, 3, 0, 199, 0, 2), UNIT, 0x83, 2);         // beyond the map
    ASSERT_ANSWER(REQUEST(UNIT, 3, 0xff, 0xff, 0, 2), UNIT, 0x83, 2);     // beyond the last address
    ASSERT_ANSWER(REQUEST(UNIT, 6, 0, 200, 0, 2), UNIT, 0x86, 2);         // beyond the map
    ASSERT_ANSWER(REQUEST(UNIT, 6, 0, 1, 0), UNIT, 0x86, 3);              // half a value
    ASSERT_ANSWER(REQUEST(UNIT, 16, 0, 0, 0, 0, 0), UNIT, 0x90, 3);       // no register
    ASSERT_ANSWER(REQUEST(UNIT, 16, 0, 0, 0, 1, 4, 1, 2), UNIT, 0x90, 3); // counts that contradict each other
    ASSERT_ANSWER(REQUEST(UNIT, 16, 0, 0, 0, 2, 4, 1, 2), UNIT, 0x90, 3); // a value missing
    ASSERT_ANSWER(REQUEST(UNIT, 16, 0, 199, 0, 2, 4, 1, 2, 3, 4), UNIT, 0x90, 2);
    ASSERT_ANSWER(REQUEST(UNIT, 16, 0xff, 0xff, 0, 2, 4, 1, 2, 3, 4), UNIT, 0x90, 2);
    ASSERT_ANSWER(REQUEST(UNIT, 23, 0, 0, 0, 0, 0, 0, 0, 1, 2, 1, 2), UNIT, 0x97, 3); // reads none
    ASSERT_ANSWER(REQUEST(UNIT, 23, 0, 0, 0, 1, 0, 0, 0, 1, 3, 1, 2), UNIT, 0x97, 3);
    ASSERT_ANSWER(REQUEST(UNIT, 23, 0, 200, 0, 1, 0, 0, 0, 1, 2, 1, 2), UNIT, 0x97, 2); // what it reads is not there
    TEST_ASSERT_EQUAL_UINT(0, map.writes);
    TEST_ASSERT_EQUAL_UINT32(17, modbus.exceptions);
}

static void test_what_the_registers_refuse_becomes_their_exception(void)
{
    map.refusal = MODBUS_BUSY;
    ASSERT_ANSWER(REQUEST(UNIT, 6, 0, 1, 0, 2), UNIT, 0x86, 6);
    ASSERT_ANSWER(REQUEST(UNIT, 23, 0, 0, 0, 1, 0, 0, 0, 1, 2, 1, 2), UNIT, 0x97, 6);
}

static void test_a_broadcast_stops_and_does_nothing_else(void)
{
    uint8_t answer[MODBUS_FRAME_MAX];
    TEST_ASSERT_EQUAL_size_t(0, ask(REQUEST(0, 6, 0, 1, 0, 2), 6, answer));
    TEST_ASSERT_EQUAL_size_t(0, ask(REQUEST(0, 16, 0, 1, 0, 1, 2, 0, 2), 9, answer));
    TEST_ASSERT_EQUAL_UINT(2, map.stops);
    TEST_ASSERT_EQUAL_UINT32(2, modbus.frames);
    TEST_ASSERT_EQUAL_size_t(0, ask(REQUEST(0, 6, 0, 1, 0, 1), 6, answer)); // a start
    TEST_ASSERT_EQUAL_size_t(0, ask(REQUEST(0, 6, 0, 2, 0, 2), 6, answer));
    TEST_ASSERT_EQUAL_size_t(0, ask(REQUEST(0, 16, 0, 1, 0, 2, 4, 0, 2, 0, 2), 11, answer));
    TEST_ASSERT_EQUAL_size_t(0, ask(REQUEST(0, 16, 0, 1, 0, 1, 4, 0, 2), 9, answer));
    TEST_ASSERT_EQUAL_UINT32(6, modbus.frames);
    TEST_ASSERT_EQUAL_size_t(0, ask(REQUEST(0, 3, 0, 1, 0, 2), 6, answer));
    TEST_ASSERT_EQUAL_size_t(0, ask(REQUEST(0, 23, 0, 0, 0, 1, 0, 1, 0, 1, 2, 0, 2), 13, answer));
    TEST_ASSERT_EQUAL_size_t(0, ask(REQUEST(0, 8, 0, 0, 0x12, 0x34), 6, answer));
    TEST_ASSERT_EQUAL_UINT32(6, modbus.frames);
    TEST_ASSERT_EQUAL_UINT(2, map.stops);
    TEST_ASSERT_EQUAL_UINT(0, map.writes);
    TEST_ASSERT_EQUAL_UINT(0, reads);
    TEST_ASSERT_EQUAL_UINT32(0, modbus.exceptions); // nobody answers
    TEST_ASSERT_EQUAL_UINT32(0, modbus.heard);
}

static void test_a_guest_stops_and_does_nothing_else(void)
{
    uint8_t answer[MODBUS_FRAME_MAX];
    TEST_ASSERT_EQUAL_size_t(6, ask_as(MODBUS_GUEST, REQUEST(UNIT, 6, 0, 1, 0, 2), 6, answer));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(REQUEST(UNIT, 6, 0, 1, 0, 2), answer, 6);
    TEST_ASSERT_EQUAL_size_t(6, ask_as(MODBUS_GUEST, REQUEST(UNIT, 16, 0, 1, 0, 1, 2, 0, 2), 9, answer));
    TEST_ASSERT_EQUAL_UINT(2, map.stops);
    TEST_ASSERT_EQUAL_UINT32(0, modbus.exceptions);
    TEST_ASSERT_EQUAL_size_t(3, ask_as(MODBUS_GUEST, REQUEST(UNIT, 6, 0, 1, 0, 1), 6, answer));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(REQUEST(UNIT, 0x86, MODBUS_BUSY), answer, 3);
    TEST_ASSERT_EQUAL_size_t(3, ask_as(MODBUS_GUEST, REQUEST(UNIT, 3, 0, 1, 0, 1), 6, answer));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(REQUEST(UNIT, 0x83, MODBUS_BUSY), answer, 3);
    TEST_ASSERT_EQUAL_size_t(3, ask_as(MODBUS_GUEST, REQUEST(UNIT, 23, 0, 0, 0, 1, 0, 1, 0, 1, 2, 0, 2), 13, answer));
    TEST_ASSERT_EQUAL_UINT(3, map.stops); // acts, and what it would read is refused
    TEST_ASSERT_EQUAL_UINT(0, map.writes);
    TEST_ASSERT_EQUAL_UINT(0, reads);
    TEST_ASSERT_EQUAL_UINT32(3, modbus.exceptions);
    TEST_ASSERT_EQUAL_UINT32(0, modbus.heard); // the client that has the drive is another one
}

static void test_what_is_late_reads_or_stops(void)
{
    uint8_t answer[MODBUS_FRAME_MAX];
    TEST_ASSERT_EQUAL_size_t(3, ask_as(MODBUS_LATE, REQUEST(UNIT, 6, 0, 1, 0, 1), 6, answer));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(REQUEST(UNIT, 0x86, MODBUS_BUSY), answer, 3);
    TEST_ASSERT_EQUAL_size_t(6, ask_as(MODBUS_LATE, REQUEST(UNIT, 6, 0, 1, 0, 2), 6, answer));
    TEST_ASSERT_EQUAL_size_t(5, ask_as(MODBUS_LATE, REQUEST(UNIT, 3, 0, 1, 0, 1), 6, answer));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(REQUEST(UNIT, 3, 2, 0x10, 0x01), answer, 5);
    TEST_ASSERT_EQUAL_UINT(0, map.writes);
    TEST_ASSERT_EQUAL_UINT(1, map.stops);
}

/// All other functions are illegal, on a line and without a frame (over TCP).
static void test_every_other_function_is_illegal(void)
{
    uint8_t answer[MODBUS_FRAME_MAX];
    for (unsigned function = 0; function <= UINT8_MAX; function++)
    {
        const uint8_t request[] = {UNIT, (uint8_t)function, 0, 0, 0, 1};
        const bool    is_known  = function == 3u || function == 6u || function == 16u || function == 23u;
        for (size_t size = 2; !is_known && size <= sizeof request; size++)
        {
            TEST_ASSERT_EQUAL_size_t(3, ask(request, size, answer));
            TEST_ASSERT_EQUAL_HEX8_ARRAY(REQUEST(UNIT, (uint8_t)(function | 0x80u), 1), answer, 3);
            TEST_ASSERT_EQUAL_size_t(2,
                                     modbus_answer(&modbus, &registers, MODBUS_MASTER, request + 1, size - 1u, answer));
            TEST_ASSERT_EQUAL_HEX8_ARRAY(REQUEST((uint8_t)(function | 0x80u), 1), answer, 2);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0, modbus.bad_frames);
}

static void test_a_frame_for_another_unit_is_not_ours(void)
{
    uint8_t answer[MODBUS_FRAME_MAX];
    for (unsigned unit = 1; unit <= UINT8_MAX; unit++)
    {
        const size_t length = ask(REQUEST((uint8_t)unit, 6, 0, 1, 0, 2), 6, answer);
        TEST_ASSERT_EQUAL_size_t(unit == UNIT ? 6 : 0, length);
    }
    TEST_ASSERT_EQUAL_UINT(1, map.writes);
    TEST_ASSERT_EQUAL_UINT32(1, modbus.frames);
    TEST_ASSERT_EQUAL_UINT32(0, modbus.bad_frames);
}

// --- the line ------------------------------------------------------------------------------------------------------

typedef struct
{
    uint8_t in[512], out[512], stray[512];
    size_t  in_length, in_taken, out_length, stray_length;
    size_t  room;  ///< that send takes at a time
    bool    error; ///< once
} wire_t;

static wire_t wire;

static int receive(void *context, uint8_t *bytes, size_t room)
{
    wire_t *from = context;
    if (from->error)
    {
        from->error = false;
        return MODBUS_LINE_ERROR;
    }
    const size_t left  = from->in_length - from->in_taken;
    const size_t count = left < room ? left : room;
    memcpy(bytes, from->in + from->in_taken, count);
    from->in_taken += count;
    return (int)count;
}

static size_t send(void *context, const uint8_t *bytes, size_t count)
{
    wire_t      *to    = context;
    const size_t taken = count < to->room ? count : to->room;
    memcpy(to->out + to->out_length, bytes, taken);
    to->out_length += taken;
    return taken;
}

static void take_stray(void *context, const uint8_t *bytes, size_t count)
{
    wire_t *to = context;
    memcpy(to->stray + to->stray_length, bytes, count);
    to->stray_length += count;
}

static const modbus_line_t line = {.context = &wire, .receive = receive, .send = send, .stray = take_stray};

static void tick(const uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++)
    {
        wire.in[i] = bytes[i];
    }
    wire.in_length = count;
    wire.in_taken  = 0;
    modbus_take(&modbus, &line);
    modbus_serve(&modbus, &line, &registers, MODBUS_MASTER);
}

static void silence(unsigned ticks)
{
    for (unsigned i = 0; i < ticks; i++)
    {
        tick(NULL, 0);
    }
}

static void reset_line(void)
{
    wire = (wire_t){.room = sizeof wire.out};
    silence(5);
}

static void test_a_silence_of_two_ticks_ends_a_frame(void)
{
    uint8_t      frame[8] = {UNIT, 6, 0, 1, 0, 2};
    const size_t length   = seal(frame, 6);
    reset_line();
    tick(frame, 3);
    silence(1); // within a frame a tick may pass without a byte
    tick(frame + 3, length - 3);
    silence(1);
    TEST_ASSERT_EQUAL_UINT(0, map.writes);
    silence(1);
    TEST_ASSERT_EQUAL_UINT(1, map.writes);
    TEST_ASSERT_EQUAL_size_t(8, wire.out_length);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(frame, wire.out, 8);
    silence(100); // executed and answered once
    TEST_ASSERT_EQUAL_UINT(1, map.writes);
    TEST_ASSERT_EQUAL_size_t(8, wire.out_length);
}

static void test_the_silence_is_of_3_5_characters_at_each_rate(void)
{
    static const struct
    {
        uint32_t baud, period_us, ticks;
    } rates[] = {{115200, 1000, 2},
                 {115200, 100, 18},
                 {115200, 5000, 1},
                 {19200, 1000, 3},
                 {9600, 1000, 5},
                 {9600, 500, 9},
                 {115200, 1750, 1},
                 {115200, 0, 1750},
                 {115200, UINT32_MAX, 1}}; // the last two: of a config that is refused
    for (size_t i = 0; i < sizeof rates / sizeof rates[0]; i++)
    {
        modbus_init(&modbus, UNIT, rates[i].baud, rates[i].period_us);
        TEST_ASSERT_EQUAL_UINT32(rates[i].ticks, modbus.silent_ticks);
    }
}

static void test_a_frame_cut_by_silence_is_two_bad_ones(void)
{
    uint8_t frame[8] = {UNIT, 6, 0, 1, 0, 2};
    (void)seal(frame, 6);
    reset_line();
    tick(frame, 4);
    silence(2);
    tick(frame + 4, 4);
    silence(2);
    TEST_ASSERT_EQUAL_UINT(0, map.writes);
    TEST_ASSERT_EQUAL_UINT32(2, modbus.bad_frames);
}

static void test_a_line_error_spoils_its_frame_only(void)
{
    uint8_t frame[8] = {UNIT, 6, 0, 1, 0, 2};
    (void)seal(frame, 6);
    for (int where = 0; where < 2; where++)
    {
        setUp();
        reset_line();
        tick(frame, where == 0 ? 0 : 8);
        wire.error = true;
        tick(NULL, 0);
        tick(frame, where == 0 ? 8 : 0);
        silence(3);
        TEST_ASSERT_EQUAL_UINT(0, map.writes);
        tick(frame, 8);
        silence(2);
        TEST_ASSERT_EQUAL_UINT(1, map.writes);
    }
}

static void test_more_bytes_than_a_frame_has_are_ignored_up_to_a_silence(void)
{
    uint8_t noise[64];
    memset(noise, 0x55, sizeof noise);
    uint8_t frame[8] = {UNIT, 6, 0, 1, 0, 2};
    (void)seal(frame, 6);
    reset_line();
    for (int i = 0; i < 10; i++)
    {
        tick(noise, sizeof noise);
    }
    tick(frame, 8);
    silence(2);
    TEST_ASSERT_EQUAL_UINT(0, map.writes);
    TEST_ASSERT_EQUAL_size_t(0, wire.out_length);
    tick(frame, 8);
    silence(2);
    TEST_ASSERT_EQUAL_UINT(1, map.writes);
}

static void test_what_comes_while_a_frame_is_executed_is_not_mixed_into_it(void)
{
    uint8_t frame[8] = {UNIT, 6, 0, 1, 0, 2};
    uint8_t other[8] = {UNIT, 6, 0, 1, 0, 3};
    (void)seal(frame, 6);
    (void)seal(other, 6);
    reset_line();
    memcpy(wire.in, frame, 8);
    wire.in_length = 8;
    for (int i = 0; i < 3; i++)
    {
        modbus_take(&modbus, &line); // the background does not run
    }
    TEST_ASSERT_TRUE(modbus.complete);
    memcpy(wire.in, other, 8);
    wire.in_taken = 0;
    modbus_take(&modbus, &line);
    modbus_serve(&modbus, &line, &registers, MODBUS_MASTER);
    TEST_ASSERT_EQUAL_HEX16(2, map.values[1]);
    silence(2);
    TEST_ASSERT_EQUAL_HEX16(2, map.values[1]);
    tick(other, 8);
    silence(2);
    TEST_ASSERT_EQUAL_HEX16(3, map.values[1]);
}

/// The tick that completes it may come between any two instructions of the background.
static void test_what_is_no_frame_is_passed_on_once_it_is_complete_or_counts_as_lost(void)
{
    uint8_t frame[8] = {UNIT, 6, 0, 1, 0, 2};
    (void)seal(frame, 6);
    reset_line();
    tick((const uint8_t *)"ac", 2);
    tick((const uint8_t *)"k\n", 2);
    TEST_ASSERT_EQUAL_size_t(0, wire.stray_length);
    silence(2);
    TEST_ASSERT_EQUAL_size_t(4, wire.stray_length);
    TEST_ASSERT_EQUAL_MEMORY("ack\n", wire.stray, 4);
    tick(frame, 8);
    silence(2);
    TEST_ASSERT_EQUAL_size_t(4, wire.stray_length);
    TEST_ASSERT_EQUAL_HEX16(2, map.values[1]);
    TEST_ASSERT_FALSE(modbus.lost);

    memcpy(wire.in, "?", 1);
    wire.in_length = 1;
    wire.in_taken  = 0;
    for (int i = 0; i < 3; i++)
    {
        modbus_take(&modbus, &line); // the background does not run
    }
    TEST_ASSERT_FALSE(modbus.lost);
    wire.in[0]    = 'x';
    wire.in_taken = 0;
    modbus_take(&modbus, &line);
    TEST_ASSERT_TRUE(modbus.lost);
    silence(2);
    TEST_ASSERT_EQUAL_size_t(5, wire.stray_length);
    TEST_ASSERT_EQUAL_CHAR('?', wire.stray[4]);
    modbus.lost = false;
    wire.error  = true;
    tick(NULL, 0);
    TEST_ASSERT_TRUE(modbus.lost);
}

/// A start in plain text as well, after whatever kept the drive from answering.
static void test_what_is_late_and_no_frame_counts_as_lost(void)
{
    reset_line();
    memcpy(wire.in, "start\n", 6);
    wire.in_length = 6;
    for (int i = 0; i < 3; i++)
    {
        modbus_take(&modbus, &line); // the background does not run
    }
    modbus_serve(&modbus, &line, &registers, MODBUS_LATE);
    TEST_ASSERT_TRUE(modbus.lost);
    TEST_ASSERT_EQUAL_size_t(0, wire.stray_length);
    TEST_ASSERT_FALSE(modbus.complete);
}

static void test_an_answer_leaves_as_the_line_takes_it(void)
{
    uint8_t frame[8] = {UNIT, 3, 0, 0, 0, 10};
    (void)seal(frame, 6);
    reset_line();
    wire.room = 1;
    tick(frame, 8);
    silence(2);
    TEST_ASSERT_EQUAL_size_t(1, wire.out_length);
    silence(23);
    TEST_ASSERT_EQUAL_size_t(24, wire.out_length);
    silence(10);
    TEST_ASSERT_EQUAL_size_t(25, wire.out_length);
    TEST_ASSERT_EQUAL_HEX16(slow_crc(wire.out, 23), wire.out[23] | wire.out[24] << 8);
}

// --- a million frames ----------------------------------------------------------------------------------------------

#define FUZZED_FRAMES RUNS(1000000u, 20000u)

static uint32_t random_state = 1; // xorshift32, seed 1

static uint32_t random_up_to(uint32_t limit)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state % (limit + 1u);
}

/// A good request, then with some of its bytes changed, cut, or with bytes added; with its CRC or without.
static size_t random_frame(uint8_t *frame)
{
    static const uint8_t functions[] = {3, 6, 16, 23};
    const uint8_t        count       = (uint8_t)(1u + random_up_to(10));
    const uint8_t        function    = functions[random_up_to(3)];
    size_t               size        = 0;
    for (size_t i = 0; i < MODBUS_FRAME_MAX; i++)
    {
        frame[i] = (uint8_t)random_up_to(UINT8_MAX);
    }
    memcpy(frame,
           ((const uint8_t[]){random_up_to(9) == 0 ? 0 : UNIT, function, 0, (uint8_t)random_up_to(210), 0, count}),
           6);
    size = 6;
    if (function == 16)
    {
        frame[6] = (uint8_t)(2 * count);
        size     = 7u + 2u * count;
    }
    else if (function == 23)
    {
        memcpy(frame + 6, ((const uint8_t[]){0, (uint8_t)random_up_to(210), 0, count, (uint8_t)(2 * count)}), 5);
        size = 11u + 2u * count;
    }
    size = random_up_to(3) == 0 ? random_up_to(MODBUS_FRAME_MAX - 2) : size;
    for (uint32_t changes = random_up_to(3) == 0 ? random_up_to(3) : 0; changes > 0; changes--)
    {
        frame[random_up_to(20)] = (uint8_t)random_up_to(UINT8_MAX);
    }
    if (random_up_to(1) == 0)
    {
        size = seal(frame, size);
        if (random_up_to(1) == 0 && size > 0)
        {
            frame[random_up_to((uint32_t)size - 1u)] ^= (uint8_t)(1u << random_up_to(7));
        }
    }
    return size;
}

static void test_a_million_frames_change_nothing_without_their_crc(void)
{
    unsigned right = 0;
    for (unsigned i = 0; i < FUZZED_FRAMES; i++)
    {
        uint8_t      frame[MODBUS_FRAME_MAX + 2];
        uint8_t      answer[MODBUS_FRAME_MAX];
        const size_t size   = random_frame(frame);
        const map_t  before = map;
        const bool   valid  = size >= 4 && slow_crc(frame, size - 2) == (frame[size - 2] | frame[size - 1] << 8);
        const size_t length = modbus_execute(&modbus, &registers, MODBUS_MASTER, frame, size, answer);
        if (!valid || (frame[0] != UNIT && frame[0] != 0))
        {
            TEST_ASSERT_EQUAL_size_t(0, length);
            TEST_ASSERT_EQUAL_MEMORY(&before, &map, sizeof map);
            continue;
        }
        right++;
        TEST_ASSERT_TRUE(length == 0 ? frame[0] == 0 : frame[0] == UNIT);
        if (length > 0)
        {
            TEST_ASSERT_EQUAL_HEX16(slow_crc(answer, length - 2), answer[length - 2] | answer[length - 1] << 8);
            TEST_ASSERT_EQUAL_HEX8(frame[1] | 0x80, answer[1] | 0x80);
            TEST_ASSERT_TRUE((answer[1] & 0x80) == 0 || memcmp(&before, &map, sizeof map) == 0);
        }
        if (frame[1] == 3)
        {
            TEST_ASSERT_EQUAL_MEMORY(&before, &map, sizeof map);
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT(FUZZED_FRAMES / 8, right);
    TEST_ASSERT_GREATER_THAN_UINT(FUZZED_FRAMES / 20, map.writes);
}

#include "runners/test_modbus.inc" // main
