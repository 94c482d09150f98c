/// The drive decides when the force loop may run and what stops it. It touches no hardware registers: the board is a port_t.
///
///     power-up --self-test--> IDLE --start--> STARTING --ready--> RUN
///                  |           ^ |  ^            |  |              | |
///                  |           | |  '---stop-----'--|--------------' |
///                  |  acknowl. | | fault            | fault          | fault
///                  v  (cause   | v                  v                v
///                FAULT  gone) FAULT <-------------------------------'
///                (for good)
///
/// A limit acts and the loop runs on; a fault stops the drive. Within the tick that detects a fault, the power stage goes
/// off, the command goes to 0 and the cause is latched. Only an acknowledgement leads from FAULT to IDLE, and only once the
/// cause is gone. A start requested before that is dropped, so the drive never restarts by itself. A failed self-test, wrong
/// params, a wrong clock and changed params last until the next power-up. After an unexpected reset the drive begins in
/// FAULT.
///
/// In STARTING the power stage is on and the command is 0 until the stage is ready. Without a ready input (ready_ms is 0)
/// the tick of the start is the first in RUN. The reference is 0 after every stop, fault and acknowledgement, until a new
/// one arrives.
///
/// A host must renew its reference within reference_ms, or the drive stops with DRIVE_FAULT_REFERENCE. With a
/// reference_ramp_n_per_s the drive runs on: r goes to safe_reference_n at that rate and stays there until the host is back.
///
/// Call drive_tick in the timer interrupt, and the functions at the end of this file in the background, one caller each.

#ifndef DRIVE_DRIVE_H
#define DRIVE_DRIVE_H

#include "app/config.h"
#include "app/expected.h"
#include "app/faults.h"
#include "app/loop.h"
#include "app/scaling.h"
#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum
{
    DRIVE_IDLE,
    DRIVE_RUN,
    DRIVE_FAULT,
    DRIVE_STARTING ///< the power stage is on, but not ready
} drive_state_t;

/// Limits that acted in a tick, as bits. The loop runs on.
typedef enum
{
    DRIVE_LIMIT_COMMAND   = 1, ///< u is limited to u_min or u_max
    DRIVE_LIMIT_REFERENCE = 2, ///< r is beyond input_max: the loop runs with e = 0
    DRIVE_LIMIT_HOST      = 4  ///< the reference was not renewed: r goes to safe_reference_n, or is there
} drive_limit_t;

/// Conditions that a person should look at, as bits. The drive runs on. A warning stays until drive_restore, also after
/// stops and faults.
typedef enum
{
    DRIVE_WARNING_HUNTING = 1, ///< the guard has faded the compensation of friction because of hunting (tribo/guard.h)
    DRIVE_WARNING_OVERSHOOT = 2, ///< ... because of overshoot
    DRIVE_WARNING_BOUND     = 4, ///< the learned breakaway stays at a bound and cannot be trusted
    DRIVE_WARNINGS_END      = 8
} drive_warning_t;

/// Causes that stop the drive. If a tick finds several, the one that is checked first is latched. A bus reports these numbers.
typedef enum
{
    DRIVE_FAULT_NONE,
    DRIVE_FAULT_IMAGE,           ///< self-test: the image differs from the one built; for good
    DRIVE_FAULT_RAM,             ///< self-test: a word of RAM does not hold its contents; for good
    DRIVE_FAULT_GOLDEN,          ///< self-test: the loop computes a wrong result; for good
    DRIVE_FAULT_PARAMS,          ///< config or params do not suit this drive; for good
    DRIVE_FAULT_CLOCK,           ///< no crystal, or not the one that the config names; for good
    DRIVE_FAULT_STORE,           ///< at power-up: the saved params are damaged or of other firmware
    DRIVE_FAULT_WATCHDOG,        ///< at power-up: the watchdog ended the last run
    DRIVE_FAULT_EXCEPTION,       ///< at power-up: a hard fault or an unexpected exception ended the last run
    DRIVE_FAULT_CRYSTAL,         ///< at power-up: the crystal stopped
    DRIVE_FAULT_BROWN_OUT,       ///< at power-up: the supply fell so far that the chip was reset
    DRIVE_FAULT_RESTART,         ///< at power-up: the software reset the chip
    DRIVE_FAULT_EMERGENCY_STOP,  ///< the emergency stop's input is active
    DRIVE_FAULT_SUPPLY,          ///< an input shows that the supply is low
    DRIVE_FAULT_POWER,           ///< the power stage reports a fault
    DRIVE_FAULT_NOT_READY,       ///< the power stage is not ready ready_ms after it was enabled, or in RUN
    DRIVE_FAULT_TICK_MISSED,     ///< a tick was a whole period or more late
    DRIVE_FAULT_TICK_LATE,       ///< a tick was late by more than late_us
    DRIVE_FAULT_TICK_EARLY,      ///< a tick was early by more than late_us: a clock runs wrong
    DRIVE_FAULT_SENSOR_SILENT,   ///< no new reading since the last tick
    DRIVE_FAULT_NAN,             ///< the reading or the reference is not a number
    DRIVE_FAULT_SENSOR_RANGE,    ///< |y| is beyond input_max
    DRIVE_FAULT_SENSOR_STUCK,    ///< stuck_ticks readings in a row without a change
    DRIVE_FAULT_REFERENCE,       ///< in RUN, the host has not renewed its reference for reference_ms
    DRIVE_FAULT_TICK_OVERRUN,    ///< a tick took longer than budget_us from its start to its command
    DRIVE_FAULT_RESIDUAL,        ///< the sensor does not show the force that u leads to
    DRIVE_FAULT_COMMAND_LIMIT,   ///< u stayed at a limit for command_limit_ms
    DRIVE_FAULT_CONFIG_CHANGED,  ///< the params in use are not those that were checked; for good
    DRIVE_FAULT_OVER_CURRENT,    ///< measured, beyond over_current_a
    DRIVE_FAULT_BUS_VOLTAGE,     ///< measured, outside bus_low_v to bus_high_v
    DRIVE_FAULT_TEMPERATURE,     ///< measured, above temperature_max_c
    DRIVE_FAULT_BROWN_OUT_LEVEL, ///< at power-up: the chip is set up to run on with a supply too low for it
    DRIVE_FAULT_TRACKING,        ///< y was away from r for tracking_ms
    DRIVE_FAULT_SPEED,           ///< the arm's position changed faster than speed_max_units_per_s
    DRIVE_FAULT_SWING,           ///< u or y swings to and fro though r does not
    DRIVE_FAULTS
} drive_fault_t;

