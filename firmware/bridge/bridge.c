#include "bridge/bridge.h"

#include <stddef.h>

static const bridge_duty_t idle = {{0.5f, 0.5f, 0.5f}};

void bridge_init(bridge_t *bridge, const bridge_params_t *params)
{
    const float middle = (float)BRIDGE_MIDDLE;
    *bridge            = (bridge_t){.params = *params, .zero = {middle, middle}};
}

static void trip(bridge_t *bridge, bridge_trip_t cause)
{
    bridge->cause     = cause;
    bridge->trips     = (uint8_t)(bridge->trips + 1u);
    bridge->must_rest = true;
    bridge->state     = BRIDGE_OFF;
}

/// Updates a level: a sample with the condition raises it by BRIDGE_RISE, a sample without lowers it by 1.
static bool lasts(uint32_t *level, bool condition)
{
    const uint32_t most = BRIDGE_SAMPLES * BRIDGE_RISE;
    const uint32_t was  = *level;
    *level              = !condition ? was - (was > 0u) : was + BRIDGE_RISE < most ? was + BRIDGE_RISE : most;
    return *level >= most;
}

static void begin_calibration(bridge_t *bridge)
{
    bridge->count = 0;
    for (size_t i = 0; i < BRIDGE_CURRENTS; i++)
    {
        bridge->sum[i]  = 0;
        bridge->low[i]  = BRIDGE_CODES;
        bridge->high[i] = 0;
    }
    bridge->state = BRIDGE_CALIBRATING;
}

static bool is_zero_credible(const bridge_t *bridge)
{
    bool is = true;
    for (size_t i = 0; i < bridge->params.currents; i++)
    {
        const float off = bridge->zero[i] - (float)BRIDGE_MIDDLE;
        is              = is && off <= (float)BRIDGE_OFFSET_MOST && off >= -(float)BRIDGE_OFFSET_MOST &&
             bridge->high[i] - bridge->low[i] <= BRIDGE_SPREAD_MOST;
    }
    return is;
}

static void turn_on(bridge_t *bridge)
{
    bridge->age      = 0; // the tick's commands have not counted until now
    bridge->beyond   = 0;
    bridge->high_bus = 0;
    if (bridge->params.begin != NULL)
    {
        bridge->params.begin(bridge->params.context);
    }
    bridge->state = BRIDGE_ON;
}

static void calibrate(bridge_t *bridge, const bridge_sample_t *sample)
{
    for (size_t i = 0; i < BRIDGE_CURRENTS; i++)
    {
        const uint32_t code = sample->current[i];
        bridge->sum[i] += code;
        bridge->low[i]  = code < bridge->low[i] ? code : bridge->low[i];
        bridge->high[i] = code > bridge->high[i] ? code : bridge->high[i];
    }
    if (++bridge->count < BRIDGE_OFFSET_SAMPLES)
    {
        return;
    }
    for (size_t i = 0; i < BRIDGE_CURRENTS; i++)
    {
        bridge->zero[i] = (float)bridge->sum[i] * (1.0f / (float)BRIDGE_OFFSET_SAMPLES);
    }
    if (is_zero_credible(bridge))
    {
        turn_on(bridge);
    }
    else
    {
        trip(bridge, BRIDGE_TRIP_OFFSET);
    }
}

static void measure(bridge_t *bridge, const bridge_sample_t *sample)
{
    for (size_t i = 0; i < BRIDGE_CURRENTS; i++)
    {
        bridge->measured.current_a[i] =
            ((float)(int32_t)sample->current[i] - bridge->zero[i]) * bridge->params.a_per_code;
    }
    bridge->measured.bus_v = (float)(int32_t)sample->bus * bridge->params.v_per_code;
}

static bool is_beyond(float current_a, float most_a)
{
    return current_a > most_a || current_a < -most_a;
}

/// Returns true if the current of any phase is beyond trip_a. That of the third is minus the sum of the others, so its sign
/// does not matter.
static bool has_over_current(const bridge_t *bridge)
{
    const float *i_a  = bridge->measured.current_a;
    const float  most = bridge->params.trip_a;
    return is_beyond(i_a[0], most) ||
           (bridge->params.currents > 1u && (is_beyond(i_a[1], most) || is_beyond(i_a[0] + i_a[1], most)));
}

