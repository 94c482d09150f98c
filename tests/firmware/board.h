// A board that can break: what the sensor, the inputs and the clock say is the test's, and it keeps what the drive did.

#ifndef TESTS_FIRMWARE_BOARD_H
#define TESTS_FIRMWARE_BOARD_H

#include "app/drive.h"

#include <stdbool.h>
#include <stdint.h>

#define BOARD_FULL_SCALE_N 4.0f
#define BOARD_LOG_SIZE     4096

typedef struct
{
    port_t port;

    // what the drive sees
    loop_force_t y;
    bool         silent;
    uint32_t     inputs;
    uint32_t     now_us;
    uint32_t     tick_us; ///< the clock goes on by this between its first and second reading in a tick

    // what the drive did
    loop_force_t command;
    bool         enabled;
    unsigned     commands, clock_reads;
    bool         moved_while_off; ///< a command other than 0 while the power stage was off
    char         log[BOARD_LOG_SIZE];
    unsigned     log_length;
} board_t;

/// Nothing broken, clock at `now_us`.
void board_init(board_t *board, uint32_t now_us);

/// A force in N as the drive's arithmetic has it.
loop_force_t board_force(double force_n);

/// Before each tick: what is counted by tick starts anew.
void board_new_tick(board_t *board);

#endif
