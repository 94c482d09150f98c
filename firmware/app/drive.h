/// The drive: when the force loop may run, and what stops it. No registers; the board is a port_t.
///
///     power-up --self-test--> IDLE --start--> STARTING --ready--> RUN
///                  |           ^ |  ^            |  |              | |
///                  |           | |  '---stop-----'--|--------------' |
///                  |  acknowl. | | fault            | fault          | fault
///                  v  (cause   | v                  v                v
///                FAULT  gone) FAULT <-------------------------------'
///                (for good)
///
/// A limit acts and the loop runs on; a fault stops the drive. Within the tick that detects a fault the power stage goes off
/// and the command to 0, and the cause is latched. Only an acknowledgement leaves FAULT, to IDLE, and only once the
/// cause is gone. A start requested before that is dropped, so the drive never restarts by itself. A failed self-test, wrong
/// params, a wrong clock and changed params last until the next power-up. After a reset that nobody asked for the drive begins in FAULT.
///
/// In STARTING the power stage is on and the command 0 until the stage is ready; without a ready input (ready_ms of 0) the
/// tick of the start is the first in RUN. The reference is 0 after every stop, fault and acknowledgement, until a new one.
///
/// A reference that a host has set must be renewed within reference_ms, or the drive stops for DRIVE_FAULT_REFERENCE. With a
/// reference_ramp_n_per_s it does not: r goes to safe_reference_n at that rate and stays there until the host is back.
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

/// Limits that acted in a tick, as bits; the loop runs on.
typedef enum
{
    DRIVE_LIMIT_COMMAND   = 1, ///< u is limited to u_min or u_max
    DRIVE_LIMIT_REFERENCE = 2, ///< r is beyond input_max: the loop coasts
    DRIVE_LIMIT_HOST      = 4  ///< the reference was not renewed: r is on its way to safe_reference_n, or there
} drive_limit_t;

/// What a person should look at, as bits; the drive runs on. They stay until drive_restore, over stops and faults.
typedef enum
{
    DRIVE_WARNING_HUNTING   = 1, ///< the guard has faded the compensation of friction, tribo/guard.h
    DRIVE_WARNING_OVERSHOOT = 2,
    DRIVE_WARNING_BOUND     = 4, ///< what is learned of breakaway stays at a bound: not to be trusted
    DRIVE_WARNING_HARM      = 8, ///< friction was fed back: fed forward it cost more effort than it saved
    DRIVE_WARNINGS_END      = 16
} drive_warning_t;

/// What stops the drive. Of several causes in one tick the first that is checked is latched; the numbers are the bus's.
typedef enum
{
    DRIVE_FAULT_NONE,
    DRIVE_FAULT_IMAGE,           ///< self-test: the image differs from the one built; for good
    DRIVE_FAULT_RAM,             ///< self-test: for good
    DRIVE_FAULT_GOLDEN,          ///< self-test: the loop computes a wrong result; for good
    DRIVE_FAULT_PARAMS,          ///< config or params are not for this drive; for good
    DRIVE_FAULT_CLOCK,           ///< no crystal, or not the one that the config names; for good
    DRIVE_FAULT_STORE,           ///< at power-up: the saved params are damaged or of other firmware
    DRIVE_FAULT_WATCHDOG,        ///< at power-up: the watchdog ended the last run
    DRIVE_FAULT_EXCEPTION,       ///< at power-up: a hard fault or an unexpected exception did
    DRIVE_FAULT_CRYSTAL,         ///< at power-up: the crystal stopped
    DRIVE_FAULT_BROWN_OUT,       ///< at power-up: the supply fell so far that the chip was reset
    DRIVE_FAULT_RESTART,         ///< at power-up: the software reset the chip
    DRIVE_FAULT_EMERGENCY_STOP,  ///< the input
    DRIVE_FAULT_SUPPLY,          ///< the input: the supply is low
    DRIVE_FAULT_POWER,           ///< the power stage's fault input
    DRIVE_FAULT_NOT_READY,       ///< the power stage: ready_ms after it was enabled, or in RUN
    DRIVE_FAULT_TICK_MISSED,     ///< a whole period or more late
    DRIVE_FAULT_TICK_LATE,       ///< by more than late_us
    DRIVE_FAULT_TICK_EARLY,      ///< by more than late_us: a clock runs wrong
    DRIVE_FAULT_SENSOR_SILENT,   ///< no new reading since the last tick
    DRIVE_FAULT_NAN,             ///< the sensor or the reference
    DRIVE_FAULT_SENSOR_RANGE,    ///< |y| beyond input_max
    DRIVE_FAULT_SENSOR_STUCK,    ///< stuck_ticks readings in a row without a change
    DRIVE_FAULT_REFERENCE,       ///< the host's not renewed for reference_ms, in RUN
    DRIVE_FAULT_TICK_OVERRUN,    ///< longer than budget_us from its start to its command
    DRIVE_FAULT_RESIDUAL,        ///< the sensor does not show what u leads to
    DRIVE_FAULT_COMMAND_LIMIT,   ///< u at a limit for command_limit_ms
    DRIVE_FAULT_CONFIG_CHANGED,  ///< params that the drive runs with are not those that were checked; for good
    DRIVE_FAULT_OVER_CURRENT,    ///< measured, beyond over_current_a
    DRIVE_FAULT_BUS_VOLTAGE,     ///< measured, outside bus_low_v to bus_high_v
    DRIVE_FAULT_TEMPERATURE,     ///< measured, above temperature_max_c
    DRIVE_FAULT_BROWN_OUT_LEVEL, ///< at power-up: the chip would run on with a supply too low for it
    DRIVE_FAULT_TRACKING,        ///< y away from r for tracking_ms
    DRIVE_FAULT_SPEED,           ///< of the arm, by its position
    DRIVE_FAULT_SWING,           ///< u or y to and fro, by no wish of r
    DRIVE_FAULTS
} drive_fault_t;