/// The constants of a tick, made by drive_setup_init: the loop's params, and the config converted to the arithmetic.
typedef struct
{
    const loop_params_t *params; ///< including those of a guard
    drive_config_t       config;
    scaling_t            scaling;
    faults_bounds_t      bounds;
    expected_t           expected;
    bool                 has_sensor; ///< there is a force sensor; without one y is 0
    /// For a unit of the position, on a drive without a force sensor; 0: the position is not used.
    loop_widths_t widths_per_unit;
} drive_setup_t;

/// The result of the last tare that was requested.
typedef enum
{
    DRIVE_TARE_NONE,
    DRIVE_TARE_BUSY,
    DRIVE_TARE_DONE,
    DRIVE_TARE_REFUSED ///< not in IDLE, turned off, or the mean force is beyond tare_max_n
} drive_tare_t;

#define DRIVE_TARE_TICKS 256u ///< the mean reading of so many ticks becomes 0 N

/// Read only: the functions below write it. Small members stand first, because their addresses make shorter code.
typedef struct
{
    const port_t *port;
    const drive_setup_t *volatile setup;

    volatile drive_state_t state;

    drive_fault_t fault;  ///< the cause while the state is DRIVE_FAULT
    uint32_t      limits; ///< drive_limit_t bits of the last tick
    loop_force_t  r, y;   ///< reference of the last tick, and the last good reading

    uint32_t ticks;       ///< since power-up; wraps
    uint32_t fault_tick;  ///< the tick that latched the cause
    uint32_t rest_tick;   ///< the tick of the last stop or fault
    uint32_t max_tick_us; ///< longest time from a tick's start to its command
    uint32_t max_late_us; ///< largest delay of a tick's start
    uint32_t overruns;    ///< ticks over budget; stops at UINT32_MAX

    // Requests are counters that the background increments and the tick copies, so that they need no lock. `requests` counts all
    // except references. It is incremented after the request's own counter, so that a tick without requests reads no other one.
    // They have 32 bits, because a slow tick may come after a multiple of 256 requests.
    volatile uint32_t     starts, stops, acknowledgements, tares, requests, references;
    uint32_t              starts_seen, stops_seen, acknowledgements_seen, tares_seen, requests_seen, references_seen;
    volatile loop_force_t reference;
    volatile int32_t      position_reference;
    volatile bool         has_position_reference; ///< a host has set it since the last stop, fault or acknowledgement
    volatile bool         hosted;                 ///< the reference comes from a host, which must renew it
    volatile bool         changed;                ///< the params are not those that were checked
    const drive_setup_t *volatile next;           ///< the setup that the next tick uses
    drive_state_t logged_state;

    uint32_t due_us;    ///< when the next tick should start
    bool     timed;     ///< due_us is valid
    bool     host_lost; ///< r goes to safe_reference_n, or is there

    loop_force_t   sensor_zero; ///< reading at 0 N, from the config or the last tare
    loop_force_t   last_reading;
    uint32_t       same_reading; ///< number of readings in a row that equal the one before
    uint32_t       bad_readings; ///< a bit for each of the last 32 ticks, the last one in bit 0
    faults_state_t lasting;
    int32_t        position, moved; ///< the arm's measured position, and its change in this tick
    int32_t        intended;        ///< the part of position_reference that the ticks have followed so far
    bool           has_intended;    ///< `intended` has begun at a host's position reference

    volatile drive_tare_t tare;
    uint32_t              tare_ticks; ///< ticks left
    scaling_sum_t         tare_sum;

    expected_state_t expected;

    loop_memory_t *memory; ///< memory of a feed-forward; null: none
    loop_state_t   loop;
    loop_signals_t signals; ///< of the last tick in RUN
#if DRIVE_FEEDFORWARD
    uint32_t          logged_warnings;
    volatile uint32_t restores, forgets;
    uint32_t          restores_seen, forgets_seen;
    uint32_t          delayed; ///< requests that wait until the learner has no sample
#endif
} drive_t;

