// Frames out of bytes that come in any pieces, with noise, and with what other units ask and answer on the same line.

#include "rtu.h"

#include "app/crc16.h"
#include "unity.h"

#include <string.h>

#define FRAMES_MAX 64u

static rtu_t       rtu;
static rtu_frame_t found[FRAMES_MAX];
static unsigned    count;

void setUp(void)
{
    rtu   = (rtu_t){0};
    count = 0;
}

static void take(bool is_silent)
{
    rtu_frame_t frame;
    while (rtu_take(&rtu, is_silent, &frame))
    {
        TEST_ASSERT_TRUE(count < FRAMES_MAX);
        found[count++] = frame;
    }
}

static void put(const uint8_t *bytes, size_t size)
{
    while (size > 0u)
    {
        size_t       room;
        uint8_t     *to   = rtu_room(&rtu, &room);
        const size_t part = size < room ? size : room;
        TEST_ASSERT_TRUE(room >= MODBUS_FRAME_MAX);
        memcpy(to, bytes, part);
        rtu.length += part;
        bytes += part;
        size -= part;
        take(false);
    }
}

/// Adds a CRC; returns the size with it.
static size_t seal(uint8_t *frame, size_t size)
{
    const uint16_t crc = crc16(frame, size);
    frame[size]        = (uint8_t)crc;
    frame[size + 1u]   = (uint8_t)(crc >> 8);
    return size + 2u;
}

#define READ  1, 3, 0, 6, 0, 2
#define STOP  1, 6, 1, 0, 0, 2
#define START 1, 6, 1, 0, 0, 1

/// What a line carries, and how many frames that is.
static size_t make_talk(uint8_t *bytes, unsigned *frames)
{
    static const struct
    {
        uint8_t bytes[64];
        size_t  size;
    } talk[] = {{{READ}, 6},
                {{1, 16, 1, 16, 0, 2, 4, 0x3f, 0, 0, 0}, 11},          // write several
                {{2, 3, 0, 0, 0, 9}, 6},                               // of another unit: asked ...
                {{2, 3, 18, START, 0xdd, 0x36, STOP, 0, 0, 0, 0}, 21}, // ... and answered, with a start for us in it
                {{2, 4, 0, 0, 0, 1}, 6},
                {{2, 4, 2, 0x12, 0x34}, 5},
                {{2, 0x83, 2}, 3},
                {{2, 16, 0, 0, 0, 2}, 6}, // the answer of a write
                {{2, 43, 14, 1, 0}, 5},
                {{1, 23, 2, 0, 0, 2, 1, 18, 0, 2, 4, 0, 0, 0, 0}, 15}, // both
                {{2, 23, 4, 1, 2, 3, 4}, 7},
                {{1, 8, 0, 0, 0x12, 0x34}, 6},
                {{1, 7}, 2}, // the shortest
                {{0, 6, 1, 0, 0, 2}, 6},
                {{1, 3, 0, 6, 0}, 5}, // a byte too few
                {{STOP}, 6}};

    size_t size = 0;
    *frames     = sizeof talk / sizeof talk[0];
    for (unsigned i = 0; i < *frames; i++)
    {
        memcpy(bytes + size, talk[i].bytes, talk[i].size);
        size += seal(bytes + size, talk[i].size);
    }
    return size;
}

static void check_talk(const uint8_t *bytes, unsigned frames)
{
    size_t at = 0;
    for (unsigned i = 0; i < count; i++)
    {
        TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes + at, found[i].bytes, found[i].length);
        TEST_ASSERT_TRUE(found[i].is_awaited && !found[i].is_late);
        at += found[i].length;
    }
    TEST_ASSERT_EQUAL_UINT(frames, count);
    TEST_ASSERT_EQUAL_UINT32(0, rtu.torn);
    TEST_ASSERT_EQUAL_size_t(0, rtu.length);
}

/// A USB adapter may make any pieces of a frame, without a silence between them.
static void test_frames_are_found_in_any_pieces(void)
{
    uint8_t      bytes[512];
    unsigned     frames;
    const size_t size = make_talk(bytes, &frames);
    for (size_t piece = 1; piece <= size; piece++)
    {
        setUp();
        for (size_t at = 0; at < size; at += piece)
        {
            put(bytes + at, at + piece < size ? piece : size - at);
        }
        check_talk(bytes, frames);
    }
    for (size_t first = 1; first < size; first++)
    {
        setUp();
        put(bytes, first);
        put(bytes + first, size - first);
        check_talk(bytes, frames);
    }
}

static uint32_t random_state = 5;

static uint8_t random_byte(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return (uint8_t)(random_state >> 8);
}

/// Noise of `kind`; of each there are bytes that look like the beginning of a long frame.
static void make_noise(uint8_t *bytes, size_t size, unsigned kind)
{
    static const uint8_t begins[] = {1, 16, 0, 0, 0, 100, 200};
    for (size_t i = 0; i < size; i++)
    {
        bytes[i] = kind == 0u ? 0xff : kind == 1u ? 0 : kind == 2u ? begins[i % sizeof begins] : random_byte();
    }
}

