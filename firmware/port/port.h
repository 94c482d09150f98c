/// The interface of the drive to a board. A port fills this struct; a test fills it with a fake that can break.
///
/// All functions return at once: none waits for hardware without a time-out. The tick calls all but log_byte, which only the
/// background calls.

#ifndef DRIVE_PORT_H
#define DRIVE_PORT_H

#include "app/loop.h"

#include <stdbool.h>
#include <stdint.h>

/// Fault inputs that are active now or, if the port detects edges, were active since the last tick.
#define PORT_INPUT_EMERGENCY_STOP 1u
#define PORT_INPUT_POWER_FAULT    2u

typedef struct
{
    void *context; ///< passed to every function

    /// The latest force; false if there is no new reading since the last call.
    bool (*read_force)(void *context, loop_force_t *y);
    /// Sets the motor current that makes the force u; no current at 0.
    void (*command)(void *context, loop_force_t u);
    /// Turns the power stage on or off.
    void (*enable)(void *context, bool on);
    /// PORT_INPUT_ bits that are active. A broken wire must read as active.
    uint32_t (*inputs)(void *context);
    /// A free-running clock that wraps at 2^32, derived from the clock that triggers the ticks.
    uint32_t (*time_us)(void *context);
    void (*log_byte)(void *context, uint8_t byte);
} port_t;

/// Writes `text` to the log, from the background.
static inline void port_write(const port_t *port, const char *text)
{
    for (; *text != '\0'; text++)
    {
        port->log_byte(port->context, (uint8_t)*text);
    }
}

#endif