/// What a tick reads and nothing writes: the loop's params, and the config as the arithmetic has it. Made by
/// drive_setup_init.
typedef struct
{
    const loop_params_t *params; ///< a guard is in them
    drive_config_t       config;
    scaling_t            scaling;
    faults_bounds_t      bounds;
    expected_t           expected;
    bool                 has_sensor;      ///< of force; without one y is 0
    loop_widths_t        widths_per_unit; ///< of the position, without one; 0: it is not used
} drive_setup_t;

/// Of the last tare that was requested.
typedef enum
{
    DRIVE_TARE_NONE,
    DRIVE_TARE_BUSY,
    DRIVE_TARE_DONE,
    DRIVE_TARE_REFUSED ///< not in IDLE, turned off, or the mean force is beyond tare_max_n
} drive_tare_t;

#define DRIVE_TARE_TICKS 256u ///< whose mean reading becomes 0 N

/// Read only: the functions below write it. The small members first: code that reaches them is shorter.
typedef struct
{
    const port_t *port;
    const drive_setup_t *volatile setup;

    volatile drive_state_t state;

    drive_fault_t fault;  ///< the cause, as long as the state is DRIVE_FAULT
    uint32_t      limits; ///< drive_limit_t bits of the last tick
    loop_force_t  r, y;   ///< of the last tick; y without a fault of the sensor

    uint32_t ticks;       ///< since power-up; wraps
    uint32_t fault_tick;  ///< the tick that latched the cause
    uint32_t rest_tick;   ///< the tick of the last stop or fault
    uint32_t max_tick_us; ///< longest from a tick's start to its command
    uint32_t max_late_us; ///< latest start
    uint32_t overruns;    ///< ticks over budget; stops at UINT32_MAX

    // Requests are counters, incremented by the background; the tick copies them. This needs no lock. `asked` counts all but
    // references, after the request's own counter, so that a tick without any looks at no other.
    volatile uint8_t      starts, stops, acknowledgements, tares, asked, references;
    uint8_t               starts_seen, stops_seen, acknowledgements_seen, tares_seen, asked_seen, references_seen;
    volatile loop_force_t reference;
    volatile int32_t      position_reference;
    volatile bool         is_told;      ///< it, since the last stop, fault or acknowledgement
    volatile bool         hosted;       ///< the reference is a host's, which must renew it
    volatile bool         changed;      ///< the params are not those that were checked
    const drive_setup_t *volatile next; ///< a setup to go on with
    drive_state_t logged_state;

    uint32_t due_us;    ///< when the next tick should start
    bool     timed;     ///< due_us is valid
    bool     host_lost; ///< r is on its way to safe_reference_n, or there

    loop_force_t   sensor_zero; ///< reading at 0 N, by the config or by the last tare
    loop_force_t   last_reading;
    uint32_t       same_reading; ///< readings equal to the one before
    uint32_t       bad_readings; ///< of the last 32 ticks, the last one in bit 0
    faults_state_t lasting;
    int32_t        position, moved; ///< of the arm, and in this tick; where it is measured
    int32_t        intended;        ///< position, as far as this tick has taken it
    bool           was_told;        ///< `intended` has begun where a host told it to

    volatile drive_tare_t tare;
    uint32_t              tare_ticks; ///< left
    scaling_sum_t         tare_sum;

    expected_state_t expected;

    loop_memory_t *memory; ///< of a feed-forward; null: none
    loop_state_t   loop;
    loop_signals_t signals; ///< of the last tick in RUN
#if DRIVE_FEEDFORWARD
    uint32_t         logged_warnings;
    volatile uint8_t restores, forgets;
    uint8_t          restores_seen, forgets_seen;
    uint32_t         delayed; ///< requests until the learner has no sample
#endif
} drive_t;