static void test_after_noise_of_any_length_the_next_request_is_found(void)
{
    uint8_t request[8] = {READ};
    uint8_t noise[600];
    (void)seal(request, 6);
    unsigned chance = 0;
    for (unsigned kind = 0; kind < 4u; kind++)
    {
        for (size_t size = 1; size <= sizeof noise; size++)
        {
            for (int pause = 0; pause < 2; pause++)
            {
                setUp();
                make_noise(noise, size, kind);
                put(noise, size);
                if (pause > 0)
                {
                    take(true);
                    TEST_ASSERT_EQUAL_size_t(0, rtu.length);
                }
                put(request, sizeof request);
                take(true);
                TEST_ASSERT_TRUE(count > 0u); // by chance a part of random noise is a frame, too
                TEST_ASSERT_EQUAL_HEX8_ARRAY(request, found[count - 1u].bytes, sizeof request);
                TEST_ASSERT_TRUE(found[count - 1u].is_awaited);
                TEST_ASSERT_TRUE(rtu.torn == 1u || (kind == 3u && count > 1u)); // however long it is
                chance += count - 1u;
            }
        }
    }
    TEST_ASSERT_TRUE(chance < 24u); // of 1200
}

/// Its values do not become frames after noise or at a silence either.
static void test_after_noise_another_units_values_are_no_frames(void)
{
    static const uint8_t answers[][3] = {{2, 3, 16}, {2, 23, 16}};
    for (unsigned i = 0; i < 2u; i++)
    {
        uint8_t answer[32];
        memcpy(answer, answers[i], 3);
        memcpy(answer + 3, (const uint8_t[]){START}, 6);
        (void)seal(answer + 3, 6);
        memcpy(answer + 11, answer + 3, 8);
        const size_t size = seal(answer, 19);
        setUp();
        put((const uint8_t[]){0xff, 0x55, 0xff}, 3);
        put(answer, size);
        take(true);
        TEST_ASSERT_EQUAL_UINT(1, count);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(answer, found[0].bytes, size);
    }
}

/// Without a silence noise ends after a frame's length, and of what has piled up behind it only the last is still awaited.
static void test_without_a_silence_old_requests_are_not_awaited(void)
{
    uint8_t noise[250];
    uint8_t requests[64];
    make_noise(noise, sizeof noise, 0);
    for (size_t i = 0; i < 8u; i++)
    {
        memcpy(requests + 8u * i, (const uint8_t[]){START}, 6);
        (void)seal(requests + 8u * i, 6);
    }
    put(noise, sizeof noise);
    put(requests, sizeof requests);
    take(true);
    TEST_ASSERT_EQUAL_UINT(8, count);
    TEST_ASSERT_FALSE(found[0].is_awaited);
    TEST_ASSERT_TRUE(found[7].is_awaited);
}

static void test_half_a_frame_is_dropped_at_a_silence(void)
{
    uint8_t request[8] = {STOP};
    (void)seal(request, 6);
    for (size_t half = 1; half < sizeof request; half++)
    {
        setUp();
        put(request, half);
        take(false);
        TEST_ASSERT_EQUAL_size_t(half, rtu.length); // the rest may come
        take(true);
        put(request + half, sizeof request - half);
        take(true);
        TEST_ASSERT_EQUAL_UINT(0, count);
        TEST_ASSERT_EQUAL_UINT32(2, rtu.torn);
        put(request, sizeof request);
        TEST_ASSERT_EQUAL_UINT(1, count);
    }
}

static void test_a_frame_with_a_wrong_crc_is_ignored(void)
{
    uint8_t request[8] = {START};
    (void)seal(request, 6);
    for (unsigned bit = 0; bit < 8u * sizeof request; bit++)
    {
        uint8_t wrong[sizeof request];
        setUp();
        memcpy(wrong, request, sizeof request);
        wrong[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        put(wrong, sizeof wrong);
        take(true);
        TEST_ASSERT_EQUAL_UINT(0, count);
        TEST_ASSERT_EQUAL_UINT32(1, rtu.torn);
    }
}

static void test_what_came_before_is_late_and_what_comes_after_is_not(void)
{
    uint8_t frames[24] = {START};
    (void)seal(frames, 6);
    memcpy(frames + 8, (const uint8_t[]){STOP}, 6);
    (void)seal(frames + 8, 6);
    memcpy(frames + 16, (const uint8_t[]){READ}, 6);
    (void)seal(frames + 16, 6);
    rtu.late = 12; // and the rest of the second one
    put(frames, sizeof frames);
    TEST_ASSERT_EQUAL_UINT(3, count);
    TEST_ASSERT_TRUE(found[0].is_late);
    TEST_ASSERT_TRUE(found[1].is_late);
    TEST_ASSERT_FALSE(found[2].is_late);
    TEST_ASSERT_EQUAL_size_t(0, rtu.late);
}

static void test_a_frame_of_the_greatest_size_is_found(void)
{
    uint8_t frame[MODBUS_FRAME_MAX] = {1, 16, 0x10, 0, 0, 123, 246};
    TEST_ASSERT_EQUAL_size_t(255, seal(frame, 253));
    for (size_t first = 1; first < 255u; first++)
    {
        setUp();
        put(frame, first);
        put(frame + first, 255u - first);
        TEST_ASSERT_EQUAL_UINT(1, count);
        TEST_ASSERT_EQUAL_size_t(255, found[0].length);
    }
    setUp();
    frame[6] = 250; // longer than any: a request of another length whose CRC is right
    (void)seal(frame, 254);
    put(frame, sizeof frame);
    TEST_ASSERT_EQUAL_UINT(1, count);
    TEST_ASSERT_EQUAL_size_t(256, found[0].length);
}

#include "runners/test_rtu.inc" // main
