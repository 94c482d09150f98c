/// The interface of the drive to a board. A port fills this struct; a test fills it with a fake that can break.
///
/// All functions return at once: none waits for hardware without a time-out. The tick calls all of them except log_byte and
/// pause, which only the background calls.

#ifndef DRIVE_PORT_H
#define DRIVE_PORT_H

#include "app/config.h"
#include "app/loop.h"

#include <stdbool.h>
#include <stdint.h>

/// Inputs that are active now or, if the port detects edges, were active since the last tick. port_inputs tells a port which
/// levels are active.
#define PORT_INPUT_EMERGENCY_STOP 1u
#define PORT_INPUT_POWER_FAULT    2u
#define PORT_INPUT_NOT_READY      4u ///< the power stage is not ready; means nothing while it is off
#define PORT_INPUT_SUPPLY         8u ///< the supply is below the level at which the chip and its converters are reliable
#define PORT_INPUT_OVER_CURRENT   16u ///< the board's own bridge has turned itself off because of its current
#define PORT_INPUT_OVER_VOLTAGE   32u ///< ... because of its voltage

/// The quantities of power stage and arm that a board measures, as bits of port_t.measures.
#define PORT_MEASURES_CURRENT     1u
#define PORT_MEASURES_BUS         2u
#define PORT_MEASURES_TEMPERATURE 4u
#define PORT_MEASURES_POSITION    8u

/// The latest value of each quantity.
typedef struct
{
    int32_t current_ma, bus_mv,
        temperature_mc; ///< the motor's current, the power stage's supply and its hottest place, in 1e-3 A, V and degC
    int32_t position;   ///< the arm's position in units of its sensor; wraps at 2^32
} port_measured_t;

/// The range of a converter, or of a port's substitute for one. A number of units is a float in f32, and a fraction of
/// full_units in Q31.
typedef struct
{
    float full_units;            ///< units of 2^31 in Q31; not read in f32
    float low_units, high_units; ///< limits of the range; for a sensor, of a working one's readings; equal: no range
} port_range_t;

typedef struct
{
    void        *context; ///< passed to every function
    port_range_t sensor, output;
    uint32_t     measures; ///< the PORT_MEASURES_ bits

    /// Reads the latest reading. Returns false if there is no new one since the last call.
    bool (*read_sensor)(void *context, loop_force_t *reading);
    /// Sets the output; drive_config_t.command_zero_units means no current.
    void (*command)(void *context, loop_force_t output);
    /// Turns the power stage on or off.
    void (*enable)(void *context, bool on);
    /// Returns the PORT_INPUT_ bits that are active. A broken wire must read as active.
    uint32_t (*inputs)(void *context);
    /// Measures the quantities of `measures`. Not called if there are none.
    void (*measure)(void *context, port_measured_t *measured);
    /// Returns a free-running clock that wraps at 2^32, derived from the clock that triggers the ticks.
    uint32_t (*time_us)(void *context);
    void (*log_byte)(void *context, uint8_t byte);
    /// The background calls this between pieces of long work, e.g. to serve a watchdog. May be null.
    void (*pause)(void);
} port_t;

/// Converts the levels of the pins of emergency stop, power fault and ready to the drive's inputs: which pins were `high`,
/// and which were `low`, since the last tick; both if they changed. A broken wire of the emergency stop reads high.
static inline uint32_t port_inputs(const drive_config_t *config, uint32_t high, uint32_t low)
{
    return (high & PORT_INPUT_EMERGENCY_STOP) | ((config->fault_level != 0u ? high : low) & PORT_INPUT_POWER_FAULT) |
           ((config->ready_level != 0u ? low : high) & PORT_INPUT_NOT_READY);
}

#endif
