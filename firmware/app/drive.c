#include "app/drive.h"

static void off(const drive_t *drive)
{
    drive->port->command(drive->port->context, 0);
    drive->port->enable(drive->port->context, false);
}

static void stop_with(drive_t *drive, drive_fault_t cause)
{
    off(drive);
    drive->state      = DRIVE_FAULT;
    drive->fault      = cause;
    drive->fault_tick = drive->ticks;
    drive->limits     = 0;
}

void drive_init(drive_t              *drive,
                const port_t         *port,
                const loop_params_t  *params,
                const drive_config_t *config,
                drive_fault_t         found)
{
    *drive =
        (drive_t){.port = port, .params = params, .config = *config, .state = DRIVE_IDLE, .logged_state = DRIVE_FAULT};
    loop_reset(&drive->loop);
    off(drive);
    if (found != DRIVE_FAULT_NONE)
    {
        stop_with(drive, found);
        drive->logged_state = DRIVE_IDLE;
    }
}

// --- the checks of a tick ------------------------------------------------------------------------------------------

static drive_fault_t check_inputs(const drive_t *drive)
{
    const uint32_t inputs = drive->port->inputs(drive->port->context);
    if ((inputs & PORT_INPUT_EMERGENCY_STOP) != 0u)
    {
        return DRIVE_FAULT_EMERGENCY_STOP;
    }
    return (inputs & PORT_INPUT_POWER_FAULT) != 0u ? DRIVE_FAULT_POWER : DRIVE_FAULT_NONE;
}

/// Each tick is due one period after the last due time, so that jitter does not add up. After a tick that is too early or too
/// late, the next one is due a period after that tick.
static drive_fault_t check_time(drive_t *drive, uint32_t now_us)
{
    const drive_config_t *config = &drive->config;
    const uint32_t        late   = now_us - drive->due_us; // modulo 2^32: an early tick gives a value near 2^32
    const uint32_t        early  = drive->due_us - now_us;
    drive_fault_t         found  = DRIVE_FAULT_NONE;
    if (drive->timed && late != 0u)
    {
        if (early <= config->period_us)
        {
            found = early > config->late_us ? DRIVE_FAULT_TICK_EARLY : DRIVE_FAULT_NONE;
        }
        else
        {
            drive->max_late_us = late > drive->max_late_us ? late : drive->max_late_us;
            found              = late >= config->period_us ? DRIVE_FAULT_TICK_MISSED
                                 : late > config->late_us  ? DRIVE_FAULT_TICK_LATE
                                                           : DRIVE_FAULT_NONE;
        }
    }
    drive->due_us = (drive->timed && found == DRIVE_FAULT_NONE ? drive->due_us : now_us) + config->period_us;
    drive->timed  = true;
    return found;
}

static drive_fault_t check_sensor(drive_t *drive, loop_force_t r, loop_force_t *y)
{
    *y = 0;
    if (!drive->port->read_force(drive->port->context, y))
    {
        return DRIVE_FAULT_SENSOR_SILENT;
    }
    if (loop_is_nan(*y) || loop_is_nan(r))
    {
        return DRIVE_FAULT_NAN;
    }
    const bool same = loop_word(*y) == loop_word(drive->last_y);
    drive->same_y   = same ? drive->same_y + (drive->same_y != UINT32_MAX) : 0u;
    drive->last_y   = *y;
    if (!loop_is_credible(drive->params, *y))
    {
        return DRIVE_FAULT_SENSOR_RANGE;
    }
    return drive->config.stuck_ticks > 0u && drive->same_y >= drive->config.stuck_ticks ? DRIVE_FAULT_SENSOR_STUCK
                                                                                        : DRIVE_FAULT_NONE;
}

static drive_fault_t first_of(drive_fault_t a, drive_fault_t b)
{
    return a != DRIVE_FAULT_NONE ? a : b;
}

// --- the tick ------------------------------------------------------------------------------------------------------

typedef struct
{
    bool start, stop, acknowledge;
} requests_t;

/// A request is valid for the next tick only: executed there or dropped.
static requests_t take_requests(drive_t *drive)
{
    const uint8_t    starts           = drive->starts;
    const uint8_t    stops            = drive->stops;
    const uint8_t    acknowledgements = drive->acknowledgements;
    const requests_t requests         = {.start       = starts != drive->starts_seen,
                                         .stop        = stops != drive->stops_seen,
                                         .acknowledge = acknowledgements != drive->acknowledgements_seen};
    drive->starts_seen                = starts;
    drive->stops_seen                 = stops;
    drive->acknowledgements_seen      = acknowledgements;
    return requests;
}

static void run_loop(drive_t *drive, loop_force_t r, loop_force_t y, uint32_t start_us)
{
    const loop_force_t u    = loop_step(drive->params, &drive->loop, r, y, &drive->signals);
    const uint32_t     took = drive->port->time_us(drive->port->context) - start_us;
    drive->max_tick_us      = took > drive->max_tick_us ? took : drive->max_tick_us;
    if (took > drive->config.budget_us)
    {
        drive->overruns += drive->overruns != UINT32_MAX;
        stop_with(drive, DRIVE_FAULT_TICK_OVERRUN);
        return;
    }
    drive->limits = (drive->signals.controller.limited ? (uint32_t)DRIVE_LIMIT_COMMAND : 0u) |
                    (loop_is_credible(drive->params, r) ? 0u : (uint32_t)DRIVE_LIMIT_REFERENCE);
    drive->port->command(drive->port->context, u);
}

