/// Conversion between codes of the 12-bit converters and forces. Without registers, so that the host can test it.

#ifndef STM32F405_CONVERT_H
#define STM32F405_CONVERT_H

#include "app/loop.h"

#include <stdbool.h>
#include <stdint.h>

#define CONVERT_FULL_SCALE_N 4.0f ///< of Q31
#define CONVERT_ZERO         2048 ///< code of 0 N and of no current
#define CONVERT_CODES_MAX    4095
#define CONVERT_READINGS_MAX 1024u  ///< their sum fits 22 bits, so shifted by 10 it fits 32
#define CONVERT_SENSOR_Q31   655360 ///< a code of the sensor in Q31: 2 N are 1638.4 codes, so both rails are beyond 2 N
#define CONVERT_COMMAND_Q31  (1 << 19) ///< a code of the command in Q31: 2 N are 2048 codes
#define CONVERT_RAIL         100u      ///< codes from either rail, 80 mV: a short or a broken wire reads within these

/// The mean of `count` readings of the sensor, 1 to CONVERT_READINGS_MAX, to 2^-10 of a code.
static inline loop_force_t convert_sensor(uint32_t sum, uint32_t count)
{
    const int32_t mean = (int32_t)(((sum << 10) / count) << 2) - (CONVERT_ZERO << 12);
    return loop_from_q31(mean * (CONVERT_SENSOR_Q31 >> 12), CONVERT_FULL_SCALE_N);
}

/// The code nearest to command `u`, limited to the range of the converter.
static inline uint32_t convert_command(loop_force_t u)
{
    const int32_t half = CONVERT_COMMAND_Q31 / 2;
    const int32_t q31  = loop_to_q31(u, CONVERT_FULL_SCALE_N);
    const int32_t code = CONVERT_ZERO + (q31 / half + (q31 < 0 ? -1 : 1)) / 2;
    return (uint32_t)(code < 0 ? 0 : code > CONVERT_CODES_MAX ? CONVERT_CODES_MAX : code);
}

/// Whether these converters suit a loop: they have a code for each u within its limits, and a reading at either rail is
/// beyond its input_max.
static inline bool convert_suits(const loop_params_t *params)
{
    const loop_force_t u_max = loop_from_q31(CONVERT_ZERO * CONVERT_COMMAND_Q31, CONVERT_FULL_SCALE_N);
    return loop_u_min(params) >= -u_max && loop_u_max(params) <= u_max &&
           !loop_is_credible(params, convert_sensor(CONVERT_RAIL, 1)) &&
           !loop_is_credible(params, convert_sensor(CONVERT_CODES_MAX - CONVERT_RAIL, 1));
}

#endif
