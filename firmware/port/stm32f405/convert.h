/// Between codes of the 12-bit converters and forces. No registers, so that the host can test it.

#ifndef STM32F405_CONVERT_H
#define STM32F405_CONVERT_H

#include "app/loop.h"

#include <stdbool.h>
#include <stdint.h>

#define CONVERT_FULL_SCALE_N 4.0f ///< of Q31
#define CONVERT_ZERO         2048 ///< code of 0 N and of no current
#define CONVERT_CODES_MAX    4095
#define CONVERT_READINGS_MAX 1024u     ///< whose sum fits
#define CONVERT_SENSOR_PART  655360    ///< of full scale a code: 2 N are 1638.4 codes, so that both ends are beyond 2 N
#define CONVERT_COMMAND_PART (1 << 19) ///< of full scale a code: 2 N are 2048 codes
#define CONVERT_RAIL         100u      ///< codes from an end, 80 mV: what a short or a broken wire may give

/// The mean of `count` readings of the sensor, 1 to CONVERT_READINGS_MAX, to 2^-10 of a code.
static inline loop_force_t convert_sensor(uint32_t sum, uint32_t count)
{
    const int32_t mean = (int32_t)(((sum << 10) / count) << 2) - (CONVERT_ZERO << 12);
    return loop_force(mean * (CONVERT_SENSOR_PART >> 12), CONVERT_FULL_SCALE_N);
}

/// The nearest code of command `u`, within the converter's range.
static inline uint32_t convert_command(loop_force_t u)
{
    const int32_t half = CONVERT_COMMAND_PART / 2;
    const int32_t part = loop_part(u, CONVERT_FULL_SCALE_N);
    const int32_t code = CONVERT_ZERO + (part / half + (part < 0 ? -1 : 1)) / 2;
    return (uint32_t)(code < 0 ? 0 : code > CONVERT_CODES_MAX ? CONVERT_CODES_MAX : code);
}

/// Whether a loop can be run with these converters: its u has codes, and readings at either end are out of its range.
static inline bool convert_serves(const loop_params_t *params)
{
    const loop_force_t most = loop_force(CONVERT_ZERO * CONVERT_COMMAND_PART, CONVERT_FULL_SCALE_N);
    return loop_u_min(params) >= -most && loop_u_max(params) <= most &&
           !loop_is_credible(params, convert_sensor(CONVERT_RAIL, 1)) &&
           !loop_is_credible(params, convert_sensor(CONVERT_CODES_MAX - CONVERT_RAIL, 1));
}

#endif
