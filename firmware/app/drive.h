/// The drive: when the force loop may run, and what stops it. No registers; the board is a port_t.
///
///     power-up --self-test--> IDLE <--start, stop--> RUN
///                  |           |  ^                   |
///                  |     fault |  | acknowledge       | fault
///                  v           v  | (cause gone)      v
///                FAULT        FAULT <-----------------'
///                (for good)
///
/// Limits act and the loop goes on; faults stop. A fault puts the command to 0 and the power stage off within the tick
/// that sees it, and is latched with its cause. Only an acknowledgement leaves FAULT, to IDLE, and only once the cause is
/// gone; a start asked for before that is forgotten, so the drive never restarts by itself. A failed self-test or wrong
/// params last until the next power-up. After a watchdog's reset the drive begins in FAULT.
///
/// drive_tick belongs in the timer interrupt; drive_start, drive_stop, drive_acknowledge and drive_log in the
/// background, one caller each.

#ifndef DRIVE_DRIVE_H
#define DRIVE_DRIVE_H

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

/// What acts on a tick, as bits; the loop runs on.
typedef enum
{
    DRIVE_LIMIT_COMMAND   = 1, ///< u stands at u_min or u_max
    DRIVE_LIMIT_REFERENCE = 2  ///< r is beyond input_max: the loop coasts
} drive_limit_t;

/// What stops the drive. When several causes come in one tick the first of this list is the one latched.
typedef enum
{
    DRIVE_FAULT_NONE,
    DRIVE_FAULT_IMAGE,          ///< self-test: the image is not what was built; for good
    DRIVE_FAULT_RAM,            ///< self-test: for good
    DRIVE_FAULT_GOLDEN,         ///< self-test: the loop does not compute what it should; for good
    DRIVE_FAULT_PARAMS,         ///< the loop's params are not for this drive; for good
    DRIVE_FAULT_WATCHDOG,       ///< found at power-up: the last run ended in a watchdog's reset
    DRIVE_FAULT_EMERGENCY_STOP, ///< the input
    DRIVE_FAULT_POWER,          ///< the power stage's fault input
    DRIVE_FAULT_TICK_MISSED,    ///< a whole period or more late
    DRIVE_FAULT_TICK_LATE,      ///< by more than late_us
    DRIVE_FAULT_TICK_EARLY,     ///< by more than late_us: a clock is wrong
    DRIVE_FAULT_SENSOR_SILENT,  ///< no new reading since the last tick
    DRIVE_FAULT_NAN,            ///< the sensor or the reference
    DRIVE_FAULT_SENSOR_RANGE,   ///< |y| beyond input_max
    DRIVE_FAULT_SENSOR_STUCK,   ///< as many readings equal to the one before as stuck_ticks
    DRIVE_FAULT_TICK_OVERRUN,   ///< from its start to its command, the tick took longer than budget_us
    DRIVE_FAULTS
} drive_fault_t;

typedef struct
{
    uint32_t period_us;   ///< of the ticks
    uint32_t late_us;     ///< jitter that passes, below period_us
    uint32_t budget_us;   ///< for a tick, from its start to its command
    uint32_t stuck_ticks; ///< readings without any change that a live sensor never gives; 0: not watched
} drive_config_t;

/// Read it, do not write it.
typedef struct
{
    const port_t        *port;
    const loop_params_t *params;
    drive_config_t       config;

    volatile drive_state_t state;

    drive_fault_t  fault;  ///< the cause, as long as the state is DRIVE_FAULT
    uint32_t       limits; ///< drive_limit_t bits of the last tick
    loop_state_t   loop;
    loop_signals_t signals; ///< of the last tick that ran

    uint32_t     due_us; ///< when the next tick should start
    bool         timed;  ///< due_us holds
    loop_force_t last_y;
    uint32_t     same_y; ///< readings equal to the one before

    uint32_t ticks;       ///< since power-up; wraps
    uint32_t fault_tick;  ///< the tick that latched the cause
    uint32_t max_tick_us; ///< longest from a tick's start to its command
    uint32_t max_late_us; ///< latest start
    uint32_t overruns;    ///< ticks over budget; stops at UINT32_MAX

    // Requests as counters: the background counts up, the tick takes over what it has seen. No lock is needed.
    volatile uint8_t starts, stops, acknowledgements;
    uint8_t          starts_seen, stops_seen, acknowledgements_seen;
    drive_state_t    logged_state;
} drive_t;

/// The drive after power-up: outputs off. `found` is the self-test's finding (selftest.h), or DRIVE_FAULT_PARAMS: then the
/// drive is in FAULT for good. With DRIVE_FAULT_WATCHDOG it is in FAULT until acknowledged, with DRIVE_FAULT_NONE idle.
/// `port`, and `params` unless the fault is for good, must outlive the drive.
void drive_init(drive_t              *drive,
                const port_t         *port,
                const loop_params_t  *params,
                const drive_config_t *config,
                drive_fault_t         found);

/// One tick with reference `r`: reads, runs the loop if the drive runs, commands.
void drive_tick(drive_t *drive, loop_force_t r);

/// Ask for a change; the next tick decides. A start counts only in IDLE, an acknowledgement only in FAULT.
void drive_start(drive_t *drive);
void drive_stop(drive_t *drive);
void drive_acknowledge(drive_t *drive);

/// Writes a line to the log when the state has changed: the state, and for a fault its cause and tick.
void drive_log(drive_t *drive);

/// Writes that line in any case.
void drive_report(drive_t *drive);

/// A few words for a log. Never null.
const char *drive_fault_text(drive_fault_t fault);

#endif