/// Checks `config` by itself, with the port's converters and with the loop's params, and makes `setup`. False with `error`
/// for the first field that does not fit: then `setup` is not to be used. `params` must outlive it. Not for the tick.
bool drive_setup_init(drive_setup_t        *setup,
                      const drive_config_t *config,
                      const loop_params_t  *params,
                      const port_t         *port,
                      drive_config_error_t *error);

/// The drive after power-up: outputs off. With the fault `found` the drive is in FAULT: for good, if it is the self-test's
/// (selftest.h), DRIVE_FAULT_PARAMS or DRIVE_FAULT_CLOCK, else until acknowledged. `port` must outlive the drive, and so must
/// `setup`, of which nothing but the config is read if the fault is for good.
void drive_init(drive_t *drive, const port_t *port, const drive_setup_t *setup, drive_fault_t found);

/// Memory for a loop with a feed-forward, of which loop_forget or an earlier run has made a beginning: what is learned outlasts
/// stops and faults. Once, before the first tick; without it such a loop compensates nothing.
void drive_attach(drive_t *drive, loop_memory_t *memory);

/// One tick: reads the inputs, checks them, runs the loop in RUN, and writes the command.
void drive_tick(drive_t *drive);

/// What the tick leaves to the background: learning, on a processor without an FPU. Call it every 10 ticks or more often; later is counted,
/// and costs nothing but time to learn. On another core only if that keeps the order of its accesses, as a Cortex-M0+ does.
void drive_learn(drive_t *drive);

/// A host's reference from the next tick on. It must be renewed within reference_ms.
void drive_reference(drive_t *drive, loop_force_t r);

/// Likewise of a person or of the drive itself: it stays without being renewed.
void drive_set_reference(drive_t *drive, loop_force_t r);

/// Where the host's position loop wants the arm, in units of its position: the motion that friction opposes in a drive without a force
/// sensor. Not told since the last stop, fault or acknowledgement: the measured motion. The first is no motion.
void drive_position_reference(drive_t *drive, int32_t position);

/// The params that the drive runs with are not those that were checked: DRIVE_FAULT_CONFIG_CHANGED in the next tick.
void drive_condemn(drive_t *drive);

/// Requests for the next tick. A start acts only in IDLE, an acknowledgement only in FAULT, a tare only in IDLE.
void drive_start(drive_t *drive);
void drive_stop(drive_t *drive);
void drive_acknowledge(drive_t *drive);
void drive_tare(drive_t *drive);

#if DRIVE_FEEDFORWARD
/// The next tick takes the warnings back; what the guard has faded comes back within its fade_time_s, what is fed back is fed forward.
void drive_restore(drive_t *drive);

/// The next tick forgets what a feed-forward has learned, unless the power stage is on.
void drive_forget(drive_t *drive);

/// drive_warning_t bits, and a few words for one of them.
uint32_t    drive_warnings(const drive_t *drive);
const char *drive_warning_text(drive_warning_t warning);
#endif

/// The next tick goes on with `setup`, which must have been made for the same port, tick and full scale; the loop takes its
/// state over without a bump in u. A tare is lost if sensor_zero_units differs. The old one may be reused once a tick
/// that took the new one, as drive_setup says, has ended.
void                 drive_change(drive_t *drive, const drive_setup_t *setup);
const drive_setup_t *drive_setup(const drive_t *drive);

/// The reading at 0 N in units: after a tare the sensor_zero_units to keep.
float drive_sensor_zero_units(const drive_t *drive);

/// Writes a line to the log if the state has changed: the state, and for a fault its cause and tick. One more for new warnings.
void drive_log(drive_t *drive);

/// Writes that line unconditionally.
void drive_report(drive_t *drive);

/// Writes which checks the config turns off.
void drive_report_off(const port_t *port, const drive_config_t *config);

/// A few words for a log. Never null.
const char *drive_fault_text(drive_fault_t fault);

#endif
