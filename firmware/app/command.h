/// Reads commands to the drive from a serial line, byte by byte. The single byte x stops the drive at once, anywhere in a line.
/// Every other command is a whole line, so that noise or a lost or added byte cannot start a drive:
///
///     x    stop    start    start    ack    acknowledge a fault    ?    report the state    + and -    reference up and down

#ifndef DRIVE_COMMAND_H
#define DRIVE_COMMAND_H

#include <stdbool.h>
#include <stdint.h>

typedef enum
{
    COMMAND_NONE,
    COMMAND_STOP,
    COMMAND_START,
    COMMAND_ACKNOWLEDGE,
    COMMAND_REPORT,
    COMMAND_UP,
    COMMAND_DOWN
} command_t;

#define COMMAND_LENGTH_MAX 5u

/// The line read so far. All zero before the first byte.
typedef struct
{
    char    line[COMMAND_LENGTH_MAX + 1u]; ///< ends with 0
    uint8_t length;
    bool    spoilt; ///< the line is ignored up to its end
} command_reader_t;

/// Takes a byte; returns the completed command, or COMMAND_NONE. CR and LF both end a line.
command_t command_take(command_reader_t *reader, uint8_t byte);

#define COMMAND_SILENT_US 10000000u

/// Call this before a byte that comes `silent_us` after the last one. It drops the half line of a client that has been silent for
/// more than COMMAND_SILENT_US.
void command_pause(command_reader_t *reader, uint32_t silent_us);

/// Ignores the rest of the line, because a byte of it was lost or wrong.
void command_spoil(command_reader_t *reader);

#endif
