#include "rtu.h"

#include "app/crc16.h"

#include <string.h>

#define FRAME_MIN 4u // unit, function, CRC

uint8_t *rtu_room(rtu_t *rtu, size_t *room)
{
    *room = sizeof rtu->bytes - rtu->length;
    return rtu->bytes + rtu->length;
}

static void drop(rtu_t *rtu, size_t count)
{
    rtu->length -= count;
    rtu->late -= rtu->late < count ? rtu->late : count;
    memmove(rtu->bytes, rtu->bytes + count, rtu->length);
}

/// Finds the lengths of a request and of an answer with this function. A length is beyond `length` until the byte that gives
/// it has come, and 0 if the function has no known length.
static void sizes_of(const uint8_t *bytes, size_t length, size_t sizes[2])
{
    switch (bytes[1])
    {
    case 3: // read: the answer has a count and values
        sizes[0] = 8u;
        sizes[1] = 5u + bytes[2];
        return;
    case 6: // write one: the answer repeats the request
        sizes[0] = sizes[1] = 8u;
        return;
    case 16: // write: the request has a count and values
        sizes[0] = length > 6u ? 9u + bytes[6] : length + 1u;
        sizes[1] = 8u;
        return;
    case 23: // write and read: both have a count and values
        sizes[0] = length > 10u ? 13u + bytes[10] : length + 1u;
        sizes[1] = 5u + bytes[2];
        return;
    default:
        sizes[0] = sizes[1] = 0u;
    }
}

static bool is_frame(const uint8_t *bytes, size_t size)
{
    return size >= FRAME_MIN && size <= MODBUS_FRAME_MAX && crc16(bytes, size) == 0u;
}

/// Returns the length of a frame with a function of any length: up to the first place with a matching CRC; 0 if there is none.
static size_t find_end(const uint8_t *bytes, size_t length)
{
    size_t size = FRAME_MIN;
    while (size <= length && !is_frame(bytes, size))
    {
        size++;
    }
    return size <= length ? size : 0u;
}

/// Returns the size of the frame at the beginning of the bytes; 0 if there is none, or not yet. If bytes were skipped
/// before, only functions of a known length count, because noise soon has some place with a matching CRC.
static size_t find(const rtu_t *rtu, bool is_silent)
{
    const size_t length = rtu->length < MODBUS_FRAME_MAX ? rtu->length : MODBUS_FRAME_MAX;
    size_t       sizes[2];
    bool         is_open = rtu->is_torn;
    if (length < FRAME_MIN)
    {
        return 0;
    }
    sizes_of(rtu->bytes, length, sizes);
    for (unsigned i = 0; i < 2u; i++)
    {
        if (sizes[i] <= length && is_frame(rtu->bytes, sizes[i]))
        {
            return sizes[i];
        }
        is_open = is_open || (sizes[i] > length && sizes[i] <= MODBUS_FRAME_MAX && !is_silent);
    }
    return is_open ? 0u : find_end(rtu->bytes, length);
}

static void tear(rtu_t *rtu, bool is_torn)
{
    rtu->torn += is_torn && !rtu->is_torn;
    rtu->is_torn = is_torn;
}

bool rtu_take(rtu_t *rtu, bool is_silent, rtu_frame_t *frame)
{
    while (rtu->length > 0u)
    {
        const size_t size = find(rtu, is_silent);
        if (size > 0u)
        {
            memcpy(frame->bytes, rtu->bytes, size);
            frame->length     = size;
            frame->is_late    = rtu->late > 0u;
            frame->is_awaited = !rtu->is_torn || rtu->length == size;
            drop(rtu, size);
            tear(rtu, false);
            return true;
        }
        if (!is_silent && rtu->length <= MODBUS_FRAME_MAX)
        {
            return false;
        }
        tear(rtu, true);
        drop(rtu, 1);
    }
    if (is_silent)
    {
        tear(rtu, false);
    }
    return false;
}
