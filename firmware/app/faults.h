/// Faults of the rig that a single tick cannot reveal: each is a condition that lasts longer than its bound. A bound of 0
/// disables its fault.

#ifndef DRIVE_FAULTS_H
#define DRIVE_FAULTS_H

#include "app/config.h"
#include "app/loop.h"
#include "app/scaling.h"

#include <stdbool.h>
#include <stdint.h>

/// The bounds of drive_config_t as forces of the arithmetic and as ticks.
typedef struct
{
    loop_force_t   residual;       ///< at y = 0
    scaling_gain_t residual_slope; ///< what it grows by with |y|
    loop_force_t   tracking;
    loop_force_t   tare_max;                  ///< 0: off
    int32_t        travel;                    ///< in speed_ticks, in units of the position; 0: off
    uint32_t       debounce_n, debounce_mask; ///< so many of these bits
    uint32_t       residual_ticks, tracking_ticks, speed_ticks, command_limit_ticks, reference_ticks, ready_ticks;

    loop_force_t ramp;           ///< of r a tick without a host; 0: a fault
    loop_force_t safe_reference; ///< where it ends
    int32_t      over_current_ma, bus_low_mv, bus_high_mv, temperature_max_mc; ///< 0: off
    bool         is_measured;                                                  ///< one of these, or travel, is on
    uint32_t     over_current_ticks, bus_voltage_ticks, temperature_ticks;
} faults_bounds_t;

/// Ticks in a row. Zero at a start.
typedef struct
{
    uint32_t residual, tracking, command_limit, reference, starting;
    uint32_t speed; ///< ticks since the arm was at `position`; 0: it has not been looked at
    int32_t  position;
    uint32_t over_current, bus_voltage, temperature;
} faults_state_t;

void faults_init(faults_bounds_t *bounds, const drive_config_t *config);

/// Counts ticks in a row with a condition; true beyond `bound`.
static inline bool faults_last(uint32_t *ticks, bool condition, uint32_t bound)
{
    *ticks = condition ? *ticks + (*ticks != UINT32_MAX) : 0u;
    return bound > 0u && *ticks > bound;
}

/// |a - b| > bound, counted likewise.
static inline bool faults_apart(uint32_t    *ticks,
                                loop_force_t a,
                                loop_force_t b,
                                loop_force_t bound,
                                uint32_t     bound_ticks)
{
    return faults_last(ticks, scaling_size((scaling_sum_t)a - b) > bound, bound_ticks);
}

/// Takes over whether this tick's reading is bad into `history`, a bit a tick; true if it is, and enough of the last ones were.
static inline bool faults_readings(const faults_bounds_t *bounds, uint32_t *history, bool bad)
{
    *history       = *history << 1 | (bad ? 1u : 0u);
    uint32_t count = 0;
    for (uint32_t left = bad ? *history & bounds->debounce_mask : 0u; left != 0u; left &= left - 1u)
    {
        count++;
    }
    return bad && count >= bounds->debounce_n;
}

// Each of the following processes a tick and returns true once its bound is exceeded.

/// `expected` is the reading that u leads to (expected.h). A healthy sensor follows it within its friction and the model's error;
/// one that is detached, frozen, reversed or reads half does not, nor does a motor that is open or an arm that touches nothing.
static inline bool faults_residual(const faults_bounds_t *bounds,
                                   faults_state_t        *state,
                                   loop_force_t           y,
                                   loop_force_t           expected)
{
    const loop_force_t bound =
        scaling_sum(bounds->residual, scaling_times(&bounds->residual_slope, (loop_force_t)scaling_size(y)));
    return faults_apart(&state->residual, y, expected, bound, bounds->residual_ticks);
}

static inline bool faults_tracking(const faults_bounds_t *bounds, faults_state_t *state, loop_force_t r, loop_force_t y)
{
    return faults_apart(&state->tracking, r, y, bounds->tracking, bounds->tracking_ticks);
}

/// Travel since a position that is renewed every speed_ticks: a jump counts at once, a speed after two such times at most. A
/// position may wrap at 2^32.
static inline bool faults_speed(const faults_bounds_t *bounds, faults_state_t *state, int32_t position)
{
    if (state->speed == 0u)
    {
        state->position = position;
    }
    const int32_t travel = (int32_t)((uint32_t)position - (uint32_t)state->position);
    if (state->speed++ >= bounds->speed_ticks)
    {
        state->position = position;
        state->speed    = 1;
    }
    return bounds->travel > 0 && (travel > bounds->travel || travel < -bounds->travel);
}

static inline bool faults_command_limit(const faults_bounds_t *bounds, faults_state_t *state, bool limited)
{
    return faults_last(&state->command_limit, limited, bounds->command_limit_ticks);
}

static inline bool faults_reference(const faults_bounds_t *bounds, faults_state_t *state, bool renewed)
{
    return faults_last(&state->reference, !renewed, bounds->reference_ticks);
}

static inline bool faults_over_current(const faults_bounds_t *bounds, faults_state_t *state, int32_t current_ma)
{
    const int32_t most   = bounds->over_current_ma;
    const bool    beyond = most > 0 && (current_ma > most || current_ma < -most);
    return faults_last(&state->over_current, beyond, bounds->over_current_ticks);
}

static inline bool faults_bus_voltage(const faults_bounds_t *bounds, faults_state_t *state, int32_t bus_mv)
{
    const bool beyond = (bounds->bus_low_mv > 0 && bus_mv < bounds->bus_low_mv) ||
                        (bounds->bus_high_mv > 0 && bus_mv > bounds->bus_high_mv);
    return faults_last(&state->bus_voltage, beyond, bounds->bus_voltage_ticks);
}

static inline bool faults_temperature(const faults_bounds_t *bounds, faults_state_t *state, int32_t temperature_mc)
{
    const bool beyond = bounds->temperature_max_mc > 0 && temperature_mc > bounds->temperature_max_mc;
    return faults_last(&state->temperature, beyond, bounds->temperature_ticks);
}

/// While the power stage is on but not ready.
static inline bool faults_starting(const faults_bounds_t *bounds, faults_state_t *state)
{
    return faults_last(&state->starting, true, bounds->ready_ticks);
}

#endif
