#include "app/drive.h"

#include "app/log.h"

#include <stdatomic.h>
#include <stddef.h>

static bool refuse(drive_config_error_t *error, unsigned field, float value, float low, float high)
{
    *error = (drive_config_error_t){.field = field, .value = value, .low = low, .high = high};
    return false;
}

/// Refuses the level of a quantity that the board does not measure, because it would never be reached.
static bool check_measured_levels(const drive_config_t *config, const port_t *port, drive_config_error_t *error)
{
    static const struct
    {
        uint8_t field, needs;
    } levels[] = {{DRIVE_CONFIG_over_current_a, PORT_MEASURES_CURRENT},
                  {DRIVE_CONFIG_bus_low_v, PORT_MEASURES_BUS},
                  {DRIVE_CONFIG_bus_high_v, PORT_MEASURES_BUS},
                  {DRIVE_CONFIG_temperature_max_c, PORT_MEASURES_TEMPERATURE},
                  {DRIVE_CONFIG_speed_max_units_per_s, PORT_MEASURES_POSITION},
                  {DRIVE_CONFIG_motion_units, PORT_MEASURES_POSITION}};
    for (size_t i = 0; i < sizeof levels / sizeof levels[0]; i++)
    {
        const float level = drive_config_value(config, levels[i].field);
        if (level > 0.0f && (port->measures & levels[i].needs) == 0u)
        {
            return refuse(error, levels[i].field, level, 0.0f, 0.0f);
        }
    }
    return true;
}

/// Refuses the levels of the force sensor on a drive without one.
static bool check_sensor_levels(const drive_setup_t *setup, drive_config_error_t *error)
{
    static const uint8_t levels[] = {DRIVE_CONFIG_residual_n,
                                     DRIVE_CONFIG_tracking_n,
                                     DRIVE_CONFIG_stuck_ticks,
                                     DRIVE_CONFIG_tare_max_n};
    for (size_t i = 0; !setup->has_sensor && i < sizeof levels; i++)
    {
        const float level = drive_config_value(&setup->config, levels[i]);
        if (level > 0.0f)
        {
            return refuse(error, levels[i], level, 0.0f, 0.0f);
        }
    }
    return true;
}

#define TRAVEL_MOST                                                                                                    \
    2147483520.0f ///< the largest float below 2^31 units, from where on a wrapping position seems to move the other way

/// Refuses a level beyond the limit of its number format: the value that is compared with it could not exceed it.
static bool check_reachable_levels(const drive_config_t *config, drive_config_error_t *error)
{
    static const uint8_t forces[] = {DRIVE_CONFIG_residual_n, DRIVE_CONFIG_tracking_n, DRIVE_CONFIG_tare_max_n};
    for (size_t i = 0; TRIBO_IS_Q31 && i < sizeof forces; i++)
    {
        const float level = drive_config_value(config, forces[i]);
        if (level > config->full_scale_n)
        {
            return refuse(error, forces[i], level, drive_config_fields[forces[i]].low, config->full_scale_n);
        }
    }
    const float most = TRAVEL_MOST / (1e-3f * (float)config->speed_ms);
    return config->speed_max_units_per_s <= most || refuse(error,
                                                           DRIVE_CONFIG_speed_max_units_per_s,
                                                           config->speed_max_units_per_s,
                                                           drive_config_fields[DRIVE_CONFIG_speed_max_units_per_s].low,
                                                           most);
}

/// Refuses a safe_reference_n that the loop would not accept as a reference.
static bool check_safe_reference(const drive_setup_t *setup, drive_config_error_t *error)
{
    const float most = scaling_value(setup->params->TRIBO_N(input_max), setup->config.full_scale_n);
    return tribo_force_is_credible(setup->params, setup->bounds.safe_reference) ||
           refuse(error, DRIVE_CONFIG_safe_reference_n, setup->config.safe_reference_n, -most, most);
}

static void take_motion_scale(drive_setup_t *setup)
{
    const drive_config_t *const config = &setup->config;
    const bool                  is_on  = !setup->has_sensor && config->motion_units > 0u;
    const loop_widths_t         widths = is_on ? loop_widths_per_unit(config->motion_units) : 0;
    setup->widths_per_unit             = config->motion_reversed != 0u ? -widths : widths;
}

