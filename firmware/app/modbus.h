/// A Modbus server for functions 3, 6, 16 and 23. No heap. What a request does is here for every line (modbus_answer). On RTU the
/// tick only copies bytes (modbus_take), and the background does the rest (modbus_serve).
///
/// A frame ends after 3.5 characters of silence, measured in whole ticks. The shorter silence of 1.5 characters within a frame
/// is not measured: a frame that lost a byte has a wrong CRC. Only a frame with the right CRC is executed, addressed to this
/// unit or, for functions 6 and 16, to all (unit 0, no answer), who may only be stopped. A refused write writes nothing.
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

/// Also the exception codes of an answer.
typedef enum
{
    MODBUS_OK               = 0,
    MODBUS_ILLEGAL_FUNCTION = 1,
    MODBUS_ILLEGAL_ADDRESS  = 2,
    MODBUS_ILLEGAL_VALUE    = 3,
    MODBUS_FAILURE          = 4,
    MODBUS_BUSY             = 6
} modbus_status_t;

/// Whom a request comes from.
typedef enum
{
    MODBUS_MASTER,
    MODBUS_LATE, ///< came while nobody could answer: reads, and writes a stop at most
    MODBUS_GUEST ///< to all, or beside another client: a stop at most
} modbus_source_t;

/// The registers behind the server. All functions do all or nothing; `count` is 1 to MODBUS_READ_MAX or MODBUS_WRITE_MAX,
/// and the last address at most 0xffff. `stop` is the write of those who may only stop: MODBUS_BUSY if it is no stop.
typedef struct
{
    void *context;
    modbus_status_t (*read)(void *context, uint16_t address, uint16_t count, uint16_t *values);
    modbus_status_t (*write)(void *context, uint16_t address, uint16_t count, const uint16_t *values);
    modbus_status_t (*stop)(void *context, uint16_t address, uint16_t count, const uint16_t *values);
} modbus_registers_t;

/// The line. The tick calls `receive`: copies up to `room` bytes received since the last call and returns their number, or
/// MODBUS_LINE_ERROR if one was lost or wrong. The background calls `send`: takes up to `count` bytes without waiting and
/// returns their number. It passes bytes between two silences that are no frame to `stray`, unless that is null.
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
    uint32_t silent_ticks; ///< at the end of a frame

    // Written by the tick while `complete` is false, by the background while it is true; the frame as well.
    volatile bool     complete;
    volatile uint16_t length;

    // Written by the tick only.
    uint32_t silence; ///< ticks
    bool     spoilt;  ///< ignore bytes until the next silence

    volatile bool lost; ///< bytes were ignored or lost: set by the tick, cleared by whom it concerns

    // The background's.
    uint16_t answer_length, answer_sent;
    uint32_t frames;     ///< executed; wraps
    uint32_t bad_frames; ///< with a wrong CRC or too short; wraps
    uint32_t exceptions; ///< answered; wraps
    uint32_t heard;      ///< frames of this unit's own client; wraps

    uint8_t frame[MODBUS_FRAME_MAX];
    uint8_t answer[MODBUS_FRAME_MAX];
} modbus_t;

/// `unit` is 1 to MODBUS_UNIT_MAX; `baud` and the tick period determine the silence that ends a frame.
void modbus_init(modbus_t *modbus, uint8_t unit, uint32_t baud, uint32_t period_us);

/// In the tick: copies received bytes.
void modbus_take(modbus_t *modbus, const modbus_line_t *line);

/// In the background: executes a complete frame, and sends as much of the answer as the line accepts. What is late and no frame
/// counts as lost.
void modbus_serve(modbus_t                 *modbus,
                  const modbus_line_t      *line,
                  const modbus_registers_t *registers,
                  modbus_source_t           source);

/// Executes one frame; returns the length of `answer`, 0 if there is none.
size_t modbus_execute(modbus_t                 *modbus,
                      const modbus_registers_t *registers,
                      modbus_source_t           source,
                      const uint8_t            *frame,
                      size_t                    length,
                      uint8_t                   answer[MODBUS_FRAME_MAX]);

/// Executes one request without its frame: function and data, `size` of 1 to MODBUS_PDU_MAX bytes. Returns the size of `answer`,
/// likewise without its frame.
size_t modbus_answer(modbus_t                 *modbus,
                     const modbus_registers_t *registers,
                     modbus_source_t           source,
                     const uint8_t            *request,
                     size_t                    size,
                     uint8_t                   answer[MODBUS_PDU_MAX]);

#endif
