/// What the drive asks of a board. A port fills this struct, a test fills it with a fake that can break.
///
/// All functions return at once (none waits for hardware without a bound) and are called from the tick, but for
/// log_byte, which only the background calls.

#ifndef DRIVE_PORT_H
#define DRIVE_PORT_H

#include "app/loop.h"

#include <stdbool.h>
#include <stdint.h>

/// What the fault inputs show now, or, where a port sees that, have shown since the last tick.
#define PORT_INPUT_EMERGENCY_STOP 1u
#define PORT_INPUT_POWER_FAULT    2u

typedef struct
{
    void *context; ///< given to every function

    /// The newest force since the last call; false if the sensor has not answered since.
    bool (*read_force)(void *context, loop_force_t *y);
    /// The current command, as the force u it makes. Zero current at 0.
    void (*command)(void *context, loop_force_t u);
    /// The power stage.
    void (*enable)(void *context, bool on);
    /// PORT_INPUT_ bits that are active. A broken wire must read as active.
    uint32_t (*inputs)(void *context);
    /// A free-running clock that wraps at 2^32, the same that makes the ticks.
    uint32_t (*time_us)(void *context);
    void (*log_byte)(void *context, uint8_t byte);
} port_t;

#endif
