/// Converts the units of a port's sensor to newtons, and newtons to the units of its output (config.h has the equations).
///
///     f32    a reading and an output are in units of the port, a force is in N
///     q31    a reading and an output are fractions of port_range_t.full_units, a force is a fraction of the full scale
///
/// With a unit of 1 N, a zero of 0 and full_units equal to the full scale, every force passes with all its bits.

#ifndef DRIVE_SCALING_H
#define DRIVE_SCALING_H

#include "app/config.h"
#include "app/loop.h"
#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef TRIBO_ARITHMETIC_Q31

#include "tribo/q31.h"

/// mantissa / 2^shift, shift 1 to 31
typedef struct
{
    int32_t  mantissa;
    uint32_t shift;
} scaling_gain_t;

typedef int64_t  scaling_sum_t;  ///< a sum of readings
typedef uint32_t scaling_rise_t; ///< the distance from a force to a larger one, up to twice the full scale

// These operations on forces and readings saturate.

static inline loop_force_t scaling_times(const scaling_gain_t *gain, loop_force_t x)
{
    uint32_t unused = 0;
    return tribo_q31_narrow(tribo_q31_multiply(x, gain->mantissa), gain->shift, &unused);
}

static inline loop_force_t scaling_sum(loop_force_t a, loop_force_t b)
{
    uint32_t unused = 0;
    return tribo_q31_add(a, b, &unused);
}

static inline loop_force_t scaling_difference(loop_force_t a, loop_force_t b)
{
    uint32_t unused = 0;
    return tribo_q31_subtract(a, b, &unused);
}

/// Returns |x|.
static inline scaling_sum_t scaling_size(scaling_sum_t x)
{
    return x < 0 ? -x : x;
}

static inline scaling_rise_t scaling_rise(loop_force_t from, loop_force_t to)
{
    return (uint32_t)to - (uint32_t)from;
}

#else

typedef float scaling_gain_t;
typedef float scaling_sum_t; ///< a sum of readings
typedef float scaling_rise_t;

static inline loop_force_t scaling_times(const scaling_gain_t *gain, loop_force_t x)
{
    return *gain * x;
}

static inline loop_force_t scaling_sum(loop_force_t a, loop_force_t b)
{
    return a + b;
}

static inline loop_force_t scaling_difference(loop_force_t a, loop_force_t b)
{
    return a - b;
}

static inline scaling_sum_t scaling_size(scaling_sum_t x)
{
#ifdef __GNUC__
    return __builtin_fabsf(x);
#else
    return x < 0.0f ? -x : x;
#endif
}

static inline scaling_rise_t scaling_rise(loop_force_t from, loop_force_t to)
{
    return to - from;
}

#endif

typedef struct
{
    scaling_gain_t sensor, command;
    loop_force_t   sensor_zero, command_zero; ///< as a reading and as an output
    loop_force_t   no_current;                ///< output at no current, valid for any config
} scaling_t;

/// Makes `scaling` for a port. Returns false and fills `error` if a field is out of range or not representable in the arithmetic;
/// no_current is valid even then.
bool scaling_init(scaling_t *scaling, const drive_config_t *config, const port_t *port, drive_config_error_t *error);

/// Returns the force of a reading; `zero` is the reading at 0 N.
static inline loop_force_t scaling_force(const scaling_t *scaling, loop_force_t zero, loop_force_t reading)
{
    return scaling_times(&scaling->sensor, scaling_difference(reading, zero));
}

/// Returns the output for a force.
static inline loop_force_t scaling_output(const scaling_t *scaling, loop_force_t u)
{
    return scaling_sum(scaling_times(&scaling->command, u), scaling->command_zero);
}

/// Converts a number in units or N to a reading, output or force, whose 2^31 is `full`, and back. Not for the tick.
loop_force_t scaling_number(float x, float full);
float        scaling_value(loop_force_t x, float full);

/// Returns a gain from 0 to 2^20 in the drive's arithmetic. Not for the tick.
scaling_gain_t scaling_gain(float x);

/// Returns true if the converters suit the loop: every u within its limits has an output, the current stays within its limit, and
/// the loop rejects the readings at both ends of the sensor's range. Otherwise it returns false, and `error` names the field to
/// change.
bool scaling_suits(const scaling_t      *scaling,
                   const drive_config_t *config,
                   const port_t         *port,
                   const loop_params_t  *params,
                   drive_config_error_t *error);

#endif