bool drive_setup_init(drive_setup_t        *setup,
                      const drive_config_t *config,
                      const loop_params_t  *params,
                      const port_t         *port,
                      drive_config_error_t *error)
{
    setup->config     = *config;
    setup->params     = params;
    setup->has_sensor = loop_has_sensor(params);
    take_motion_scale(setup);
    if (!scaling_init(&setup->scaling, config, port, error) ||
        !scaling_suits(&setup->scaling, config, port, params, error))
    {
        return false;
    }
    faults_init(&setup->bounds, config, params);
    expected_init(&setup->expected, config, params);
    return check_measured_levels(config, port, error) && check_sensor_levels(setup, error) &&
           check_reachable_levels(config, error) && check_safe_reference(setup, error);
}

/// Takes the enable away first: the power stage is then off even if the output's driver blocks.
static void off(const drive_t *drive)
{
    drive->port->enable(drive->port->context, false);
    drive->port->command(drive->port->context, drive->setup->scaling.no_current);
}

/// Forgets the host's references, so that no old one acts after the next start.
static void drop_references(drive_t *drive)
{
    drive_set_reference(drive, 0);
    drive->has_position_reference = false;
}

static void stop_with(drive_t *drive, drive_fault_t cause)
{
    off(drive);
    drive->state      = DRIVE_FAULT;
    drive->fault      = cause;
    drive->fault_tick = drive->ticks;
    drive->rest_tick  = drive->ticks;
    drive->limits     = 0;
    drop_references(drive);
}

void drive_init(drive_t *drive, const port_t *port, const drive_setup_t *setup, drive_fault_t found)
{
    *drive = (drive_t){.port         = port,
                       .setup        = setup,
                       .next         = setup,
                       .sensor_zero  = setup->scaling.sensor_zero,
                       .state        = DRIVE_IDLE,
                       .logged_state = DRIVE_FAULT};
    expected_reset(&drive->expected);
#if DRIVE_FEEDFORWARD
    TRIBO(guard, reset)(&drive->loop.guard);
#endif
    off(drive);
    if (found != DRIVE_FAULT_NONE)
    {
        stop_with(drive, found);
        drive->logged_state = DRIVE_IDLE;
    }
}

// --- the checks of a tick ------------------------------------------------------------------------------------------

/// Returns the fault of the inputs, the most important one first.
static drive_fault_t check_inputs(const drive_setup_t *setup, drive_state_t state, uint32_t inputs)
{
    static const struct
    {
        uint8_t input, fault;
    } causes[] = {{PORT_INPUT_EMERGENCY_STOP, DRIVE_FAULT_EMERGENCY_STOP},
                  {PORT_INPUT_SUPPLY, DRIVE_FAULT_SUPPLY},
                  {PORT_INPUT_OVER_CURRENT, DRIVE_FAULT_OVER_CURRENT},
                  {PORT_INPUT_OVER_VOLTAGE, DRIVE_FAULT_BUS_VOLTAGE},
                  {PORT_INPUT_POWER_FAULT, DRIVE_FAULT_POWER}};
    if (inputs == 0u)
    {
        return DRIVE_FAULT_NONE;
    }
    for (size_t i = 0; i < sizeof causes / sizeof causes[0]; i++)
    {
        if ((inputs & causes[i].input) != 0u)
        {
            return (drive_fault_t)causes[i].fault;
        }
    }
    const bool must_be_ready = state == DRIVE_RUN && setup->bounds.ready_ticks > 0u;
    return must_be_ready && (inputs & PORT_INPUT_NOT_READY) != 0u ? DRIVE_FAULT_NOT_READY : DRIVE_FAULT_NONE;
}

