/// A ring of the bytes that a line's interrupt has received since the last tick.

#ifndef DRIVE_RECEIVED_H
#define DRIVE_RECEIVED_H

#include "app/modbus.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RECEIVED_BYTES 64u // a power of two; enough for five ticks at 115200 baud

/// Only the interrupt writes `bytes` and `in`, and only the tick `out`. The tick interrupts the interrupt, never the reverse.
typedef struct
{
    uint8_t           bytes[RECEIVED_BYTES];
    volatile uint32_t in, out;
    volatile bool     is_bad;
} received_t;

/// Adds a byte, in the interrupt. `good` is false for a byte with an error, or if bytes before it were lost.
static inline void received_put(received_t *ring, uint8_t byte, bool good)
{
    if (!good || ring->in - ring->out == RECEIVED_BYTES)
    {
        ring->is_bad = true;
        return;
    }
    ring->bytes[ring->in % RECEIVED_BYTES] = byte;
    ring->in                               = ring->in + 1u; // comes after the byte is written
}

/// Takes the bytes in the tick, as modbus_line_t.receive does. If a byte was bad or found no room, it drops all bytes and returns
/// MODBUS_LINE_ERROR.
static inline int received_take(received_t *ring, uint8_t *bytes, size_t room)
{
    if (ring->is_bad)
    {
        ring->is_bad = false;
        ring->out    = ring->in;
        return MODBUS_LINE_ERROR;
    }
    size_t count = 0;
    while (count < room && ring->out != ring->in)
    {
        bytes[count++] = ring->bytes[ring->out % RECEIVED_BYTES];
        ring->out      = ring->out + 1u;
    }
    return (int)count;
}

#endif
