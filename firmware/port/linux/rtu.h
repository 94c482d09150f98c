/// Frames of Modbus RTU out of bytes from a tty. The silence between two frames is not seen there: a USB adapter and the kernel pass
/// bytes on in pieces, and several frames in one. So the length of a frame is that of its function, as a request or as another
/// unit's answer, and its CRC decides. A function without a known length ends where the CRC fits.
///
/// Bytes that are no frame are kept until the line is silent, as the rest may come, or there are too many of them. Then the next
/// frame among them is found, byte by byte; a frame inside of another one that is whole is never looked for.

#ifndef LINUX_RTU_H
#define LINUX_RTU_H

#include "app/modbus.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Zero before the first byte.
typedef struct
{
    uint8_t  bytes[2u * MODBUS_FRAME_MAX];
    size_t   length;
    size_t   late;    ///< bytes from the first on that came while nobody could answer
    bool     is_torn; ///< bytes were skipped since the last frame
    uint32_t torn;    ///< times that bytes were skipped; wraps
} rtu_t;

typedef struct
{
    uint8_t bytes[MODBUS_FRAME_MAX];
    size_t  length;
    bool    is_late;
    bool is_awaited; ///< false: after skipped bytes, and others have come behind it: its client does not wait any more
} rtu_frame_t;

/// Where up to `room` bytes may be put, at least MODBUS_FRAME_MAX; then add them to `length`.
uint8_t *rtu_room(rtu_t *rtu, size_t *room);

/// The next frame; false if there is none yet. `is_silent`: nothing more has come for longer than within any frame.
bool rtu_take(rtu_t *rtu, bool is_silent, rtu_frame_t *frame);

#endif