static bool is_at_rail(uint32_t code)
{
    return code < BRIDGE_RAIL || code > BRIDGE_CODES - 1u - BRIDGE_RAIL;
}

/// Runs the law, in ON.
static void check(bridge_t *bridge, bool are_on)
{
    bridge->age = bridge->age + 1u;
    if (!are_on)
    {
        trip(bridge, BRIDGE_TRIP_BREAK);
    }
    else if (lasts(&bridge->beyond, has_over_current(bridge)))
    {
        trip(bridge, BRIDGE_TRIP_CURRENT);
    }
    else if (lasts(&bridge->high_bus, bridge->measured.bus_v > bridge->params.trip_v))
    {
        trip(bridge, BRIDGE_TRIP_BUS);
    }
    else if (bridge->age > BRIDGE_STALE_SAMPLES)
    {
        trip(bridge, BRIDGE_TRIP_STALE);
    }
}

bool bridge_step(bridge_t *bridge, const bridge_sample_t *sample, bool are_on, bridge_duty_t *duty)
{
    const bool was_on = bridge->state == BRIDGE_ON;
    const bool at_rail =
        is_at_rail(sample->current[0]) || (bridge->params.currents > 1u && is_at_rail(sample->current[1]));
    measure(bridge, sample);
    *duty = idle;
    if (lasts(&bridge->rails, at_rail))
    {
        trip(bridge, BRIDGE_TRIP_SENSOR);
    }
    else if (!bridge->is_wanted)
    {
        bridge->state     = BRIDGE_OFF;
        bridge->must_rest = false;
    }
    else if (bridge->state == BRIDGE_ON)
    {
        check(bridge, are_on);
    }
    else if (bridge->state == BRIDGE_CALIBRATING)
    {
        calibrate(bridge, sample);
    }
    else if (!bridge->must_rest)
    {
        begin_calibration(bridge);
    }
    const bool is_on = bridge->state == BRIDGE_ON;
    if (is_on && was_on) // the sample that ended the calibration was measured before ON
    {
        bridge->params.law(bridge->params.context, bridge->reference_a, &bridge->measured, duty);
    }
    return is_on;
}

// --- functions of the tick -----------------------------------------------------------------------------------------

void bridge_want(bridge_t *bridge, bool on)
{
    bridge->is_wanted = on;
}

void bridge_command(bridge_t *bridge, float reference_a)
{
    bridge->reference_a = reference_a;
    bridge->age         = 0;
}

bridge_trip_t bridge_take_trip(bridge_t *bridge)
{
    const uint8_t trips  = bridge->trips;
    const bool    is_new = trips != bridge->trips_seen;
    bridge->trips_seen   = trips;
    return is_new ? bridge->cause : BRIDGE_TRIP_NONE;
}

// --- a motor with one winding --------------------------------------------------------------------------------------

void bridge_brushed_begin(void *context)
{
    bridge_brushed_t *motor = context;
    current_reset(&motor->state);
}

float bridge_dead_share(uint32_t dead_time_ns)
{
    return 1e-9f * (float)dead_time_ns * (float)BRIDGE_HZ;
}

/// While a leg is in dead time its diode conducts, so each leg once a period takes this share of the bus voltage away from
/// the motor in the current's direction. The share is added beforehand, by the sign of the reference, because the sign of
/// the current is known too late when it turns.
static float dead_part(const bridge_brushed_t *motor, float reference_a)
{
    return 2.0f * motor->dead_share * current_limited(reference_a * (1.0f / BRIDGE_SIGN_A), 1.0f);
}

/// Both legs move, in opposite directions from the middle: the motor sees twice the timer's frequency, and the current at the
/// middle of a period is its mean.
void bridge_brushed(void *context, float reference_a, const bridge_measured_t *measured, bridge_duty_t *duty)
{
    bridge_brushed_t *motor  = context;
    const bool        has    = measured->bus_v >= BRIDGE_BUS_LEAST_V;
    const float       most_v = has ? BRIDGE_DUTY_MOST * measured->bus_v : 0.0f;
    const float       v      = current_step(&motor->params, &motor->state, reference_a, measured->current_a[0], most_v);
    const float       part   = has ? v / measured->bus_v + dead_part(motor, reference_a) : 0.0f;
    const float       half   = 0.5f * part;
    duty->leg[0]             = 0.5f + half;
    duty->leg[1]             = 0.5f - half;
}