static bool is_for_good(drive_fault_t fault)
{
    return fault >= DRIVE_FAULT_IMAGE && fault <= DRIVE_FAULT_PARAMS;
}

void drive_tick(drive_t *drive, loop_force_t r)
{
    const uint32_t   start_us = drive->port->time_us(drive->port->context);
    const requests_t requests = take_requests(drive);
    drive->ticks++;
    if (drive->state == DRIVE_FAULT && is_for_good(drive->fault))
    {
        off(drive); // after a failed self-test or without valid params nothing else runs
        return;
    }

    // Every check runs in every tick, so that the state of one does not depend on the result of another.
    loop_force_t        y;
    const drive_fault_t input  = check_inputs(drive);
    const drive_fault_t timing = check_time(drive, start_us);
    const drive_fault_t sensor = check_sensor(drive, r, &y);
    const drive_fault_t found  = first_of(input, first_of(timing, sensor));

    if (drive->state == DRIVE_FAULT)
    {
        off(drive);
        if (requests.acknowledge && found == DRIVE_FAULT_NONE)
        {
            drive->state = DRIVE_IDLE;
            drive->fault = DRIVE_FAULT_NONE;
        }
        return;
    }
    if (found != DRIVE_FAULT_NONE)
    {
        stop_with(drive, found);
        return;
    }
    if (drive->state == DRIVE_IDLE && requests.start && !requests.stop)
    {
        loop_reset(&drive->loop);
        drive->port->enable(drive->port->context, true);
        drive->state = DRIVE_RUN;
    }
    else if (requests.stop)
    {
        drive->state = DRIVE_IDLE;
    }
    if (drive->state == DRIVE_RUN)
    {
        run_loop(drive, r, y, start_us);
        return;
    }
    drive->limits = 0;
    off(drive);
}

// --- from the background -------------------------------------------------------------------------------------------

void drive_start(drive_t *drive)
{
    drive->starts = (uint8_t)(drive->starts + 1u);
}

void drive_stop(drive_t *drive)
{
    drive->stops = (uint8_t)(drive->stops + 1u);
}

void drive_acknowledge(drive_t *drive)
{
    drive->acknowledgements = (uint8_t)(drive->acknowledgements + 1u);
}

const char *drive_fault_text(drive_fault_t fault)
{
    static const char *const texts[] = {[DRIVE_FAULT_NONE]           = "none",
                                        [DRIVE_FAULT_IMAGE]          = "self-test: image",
                                        [DRIVE_FAULT_RAM]            = "self-test: RAM",
                                        [DRIVE_FAULT_GOLDEN]         = "self-test: golden vector",
                                        [DRIVE_FAULT_PARAMS]         = "params refused",
                                        [DRIVE_FAULT_WATCHDOG]       = "reset by the watchdog",
                                        [DRIVE_FAULT_EMERGENCY_STOP] = "emergency stop",
                                        [DRIVE_FAULT_POWER]          = "power stage",
                                        [DRIVE_FAULT_TICK_MISSED]    = "tick missed",
                                        [DRIVE_FAULT_TICK_LATE]      = "tick late",
                                        [DRIVE_FAULT_TICK_EARLY]     = "tick early",
                                        [DRIVE_FAULT_SENSOR_SILENT]  = "sensor silent",
                                        [DRIVE_FAULT_NAN]            = "not a number",
                                        [DRIVE_FAULT_SENSOR_RANGE]   = "sensor out of range",
                                        [DRIVE_FAULT_SENSOR_STUCK]   = "sensor stuck",
                                        [DRIVE_FAULT_TICK_OVERRUN]   = "tick overrun"};
    return (unsigned)fault < DRIVE_FAULTS ? texts[fault] : "unknown";
}

static void write_number(const port_t *port, uint32_t number)
{
    char  digits[11] = "";
    char *digit      = digits + sizeof digits - 1;
    do
    {
        *--digit = (char)('0' + number % 10u);
        number /= 10u;
    } while (number > 0u);
    port_write(port, digit);
}

void drive_report(drive_t *drive)
{
    static const char *const names[] = {[DRIVE_IDLE] = "idle", [DRIVE_RUN] = "run", [DRIVE_FAULT] = "fault: "};

    const port_t       *port  = drive->port;
    const drive_state_t state = drive->state;
    drive->logged_state       = state;
    port_write(port, names[state]);
    if (state == DRIVE_FAULT)
    {
        port_write(port, drive_fault_text(drive->fault));
        port_write(port, " since tick ");
        write_number(port, drive->fault_tick);
    }
    port_write(port, " at tick ");
    write_number(port, drive->ticks);
    port_write(port, ", longest tick ");
    write_number(port, drive->max_tick_us);
    port_write(port, " us, latest ");
    write_number(port, drive->max_late_us);
    port_write(port, " us\n");
}

void drive_log(drive_t *drive)
{
    if (drive->state != drive->logged_state)
    {
        drive_report(drive);
    }
}
