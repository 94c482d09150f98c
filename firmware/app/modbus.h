/// A Modbus server for functions 3, 6, 16 and 23, without a heap. modbus_answer executes the requests of every kind of line.
/// On RTU the tick only copies bytes (modbus_take), and the background does the rest (modbus_serve).
///
/// A frame ends after 3.5 characters of silence, measured in whole ticks. The shorter silence of 1.5 characters within a
/// frame is not measured, because a frame that lost a byte has a wrong CRC. A frame is executed if its CRC is right and it
/// is addressed to this unit. Functions 6 and 16 may also be addressed to all units (unit 0, no answer), but only to stop
/// them. A refused write writes nothing.
///
/// Source: MODBUS Application Protocol Specification V1.1b3; MODBUS over Serial Line V1.02, 2.5.1.

#ifndef DRIVE_MODBUS_H
#define DRIVE_MODBUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MODBUS_FRAME_MAX 256u
#define MODBUS_PDU_MAX   253u ///< function and data: a frame without unit and CRC
#define MODBUS_READ_MAX  125u ///< registers in a frame
#define MODBUS_WRITE_MAX 123u ///< with function 23: 121
#define MODBUS_UNIT_MAX  247u
#define MODBUS_BROADCAST 0u

/// The result of a request; all but MODBUS_OK are exception codes of an answer.
typedef enum
{
    MODBUS_OK               = 0,
    MODBUS_ILLEGAL_FUNCTION = 1,
    MODBUS_ILLEGAL_ADDRESS  = 2,
    MODBUS_ILLEGAL_VALUE    = 3,
    MODBUS_FAILURE          = 4,
    MODBUS_BUSY             = 6
} modbus_status_t;

/// The source of a request.
typedef enum
{
    MODBUS_MASTER, ///< may do everything
    MODBUS_LATE,   ///< its request came while the drive could not answer: may read, and write only a stop
    MODBUS_GUEST   ///< sends to all units, or next to another client: may only write a stop
} modbus_source_t;

/// The registers behind the server. All functions do all or nothing; `count` is 1 to MODBUS_READ_MAX or MODBUS_WRITE_MAX,
/// and the last address is at most 0xffff. `stop` replaces `write` for sources that may only stop: it returns MODBUS_BUSY for
/// any other write.
typedef struct
{
    void *context;
    modbus_status_t (*read)(void *context, uint16_t address, uint16_t count, uint16_t *values);
    modbus_status_t (*write)(void *context, uint16_t address, uint16_t count, const uint16_t *values);
    modbus_status_t (*stop)(void *context, uint16_t address, uint16_t count, const uint16_t *values);
} modbus_registers_t;

/// The line. The tick calls `receive`, which copies up to `room` bytes received since the last call and returns their number, or
/// MODBUS_LINE_ERROR if one was lost or wrong. The background calls `send`, which takes up to `count` bytes without waiting and
/// returns their number. The background passes bytes between two silences that are not a frame to `stray`, unless it is null.
typedef struct
{
    void *context;
    int (*receive)(void *context, uint8_t *bytes, size_t room);
    size_t (*send)(void *context, const uint8_t *bytes, size_t count);
    void (*stray)(void *context, const uint8_t *bytes, size_t count);
} modbus_line_t;

#define MODBUS_LINE_ERROR (-1)

typedef struct
{
    uint8_t  unit;
    uint32_t silent_ticks; ///< ticks of silence that end a frame

    // The tick writes these and the frame while `complete` is false, the background while it is true.
    volatile bool     complete;
    volatile uint16_t length;

    // Only the tick writes these.
    uint32_t silence; ///< ticks since the last byte
    bool     spoilt;  ///< bytes are ignored until the next silence

    volatile bool lost; ///< bytes were ignored or lost; set here, cleared by its reader

    // Only the background writes these.
    uint16_t answer_length, answer_sent;
    uint32_t frames;     ///< frames executed; wraps
    uint32_t bad_frames; ///< frames that were too short or had a wrong CRC; wraps
    uint32_t exceptions; ///< exceptions answered; wraps
    uint32_t heard;      ///< frames of this unit's own client; wraps

    uint8_t frame[MODBUS_FRAME_MAX];
    uint8_t answer[MODBUS_FRAME_MAX];
} modbus_t;

/// Starts a server. `unit` is 1 to MODBUS_UNIT_MAX; `baud` and the tick period determine the silence that ends a frame.
void modbus_init(modbus_t *modbus, uint8_t unit, uint32_t baud, uint32_t period_us);

/// Copies received bytes, in the tick.
void modbus_take(modbus_t *modbus, const modbus_line_t *line);

/// Executes a complete frame and sends as much of the answer as the line accepts, in the background. Late bytes that are not a
/// frame count as lost.
void modbus_serve(modbus_t                 *modbus,
                  const modbus_line_t      *line,
                  const modbus_registers_t *registers,
                  modbus_source_t           source);

/// Executes one frame. Returns the length of `answer`, 0 if there is none.
size_t modbus_execute(modbus_t                 *modbus,
                      const modbus_registers_t *registers,
                      modbus_source_t           source,
                      const uint8_t            *frame,
                      size_t                    length,
                      uint8_t                   answer[MODBUS_FRAME_MAX]);

/// Executes one request without its frame: function and data, 1 to MODBUS_PDU_MAX bytes. Returns the size of `answer`, also
/// without its frame.
size_t modbus_answer(modbus_t                 *modbus,
                     const modbus_registers_t *registers,
                     modbus_source_t           source,
                     const uint8_t            *request,
                     size_t                    size,
                     uint8_t                   answer[MODBUS_PDU_MAX]);

#endif
