/// Faults of the rig that a single tick cannot reveal: each is a condition that lasts longer than its bound. A bound of 0
/// disables its fault.

#ifndef DRIVE_FAULTS_H
#define DRIVE_FAULTS_H

#include "app/config.h"
#include "app/loop.h"

#include <stdbool.h>
#include <stdint.h>

/// The bounds of drive_config_t as forces of the arithmetic and as ticks.
typedef struct
{
    loop_force_t residual; ///< 0: off
    loop_force_t tare_max; ///< 0: off
    uint32_t     residual_ticks, command_limit_ticks, reference_ticks, ready_ticks;

    loop_force_t ramp;           ///< of r a tick without a host; 0: a fault
    loop_force_t safe_reference; ///< where it ends
    int32_t      over_current_ma, bus_low_mv, bus_high_mv, temperature_max_mc; ///< 0: off
    uint32_t     over_current_ticks, bus_voltage_ticks, temperature_ticks;
} faults_bounds_t;

/// Ticks in a row. Zero at a start.
typedef struct
{
    uint32_t residual, command_limit, reference, starting;
    uint32_t over_current, bus_voltage, temperature;
} faults_state_t;

void faults_init(faults_bounds_t *bounds, const drive_config_t *config);

/// Counts ticks in a row with a condition; true beyond `bound`.
static inline bool faults_last(uint32_t *ticks, bool condition, uint32_t bound)
{
    *ticks = condition ? *ticks + (*ticks != UINT32_MAX) : 0u;
    return bound > 0u && *ticks > bound;
}

static inline bool faults_is_beyond(loop_force_t y, loop_force_t f_hat, loop_force_t bound)
{
#ifdef TRIBO_ARITHMETIC_Q31
    const int64_t difference = (int64_t)y - f_hat;
#else
    const float difference = y - f_hat;
#endif
    return difference > bound || difference < -bound;
}

// Each of the following processes a tick and returns true once its bound is exceeded.

/// y and F^ of the same tick. F^ is the force of the commanded arm. A healthy sensor follows it within its own lag and the
/// model's error; a detached, frozen or reversed sensor, or one that reads half, does not.
static inline bool faults_residual(const faults_bounds_t *bounds,
                                   faults_state_t        *state,
                                   loop_force_t           y,
                                   loop_force_t           f_hat)
{
    const bool beyond = bounds->residual > 0 && faults_is_beyond(y, f_hat, bounds->residual);
    return faults_last(&state->residual, beyond, bounds->residual_ticks);
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
