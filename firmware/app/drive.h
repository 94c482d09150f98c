/// The drive: when the force loop may run, and what stops it. No registers; the board is a port_t.
///
///     power-up --self-test--> IDLE <--start, stop--> RUN
///                  |           |  ^                   |
///                  |     fault |  | acknowledge       | fault
///                  v           v  | (cause gone)      v
///                FAULT        FAULT <-----------------'
///                (for good)
///
/// A limit acts and the loop runs on; a fault stops the drive. Within the tick that detects a fault the command goes to 0
/// and the power stage off, and the cause is latched. Only an acknowledgement leaves FAULT, to IDLE, and only once the
/// cause is gone. A start requested before that is dropped, so the drive never restarts by itself. A failed self-test or
/// wrong params last until the next power-up. After a reset by the watchdog the drive begins in FAULT.
///
/// Call drive_tick in the timer interrupt; drive_start, drive_stop, drive_acknowledge and drive_log in the background, one
/// caller each.

#ifndef DRIVE_DRIVE_H
#define DRIVE_DRIVE_H

#include "app/config.h"
#include "app/loop.h"
#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum
{
    DRIVE_IDLE,
    DRIVE_RUN,
    DRIVE_FAULT
} drive_state_t;

/// Limits that acted in a tick, as bits; the loop runs on.
typedef enum
{
    DRIVE_LIMIT_COMMAND   = 1, ///< u is limited to u_min or u_max
    DRIVE_LIMIT_REFERENCE = 2  ///< r is beyond input_max: the loop coasts
} drive_limit_t;

/// What stops the drive. Of several causes in one tick the first in this list is latched.
typedef enum
{
    DRIVE_FAULT_NONE,
    DRIVE_FAULT_IMAGE,          ///< self-test: the image differs from the one built; for good
    DRIVE_FAULT_RAM,            ///< self-test: for good
    DRIVE_FAULT_GOLDEN,         ///< self-test: the loop computes a wrong result; for good
    DRIVE_FAULT_PARAMS,         ///< the loop's params are not for this drive; for good
    DRIVE_FAULT_WATCHDOG,       ///< at power-up: the watchdog ended the last run
    DRIVE_FAULT_EMERGENCY_STOP, ///< the input
    DRIVE_FAULT_POWER,          ///< the power stage's fault input
    DRIVE_FAULT_TICK_MISSED,    ///< a whole period or more late
    DRIVE_FAULT_TICK_LATE,      ///< by more than late_us
    DRIVE_FAULT_TICK_EARLY,     ///< by more than late_us: a clock runs wrong
    DRIVE_FAULT_SENSOR_SILENT,  ///< no new reading since the last tick
    DRIVE_FAULT_NAN,            ///< the sensor or the reference
    DRIVE_FAULT_SENSOR_RANGE,   ///< |y| beyond input_max
    DRIVE_FAULT_SENSOR_STUCK,   ///< stuck_ticks readings in a row without a change
    DRIVE_FAULT_TICK_OVERRUN,   ///< longer than budget_us from its start to its command
    DRIVE_FAULTS
} drive_fault_t;

/// Read only: the functions below write it.
typedef struct
{
    const port_t        *port;
    const loop_params_t *params;
    drive_config_t       config;

    volatile drive_state_t state;

    drive_fault_t  fault;  ///< the cause, as long as the state is DRIVE_FAULT
    uint32_t       limits; ///< drive_limit_t bits of the last tick
    loop_state_t   loop;
    loop_signals_t signals; ///< of the last tick in RUN

    uint32_t     due_us; ///< when the next tick should start
    bool         timed;  ///< due_us is valid
    loop_force_t last_y;
    uint32_t     same_y; ///< readings equal to the one before

    uint32_t ticks;       ///< since power-up; wraps
    uint32_t fault_tick;  ///< the tick that latched the cause
    uint32_t max_tick_us; ///< longest from a tick's start to its command
    uint32_t max_late_us; ///< latest start
    uint32_t overruns;    ///< ticks over budget; stops at UINT32_MAX

    // Requests are counters, incremented by the background; the tick copies them. This needs no lock.
    volatile uint8_t starts, stops, acknowledgements;
    uint8_t          starts_seen, stops_seen, acknowledgements_seen;
    drive_state_t    logged_state;
} drive_t;

/// The drive after power-up: outputs off. With the fault `found` by the self-test (selftest.h), or DRIVE_FAULT_PARAMS, the
/// drive is in FAULT for good; with DRIVE_FAULT_WATCHDOG it is in FAULT until acknowledged, with DRIVE_FAULT_NONE idle.
/// `port` must outlive the drive, and so must `params`, which may be null if the fault is for good.
void drive_init(drive_t              *drive,
                const port_t         *port,
                const loop_params_t  *params,
                const drive_config_t *config,
                drive_fault_t         found);

/// One tick with reference `r`: reads the inputs, checks them, runs the loop in RUN, and writes the command.
void drive_tick(drive_t *drive, loop_force_t r);

/// Requests for the next tick. A start acts only in IDLE, an acknowledgement only in FAULT.
void drive_start(drive_t *drive);
void drive_stop(drive_t *drive);
void drive_acknowledge(drive_t *drive);

/// Writes a line to the log if the state has changed: the state, and for a fault its cause and tick.
void drive_log(drive_t *drive);

/// Writes that line unconditionally.
void drive_report(drive_t *drive);

/// A few words for a log. Never null.
const char *drive_fault_text(drive_fault_t fault);

#endif
