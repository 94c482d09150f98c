// A board that can break: the test sets sensor, inputs and clock; the board records the outputs of the drive.

#ifndef TESTS_FIRMWARE_BOARD_H
#define TESTS_FIRMWARE_BOARD_H

#include "app/drive.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define BOARD_FULL_SCALE_N 4.0f
#define BOARD_LOG_SIZE     4096

typedef struct
{
    port_t port;

    // inputs of the drive
    loop_force_t    y;
    bool            silent;
    uint32_t        inputs;
    uint32_t        now_us;
    port_measured_t measured;
    uint32_t        tick_us; ///< time between the first and the second reading of the clock in a tick

    // outputs of the drive
    loop_force_t command;
    bool         enabled;
    unsigned     commands, clock_reads;
    bool         moved_while_off; ///< a command other than 0 while the power stage was off
    bool         off_late; ///< the power stage went off behind a command in the same tick, which might have blocked
    char         log[BOARD_LOG_SIZE];
    unsigned     log_length;
} board_t;

/// A healthy board with its clock at `now_us`. Its sensor and its output are in N.
void board_init(board_t *board, uint32_t now_us);

/// A force in N, converted to the drive's arithmetic.
loop_force_t board_force(double force_n);

/// Before each tick: clears the counters of a tick.
void board_new_tick(board_t *board);

/// Receives on a modbus_line_t where nobody talks.
int board_receive_nothing(void *context, uint8_t *bytes, size_t room);

#endif