/// A tick is due one period after the last due time, so that jitter does not add up. After a tick that is too early or too
/// late, the next one is due a period after that tick.
static drive_fault_t check_time(drive_t *drive, const drive_setup_t *setup, uint32_t now_us)
{
    const drive_config_t *config = &setup->config;
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

/// Reads the sensor into drive->y.
static drive_fault_t read_sensor(drive_t *drive, const drive_setup_t *setup, loop_force_t *reading)
{
    if (!drive->port->read_sensor(drive->port->context, reading))
    {
        return DRIVE_FAULT_SENSOR_SILENT;
    }
    const loop_force_t y = scaling_force(&setup->scaling, drive->sensor_zero, *reading);
    drive->y             = y;
    if (tribo_force_is_credible(setup->params, y))
    {
        return DRIVE_FAULT_NONE;
    }
    return tribo_force_is_nan(y) ? DRIVE_FAULT_NAN : DRIVE_FAULT_SENSOR_RANGE;
}

/// Reads and checks the sensor. A bad reading that is not yet a fault leaves y as it was. Without a sensor y is 0.
static drive_fault_t check_sensor(drive_t *drive, const drive_setup_t *setup, loop_force_t *reading)
{
    if (!setup->has_sensor)
    {
        drive->y = 0;
        return DRIVE_FAULT_NONE;
    }
    const loop_force_t  y_before = drive->y;
    const drive_fault_t bad      = read_sensor(drive, setup, reading);
    if (faults_readings(&setup->bounds, &drive->bad_readings, &drive->lasting.bad, bad != DRIVE_FAULT_NONE))
    {
        return bad;
    }
    if (bad != DRIVE_FAULT_NONE)
    {
        drive->y = y_before;
        *reading = drive->last_reading;
        return DRIVE_FAULT_NONE;
    }
    const bool same     = tribo_force_word(*reading) == tribo_force_word(drive->last_reading);
    drive->same_reading = same ? drive->same_reading + (drive->same_reading != UINT32_MAX) : 0u;
    drive->last_reading = *reading;
    return setup->config.stuck_ticks > 0u && drive->same_reading >= setup->config.stuck_ticks ? DRIVE_FAULT_SENSOR_STUCK
                                                                                              : DRIVE_FAULT_NONE;
}

static drive_fault_t check_measured(drive_t *drive, const drive_setup_t *setup, drive_state_t state)
{
    const faults_bounds_t *bounds   = &setup->bounds;
    const port_t          *port     = drive->port;
    port_measured_t        measured = {0};
    if (!bounds->is_measured && setup->widths_per_unit == 0)
    {
        return DRIVE_FAULT_NONE;
    }
    port->measure(port->context, &measured);
    drive->moved           = (int32_t)((uint32_t)measured.position - (uint32_t)drive->position); // it may wrap
    drive->position        = measured.position;
    const bool current     = faults_over_current(bounds, &drive->lasting, measured.current_ma);
    const bool bus         = faults_bus_voltage(bounds, &drive->lasting, measured.bus_mv);
    const bool temperature = faults_temperature(bounds, &drive->lasting, measured.temperature_mc);
    const bool speed       = faults_speed(bounds, &drive->lasting, measured.position) && state == DRIVE_RUN;
    return current       ? DRIVE_FAULT_OVER_CURRENT
           : bus         ? DRIVE_FAULT_BUS_VOLTAGE
           : temperature ? DRIVE_FAULT_TEMPERATURE
           : speed       ? DRIVE_FAULT_SPEED
                         : DRIVE_FAULT_NONE;
}

/// Moves r by `step` towards `end`, or there at once if rounding would keep r where it is.
static loop_force_t approach(loop_force_t r, loop_force_t end, loop_force_t step)
{
    if (scaling_size((scaling_sum_t)end - r) <= step)
    {
        return end;
    }
    const loop_force_t next = r < end ? r + step : r - step;
    return next != r ? next : end;
}

/// Takes r, and checks that its host still renews it.
static drive_fault_t take_reference(drive_t *drive, const drive_setup_t *setup, drive_state_t state, bool renewed)
{
    const faults_bounds_t *bounds = &setup->bounds;
    const bool lost  = state == DRIVE_RUN && drive->hosted && faults_reference(bounds, &drive->lasting, renewed);
    drive->host_lost = lost && bounds->ramp > 0;
    drive->r         = drive->host_lost ? approach(drive->r, bounds->safe_reference, bounds->ramp) : drive->reference;
    if (tribo_force_is_nan(drive->r))
    {
        return DRIVE_FAULT_NAN;
    }
    return lost && !drive->host_lost ? DRIVE_FAULT_REFERENCE : DRIVE_FAULT_NONE;
}

static drive_fault_t first_of(drive_fault_t a, drive_fault_t b)
{
    return a != DRIVE_FAULT_NONE ? a : b;
}

// --- the tick ------------------------------------------------------------------------------------------------------

/// Requests of the background, as bits.
typedef enum
{
    REQUEST_RENEWED     = 1, ///< the reference was renewed
    REQUEST_START       = 2,
    REQUEST_STOP        = 4,
    REQUEST_ACKNOWLEDGE = 8,
    REQUEST_TARE        = 16,
    REQUEST_RESTORE     = 32,
    REQUEST_FORGET      = 64
} request_t;

static uint32_t take_request(const volatile uint32_t *count, uint32_t *seen, request_t request)
{
    const uint32_t now    = *count;
    const bool     is_new = now != *seen;
    *seen                 = now;
    return is_new ? (uint32_t)request : 0u;
}

/// A request is valid for the next tick only: executed there or dropped.
static uint32_t take_requests(drive_t *drive)
{
    uint32_t       requests = take_request(&drive->references, &drive->references_seen, REQUEST_RENEWED);
    const uint32_t count    = drive->requests;
    if (count != drive->requests_seen)
    {
        drive->requests_seen = count;
        atomic_thread_fence(memory_order_acquire);
        requests |= take_request(&drive->starts, &drive->starts_seen, REQUEST_START);
        requests |= take_request(&drive->stops, &drive->stops_seen, REQUEST_STOP);
        requests |= take_request(&drive->acknowledgements, &drive->acknowledgements_seen, REQUEST_ACKNOWLEDGE);
        requests |= take_request(&drive->tares, &drive->tares_seen, REQUEST_TARE);
#if DRIVE_FEEDFORWARD
        requests |= take_request(&drive->restores, &drive->restores_seen, REQUEST_RESTORE);
        requests |= take_request(&drive->forgets, &drive->forgets_seen, REQUEST_FORGET);
#endif
    }
    return requests;
}

static const drive_setup_t *take_setup(drive_t *drive)
{
    const drive_setup_t *next = drive->next;
    if (next == drive->setup)
    {
        return next;
    }
    if (next->config.sensor_zero_units != drive->setup->config.sensor_zero_units)
    {
        drive->sensor_zero = next->scaling.sensor_zero;
    }
    drive->setup = next;
    return next;
}

/// Checks the conditions that may only last for some time, once u is known.
static drive_fault_t check_rig(drive_t *drive, const faults_bounds_t *bounds, bool limited, loop_force_t u)
{
    faults_loop_t *lasting  = &drive->lasting.loop;
    const bool     residual = faults_residual(bounds, lasting, drive->y, drive->expected.y);
    const bool     at_limit = faults_command_limit(bounds, lasting, limited);
    const bool     swings   = faults_swinging(bounds, lasting, drive->r, drive->y, u, limited);
    const bool     tracking = faults_tracking(bounds, lasting, drive->y);
    return residual   ? DRIVE_FAULT_RESIDUAL
           : at_limit ? DRIVE_FAULT_COMMAND_LIMIT
           : swings   ? DRIVE_FAULT_SWING
           : tracking ? DRIVE_FAULT_TRACKING
                      : DRIVE_FAULT_NONE;
}

/// Returns the intended motion of this tick. A host writes positions less often than the drive ticks, so each tick takes a
/// part of the remaining distance. The host's first position says where the arm is and is no motion.
static int32_t take_intended(drive_t *drive)
{
    const bool has_target = drive->has_position_reference;
    atomic_thread_fence(memory_order_acquire); // the host's side may be on another core
    const int32_t target = drive->position_reference;
    if (!drive->has_intended)
    {
        drive->intended     = target;
        drive->has_intended = has_target;
    }
    const int32_t left = (int32_t)((uint32_t)target - (uint32_t)drive->intended);
    const int32_t part = left / 16 + (left > 0) - (left < 0);
    drive->intended    = (int32_t)((uint32_t)drive->intended + (uint32_t)part);
    return part;
}

static void run_loop(drive_t *drive, const drive_setup_t *setup, uint32_t start_us)
{
    const loop_force_t r = drive->r;
    if (setup->widths_per_unit != 0 && drive->memory != NULL)
    {
        loop_motion(drive->memory, take_intended(drive), drive->moved, setup->widths_per_unit);
    }
    const loop_force_t u = TRIBO(force_loop, step)(setup->params, &drive->loop, r, drive->y, &drive->signals);
    if (LOOP_LEARNS_IN_TICK)
    {
        loop_learn(setup->params, drive->memory);
    }

    const bool          limited = drive->signals.controller.limited;
    const drive_fault_t found   = check_rig(drive, &setup->bounds, limited, u);
    expected_step(&setup->expected, &drive->expected, u);

    const uint32_t took = drive->port->time_us(drive->port->context) - start_us;
    drive->max_tick_us  = took > drive->max_tick_us ? took : drive->max_tick_us;
    if (took > setup->config.budget_us)
    {
        drive->overruns += drive->overruns != UINT32_MAX;
        stop_with(drive, DRIVE_FAULT_TICK_OVERRUN);
        return;
    }
    if (found != DRIVE_FAULT_NONE)
    {
        drive->lasting.loop = (faults_loop_t){0}; // the levels begin anew after the acknowledgement
        stop_with(drive, found);
        return;
    }
    drive->limits = (limited ? (uint32_t)DRIVE_LIMIT_COMMAND : 0u) |
                    (drive->host_lost ? (uint32_t)DRIVE_LIMIT_HOST : 0u) |
                    (tribo_force_is_credible(setup->params, r) ? 0u : (uint32_t)DRIVE_LIMIT_REFERENCE);
    drive->port->command(drive->port->context, scaling_output(&setup->scaling, u));
}

/// Makes the mean of DRIVE_TARE_TICKS readings 0 N, if its force is within tare_max_n by the config's zero.
static void take_tare(drive_t *drive, bool requested, loop_force_t reading)
{
    const drive_setup_t *setup = drive->setup;
    if (requested)
    {
        drive->tare_ticks = DRIVE_TARE_TICKS;
        drive->tare_sum   = 0;
        drive->tare       = setup->bounds.tare_max > 0 ? DRIVE_TARE_BUSY : DRIVE_TARE_REFUSED;
    }
    if (drive->tare != DRIVE_TARE_BUSY)
    {
        return;
    }
    drive->tare_sum += reading;
    if (--drive->tare_ticks > 0u)
    {
        return;
    }
    const loop_force_t zero  = (loop_force_t)(drive->tare_sum / (scaling_sum_t)DRIVE_TARE_TICKS);
    const loop_force_t moved = scaling_force(&setup->scaling, setup->scaling.sensor_zero, zero);
    const bool         near  = moved <= setup->bounds.tare_max && moved >= -setup->bounds.tare_max;
    drive->sensor_zero       = near ? zero : drive->sensor_zero;
    drive->tare              = near ? DRIVE_TARE_DONE : DRIVE_TARE_REFUSED;
}

/// Ends a tare and refuses a new one, because the drive is not in IDLE.
static void refuse_tare(drive_t *drive, uint32_t requests)
{
    if ((requests & REQUEST_TARE) != 0u || drive->tare == DRIVE_TARE_BUSY)
    {
        drive->tare = DRIVE_TARE_REFUSED;
    }
}

/// True for a fault that lasts until the next power-up.
static bool is_for_good(drive_fault_t fault)
{
    return (fault >= DRIVE_FAULT_IMAGE && fault <= DRIVE_FAULT_CLOCK) || fault == DRIVE_FAULT_CONFIG_CHANGED;
}

/// A start soon after a stop keeps the levels, so that restarting does not hide a fault.
static void begin_levels(drive_t *drive, const drive_setup_t *setup)
{
    faults_state_t *lasting = &drive->lasting;
    lasting->reference      = 0;
    if (drive->ticks - drive->rest_tick > setup->bounds.rest_ticks)
    {
        lasting->loop     = (faults_loop_t){0};
        lasting->starting = 0;
    }
}

static drive_state_t change_state(drive_t *drive, const drive_setup_t *setup, drive_state_t state, uint32_t requests)
{
    if ((requests & REQUEST_STOP) != 0u)
    {
        drive->rest_tick = state == DRIVE_IDLE ? drive->rest_tick : drive->ticks;
        drive->state     = DRIVE_IDLE;
        drop_references(drive);
    }
    else if (state == DRIVE_IDLE && (requests & REQUEST_START) != 0u)
    {
        loop_begin(&drive->loop, setup->params, drive->memory);
        begin_levels(drive, setup);
        drive->moved        = 0; // until now the power stage was off
        drive->has_intended = false;
        drive->port->enable(drive->port->context, true);
        drive->state = setup->bounds.ready_ticks > 0u ? DRIVE_STARTING : DRIVE_RUN;
    }
    return drive->state;
}

/// The power stage was off in the tick of the start, so its ready input counts from the next one on.
static drive_state_t wait_for_ready(drive_t *drive, const drive_setup_t *setup, bool begun, uint32_t inputs)
{
    if (begun && (inputs & PORT_INPUT_NOT_READY) == 0u)
    {
        drive->state            = DRIVE_RUN;
        drive->lasting.starting = 0;
    }
    else if (faults_starting(&setup->bounds, &drive->lasting))
    {
        stop_with(drive, DRIVE_FAULT_NOT_READY);
    }
    else
    {
        drive->limits = 0;
        drive->port->command(drive->port->context, setup->scaling.no_current);
    }
    return drive->state;
}

/// Data of one tick.
typedef struct
{
    const drive_setup_t *setup;
    uint32_t             start_us, requests, inputs;
    loop_force_t         reading;
} tick_t;

/// Does the work of a tick that has found no fault.
static void run_state(drive_t *drive, drive_state_t before, const tick_t *tick)
{
    drive_state_t state = before;
    if ((tick->requests & (REQUEST_START | REQUEST_STOP)) != 0u)
    {
        state = change_state(drive, tick->setup, before, tick->requests);
    }
    if (state == DRIVE_STARTING)
    {
        state = wait_for_ready(drive, tick->setup, before == DRIVE_STARTING, tick->inputs);
    }
    if (state == DRIVE_RUN)
    {
        run_loop(drive, tick->setup, tick->start_us);
    }
    if (state == DRIVE_IDLE)
    {
        drive->limits = 0;
        off(drive);
        take_tare(drive, (tick->requests & REQUEST_TARE) != 0u, tick->reading);
        return;
    }
    refuse_tare(drive, tick->requests);
}

void drive_attach(drive_t *drive, loop_memory_t *memory)
{
    drive->memory = memory;
}

#if DRIVE_FEEDFORWARD
static void change_compensation(drive_t *drive, uint32_t requests)
{
    if ((requests & REQUEST_RESTORE) != 0u)
    {
        TRIBO(guard, restore)(&drive->loop.guard);
    }
    drive->delayed |= requests & (REQUEST_RESTORE | REQUEST_FORGET);
    if (drive->delayed == 0u || drive->memory == NULL)
    {
        return;
    }
    if (loop_is_learning(drive->memory))
    {
        // Wait until the background has learned. Without a feed-forward it does not: drop what would act on later params.
        drive->delayed = drive->setup->params->method != NULL ? drive->delayed : 0u;
        return;
    }
    const bool is_off = drive->state != DRIVE_RUN && drive->state != DRIVE_STARTING;
    if ((drive->delayed & REQUEST_RESTORE) != 0u)
    {
        TRIBO(feedforward, restore)(&drive->memory->state);
    }
    if ((drive->delayed & REQUEST_FORGET) != 0u && is_off)
    {
        loop_forget(drive->setup->params, drive->memory);
    }
    drive->delayed = 0;
}
#endif

void drive_tick(drive_t *drive)
{
    const port_t  *port     = drive->port;
    const uint32_t start_us = port->time_us(port->context);
    const uint32_t requests = take_requests(drive);
    drive->ticks++;
    const drive_setup_t *setup = take_setup(drive);
#if DRIVE_FEEDFORWARD
    change_compensation(drive, requests);
#endif
    if (drive->changed && !is_for_good(drive->fault))
    {
        stop_with(drive, DRIVE_FAULT_CONFIG_CHANGED);
    }
    const drive_state_t state = drive->state;
    if (state == DRIVE_FAULT && is_for_good(drive->fault))
    {
        off(drive); // after a failed self-test, or without valid params, nothing else runs
        refuse_tare(drive, requests);
        return;
    }
    if (state != DRIVE_RUN)
    {
        expected_step(&setup->expected, &drive->expected, 0); // u has been 0 since the last tick
    }

    // Every check runs in every tick, so that the state of one does not depend on the result of another.
    const drive_fault_t reference = take_reference(drive, setup, state, (requests & REQUEST_RENEWED) != 0u);
    tick_t              tick      = {.setup = setup, .start_us = start_us, .requests = requests};
    tick.inputs                   = port->inputs(port->context);
    const drive_fault_t input     = check_inputs(setup, state, tick.inputs);
    const drive_fault_t timing    = check_time(drive, setup, start_us);
    const drive_fault_t sensor    = check_sensor(drive, setup, &tick.reading);
    const drive_fault_t measured  = check_measured(drive, setup, state);
    const drive_fault_t found     = first_of(first_of(input, measured), first_of(first_of(timing, sensor), reference));

    if (state == DRIVE_FAULT)
    {
        off(drive);
        refuse_tare(drive, requests);
        if ((requests & REQUEST_ACKNOWLEDGE) != 0u)
        {
            drop_references(drive);
        }
        if ((requests & REQUEST_ACKNOWLEDGE) != 0u && found == DRIVE_FAULT_NONE)
        {
            drive->state = DRIVE_IDLE;
            drive->fault = DRIVE_FAULT_NONE;
        }
        return;
    }
    if (found != DRIVE_FAULT_NONE)
    {
        stop_with(drive, found);
        refuse_tare(drive, requests);
        return;
    }
    run_state(drive, state, &tick);
}

// --- from the background -------------------------------------------------------------------------------------------

void drive_learn(drive_t *drive)
{
    if (!LOOP_LEARNS_IN_TICK)
    {
        loop_learn(drive->setup->params, drive->memory);
    }
}

void drive_reference(drive_t *drive, loop_force_t r)
{
    drive->reference  = r;
    drive->hosted     = true;
    drive->references = drive->references + 1u;
}

void drive_set_reference(drive_t *drive, loop_force_t r)
{
    drive->reference = r;
    drive->hosted    = false;
}

void drive_position_reference(drive_t *drive, int32_t position)
{
    drive->position_reference = position;
    atomic_thread_fence(memory_order_release);
    drive->has_position_reference = true;
}

void drive_condemn(drive_t *drive)
{
    drive->changed = true;
}

static void request(drive_t *drive, volatile uint32_t *count)
{
    *count = *count + 1u;
    atomic_thread_fence(memory_order_release); // the tick may be on another core
    drive->requests = drive->requests + 1u;
}

void drive_start(drive_t *drive)
{
    request(drive, &drive->starts);
}

void drive_stop(drive_t *drive)
{
    request(drive, &drive->stops);
}

void drive_acknowledge(drive_t *drive)
{
    request(drive, &drive->acknowledgements);
}

void drive_tare(drive_t *drive)
{
    request(drive, &drive->tares);
}

#if DRIVE_FEEDFORWARD
void drive_restore(drive_t *drive)
{
    request(drive, &drive->restores);
}

void drive_forget(drive_t *drive)
{
    request(drive, &drive->forgets);
}

uint32_t drive_warnings(const drive_t *drive)
{
    const tribo_guard_cause_t cause    = drive->loop.guard.cause;
    uint32_t                  warnings = 0;
    warnings |= cause == TRIBO_GUARD_HUNTING ? (uint32_t)DRIVE_WARNING_HUNTING : 0u;
    warnings |= cause == TRIBO_GUARD_OVERSHOOT ? (uint32_t)DRIVE_WARNING_OVERSHOOT : 0u;
    if (drive->memory != NULL)
    {
        const uint32_t turns = drive->memory->state.learner.at_bound;
        warnings |= turns >= TRIBO_FEEDFORWARD_BOUND_TURNS ? (uint32_t)DRIVE_WARNING_BOUND : 0u;
    }
    return warnings;
}
#endif

void drive_change(drive_t *drive, const drive_setup_t *setup)
{
    atomic_thread_fence(memory_order_release); // the tick may be on another core
    drive->next = setup;
}

const drive_setup_t *drive_setup(const drive_t *drive)
{
    return drive->setup;
}

float drive_sensor_zero_units(const drive_t *drive)
{
    return scaling_value(drive->sensor_zero, drive->port->sensor.full_units);
}

const char *drive_fault_text(drive_fault_t fault)
{
    static const char *const texts[] = {[DRIVE_FAULT_NONE]            = "none",
                                        [DRIVE_FAULT_IMAGE]           = "self-test: image",
                                        [DRIVE_FAULT_RAM]             = "self-test: RAM",
                                        [DRIVE_FAULT_GOLDEN]          = "self-test: golden vector",
                                        [DRIVE_FAULT_PARAMS]          = "params refused",
                                        [DRIVE_FAULT_CLOCK]           = "clock",
                                        [DRIVE_FAULT_STORE]           = "saved params damaged",
                                        [DRIVE_FAULT_WATCHDOG]        = "reset by the watchdog",
                                        [DRIVE_FAULT_EXCEPTION]       = "reset after an exception",
                                        [DRIVE_FAULT_CRYSTAL]         = "reset after the crystal stopped",
                                        [DRIVE_FAULT_BROWN_OUT]       = "reset by a low supply",
                                        [DRIVE_FAULT_RESTART]         = "reset by software",
                                        [DRIVE_FAULT_EMERGENCY_STOP]  = "emergency stop",
                                        [DRIVE_FAULT_SUPPLY]          = "supply",
                                        [DRIVE_FAULT_POWER]           = "power stage",
                                        [DRIVE_FAULT_NOT_READY]       = "power stage not ready",
                                        [DRIVE_FAULT_TICK_MISSED]     = "tick missed",
                                        [DRIVE_FAULT_TICK_LATE]       = "tick late",
                                        [DRIVE_FAULT_TICK_EARLY]      = "tick early",
                                        [DRIVE_FAULT_SENSOR_SILENT]   = "sensor silent",
                                        [DRIVE_FAULT_NAN]             = "not a number",
                                        [DRIVE_FAULT_SENSOR_RANGE]    = "sensor out of range",
                                        [DRIVE_FAULT_SENSOR_STUCK]    = "sensor stuck",
                                        [DRIVE_FAULT_REFERENCE]       = "reference not renewed",
                                        [DRIVE_FAULT_TICK_OVERRUN]    = "tick overrun",
                                        [DRIVE_FAULT_RESIDUAL]        = "sensor and model differ",
                                        [DRIVE_FAULT_COMMAND_LIMIT]   = "command at its limit",
                                        [DRIVE_FAULT_CONFIG_CHANGED]  = "params changed",
                                        [DRIVE_FAULT_OVER_CURRENT]    = "over-current",
                                        [DRIVE_FAULT_BUS_VOLTAGE]     = "bus voltage",
                                        [DRIVE_FAULT_TEMPERATURE]     = "temperature",
                                        [DRIVE_FAULT_BROWN_OUT_LEVEL] = "brown-out level",
                                        [DRIVE_FAULT_TRACKING]        = "force away from the reference",
                                        [DRIVE_FAULT_SPEED]           = "arm too fast",
                                        [DRIVE_FAULT_SWING]           = "loop swings to and fro"};
    return (unsigned)fault < DRIVE_FAULTS ? texts[fault] : "unknown";
}

#if DRIVE_FEEDFORWARD
const char *drive_warning_text(drive_warning_t warning)
{
    switch (warning)
    {
    case DRIVE_WARNING_HUNTING:
        return "friction faded: hunting";
    case DRIVE_WARNING_OVERSHOOT:
        return "friction faded: overshoot";
    case DRIVE_WARNING_BOUND:
        return "learned breakaway stays at its bound";
    default:
        return "unknown";
    }
}
#endif

void drive_report(drive_t *drive)
{
    static const char *const names[] =
        {[DRIVE_IDLE] = "idle", [DRIVE_RUN] = "run", [DRIVE_FAULT] = "fault: ", [DRIVE_STARTING] = "starting"};

    const port_t       *port  = drive->port;
    const drive_state_t state = drive->state;
    drive->logged_state       = state;
    log_text(port, names[state]);
    if (state == DRIVE_FAULT)
    {
        log_text(port, drive_fault_text(drive->fault));
        log_text(port, " since tick ");
        log_number(port, drive->fault_tick);
    }
    log_text(port, " at tick ");
    log_number(port, drive->ticks);
    log_text(port, ", longest tick ");
    log_number(port, drive->max_tick_us);
    log_text(port, " us, latest ");
    log_number(port, drive->max_late_us);
    log_text(port, " us\n");
}

void drive_report_off(const port_t *port, const drive_config_t *config)
{
    static const char *const names[DRIVE_CONFIG_COUNT] = {
#define NAME(type, name, unit, low, high, off, normal, change, text) (off) ? " " #name : NULL,
        DRIVE_CONFIG_FIELDS(NAME)
#undef NAME
    };
    log_text(port, "off:");
    for (unsigned i = 0; i < DRIVE_CONFIG_COUNT; i++)
    {
        if (names[i] != NULL && drive_config_value(config, i) == 0.0f)
        {
            log_text(port, names[i]);
        }
    }
    log_text(port, "\n");
}

#if DRIVE_FEEDFORWARD
static void log_warnings(drive_t *drive)
{
    const uint32_t now   = drive_warnings(drive);
    const uint32_t fresh = now & ~drive->logged_warnings;
    for (uint32_t bit = 1; bit <= fresh; bit <<= 1)
    {
        if ((fresh & bit) != 0u)
        {
            log_text(drive->port, "warning: ");
            log_text(drive->port, drive_warning_text((drive_warning_t)bit));
            log_text(drive->port, "\n");
        }
    }
    drive->logged_warnings = now;
}
#endif

void drive_log(drive_t *drive)
{
    if (drive->state != drive->logged_state)
    {
        drive_report(drive);
    }
#if DRIVE_FEEDFORWARD
    log_warnings(drive);
#endif
}
