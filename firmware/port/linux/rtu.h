/// Finds frames of Modbus RTU in the bytes of a tty. The silence between two frames cannot be seen there, because a USB
/// adapter and the kernel pass bytes on in pieces, and several frames in one piece. The function therefore gives the length
/// of a frame, as a request or as another unit's answer, and the CRC confirms it. A frame with a function of unknown length
/// ends where the CRC matches.
///
/// Bytes that are not a frame are kept until the line is silent, because the rest may come, or until there are too many. The next
/// frame among them is then found byte by byte. A frame inside another whole frame is never looked for.

#ifndef LINUX_RTU_H
#define LINUX_RTU_H

#include "app/modbus.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// State of the search; all zero before the first byte.
typedef struct
{
    uint8_t  bytes[2u * MODBUS_FRAME_MAX];
    size_t   length;
    size_t   late;    ///< bytes from the first on that came while the program could not answer
    bool     is_torn; ///< bytes were skipped since the last frame
    uint32_t torn;    ///< how often bytes were skipped; wraps
} rtu_t;

typedef struct
{
    uint8_t bytes[MODBUS_FRAME_MAX];
    size_t  length;
    bool    is_late;
    bool    is_awaited; ///< false: bytes were skipped before it and others came after it, so its client no longer waits
} rtu_frame_t;

/// Returns where to put up to `room` bytes, at least MODBUS_FRAME_MAX. Add their number to `length` afterwards.
uint8_t *rtu_room(rtu_t *rtu, size_t *room);

/// Takes the next frame; false if there is none yet. `is_silent` says that nothing has come for longer than any pause within
/// a frame.
bool rtu_take(rtu_t *rtu, bool is_silent, rtu_frame_t *frame);

#endif