/// Makes `setup` and checks `config` by itself, with the port's converters and with the loop's params. Returns false and fills
/// `error` for the first field that does not fit; do not use `setup` then. `params` must outlive `setup`. Not for the tick.
bool drive_setup_init(drive_setup_t        *setup,
                      const drive_config_t *config,
                      const loop_params_t  *params,
                      const port_t         *port,
                      drive_config_error_t *error);

/// Starts the drive after power-up, with its outputs off. A fault `found` puts it into FAULT: until the next power-up if it
/// is the self-test's (selftest.h), DRIVE_FAULT_PARAMS or DRIVE_FAULT_CLOCK, otherwise until it is acknowledged. `port` and
/// `setup` must outlive the drive. If the fault lasts until the next power-up, only the config of `setup` is read.
void drive_init(drive_t *drive, const port_t *port, const drive_setup_t *setup, drive_fault_t found);

/// Attaches the memory of a feed-forward, initialised by loop_forget or holding the values of an earlier run. Learned values
/// outlast stops and faults. Call it once, before the first tick: without memory the feed-forward compensates nothing.
void drive_attach(drive_t *drive, loop_memory_t *memory);

/// Runs one tick: reads the inputs, checks them, runs the loop in RUN, and writes the command.
void drive_tick(drive_t *drive);

/// Learns in the background, on a processor without an FPU. Call it every 10 ticks or more often. Late calls are counted and only
/// slow learning down. It may run on another core only if that core keeps the order of its accesses, as a Cortex-M0+ does.
void drive_learn(drive_t *drive);

/// Sets a host's reference from the next tick on. The host must renew it within reference_ms.
void drive_reference(drive_t *drive, loop_force_t r);

/// Sets a reference of a person or of the drive itself, which stays without being renewed.
void drive_set_reference(drive_t *drive, loop_force_t r);

/// Sets the target of the host's position loop, in units of the arm's position. In a drive without a force sensor, friction
/// opposes the motion of this target, or the measured motion if no target was set since the last stop, fault or
/// acknowledgement. The first target after these is not a motion.
void drive_position_reference(drive_t *drive, int32_t position);

/// Reports that the params in use are not those that were checked: DRIVE_FAULT_CONFIG_CHANGED in the next tick.
void drive_condemn(drive_t *drive);

/// These functions make requests to the next tick. A start acts only in IDLE, an acknowledgement only in FAULT, a tare only
/// in IDLE.
void drive_start(drive_t *drive);
void drive_stop(drive_t *drive);
void drive_acknowledge(drive_t *drive);
void drive_tare(drive_t *drive);

#if DRIVE_FEEDFORWARD
/// Clears the warnings in the next tick. Friction that the guard has faded returns within its fade_time_s; friction that is
/// fed back is fed forward again.
void drive_restore(drive_t *drive);

/// Forgets the learned values of a feed-forward in the next tick, unless the power stage is on.
void drive_forget(drive_t *drive);

/// Returns the drive_warning_t bits, and a short text for one of them.
uint32_t    drive_warnings(const drive_t *drive);
const char *drive_warning_text(drive_warning_t warning);
#endif

/// Makes the next tick use `setup`, which must have been made for the same port, tick and full scale. The loop keeps its
/// state, so u does not jump. A tare is lost if sensor_zero_units differs. The old setup may be reused once a tick has ended
/// after which drive_setup returns the new one.
void                 drive_change(drive_t *drive, const drive_setup_t *setup);
const drive_setup_t *drive_setup(const drive_t *drive);

/// Returns the reading at 0 N in units; after a tare this is the sensor_zero_units to keep.
float drive_sensor_zero_units(const drive_t *drive);

/// If the state has changed, writes it to the log in one line, with the cause and the tick of a fault. Writes another line
/// for each new warning.
void drive_log(drive_t *drive);

/// Writes the line of the state unconditionally.
void drive_report(drive_t *drive);

/// Writes to the log which checks the config turns off.
void drive_report_off(const port_t *port, const drive_config_t *config);

/// Returns a short text for a log. Never null.
const char *drive_fault_text(drive_fault_t fault);

#endif
