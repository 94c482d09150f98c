/// The interface of the drive to a board. A port fills this struct; a test fills it with a fake that can break.
///
/// All functions return at once: none waits for hardware without a time-out. The tick calls all but log_byte and pause, which
/// only the background calls.

#ifndef DRIVE_PORT_H
#define DRIVE_PORT_H

#include "app/config.h"
#include "app/loop.h"

#include <stdbool.h>
#include <stdint.h>

/// Inputs that are active now or, if the port detects edges, were active since the last tick. A port asks port_inputs which
/// levels are active.
#define PORT_INPUT_EMERGENCY_STOP 1u
#define PORT_INPUT_POWER_FAULT    2u
#define PORT_INPUT_NOT_READY      4u  ///< the power stage; means nothing while it is off
#define PORT_INPUT_SUPPLY         8u  ///< below the level at which the chip and its converters are reliable
#define PORT_INPUT_OVER_CURRENT   16u ///< a bridge of the board's own has turned itself off
#define PORT_INPUT_OVER_VOLTAGE   32u ///< likewise

/// What a board measures of its power stage and its arm, as bits of port_t.measures.
#define PORT_MEASURES_CURRENT     1u
#define PORT_MEASURES_BUS         2u
#define PORT_MEASURES_TEMPERATURE 4u
#define PORT_MEASURES_POSITION    8u

/// The latest of each.
typedef struct
{
    int32_t current_ma, bus_mv,
        temperature_mc; ///< of the motor, of the power stage's supply, of its hottest place in 1e-3 degC
    int32_t position;   ///< of the arm, in units of its sensor; wraps at 2^32
} port_measured_t;

/// A converter, or what a port has in its place. A number of units is a float in f32, and a fraction of full_units in Q31.
typedef struct
{
    float full_units;            ///< 2^31 in Q31; not read in f32
    float low_units, high_units; ///< the ends of its range, sensor: of what a working sensor reads; equal: it has none
} port_range_t;

typedef struct
{
    void        *context; ///< passed to every function
    port_range_t sensor, output;
    uint32_t     measures; ///< PORT_MEASURES_ bits

    /// The latest reading; false if there is no new one since the last call.
    bool (*read_sensor)(void *context, loop_force_t *reading);
    /// Sets the output, which is drive_config_t.command_zero_units for no current.
    void (*command)(void *context, loop_force_t output);
    /// Turns the power stage on or off.
    void (*enable)(void *context, bool on);
    /// PORT_INPUT_ bits that are active. A broken wire must read as active.
    uint32_t (*inputs)(void *context);
    /// What `measures` says; not called without.
    void (*measure)(void *context, port_measured_t *measured);
    /// A free-running clock that wraps at 2^32, derived from the clock that triggers the ticks.
    uint32_t (*time_us)(void *context);
    void (*log_byte)(void *context, uint8_t byte);
    /// Called by the background between pieces of long work, e.g. to serve a watchdog. May be null.
    void (*pause)(void);
} port_t;

/// The levels of the pins of emergency stop, power fault and ready, as the drive's inputs: which were `high`, and which were
/// `low`, since the last tick. Both if they changed. A broken wire of the emergency stop reads high.
static inline uint32_t port_inputs(const drive_config_t *config, uint32_t high, uint32_t low)
{
    return (high & PORT_INPUT_EMERGENCY_STOP) | ((config->fault_level != 0u ? high : low) & PORT_INPUT_POWER_FAULT) |
           ((config->ready_level != 0u ? low : high) & PORT_INPUT_NOT_READY);
}

#endif
