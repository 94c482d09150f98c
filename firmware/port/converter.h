/// Converts the codes of a 12-bit converter to readings of the drive, without hardware registers, so that the host can test
/// it. The drive's config scales codes to newtons.

#ifndef DRIVE_CONVERTER_H
#define DRIVE_CONVERTER_H

#include "app/loop.h"
#include "port/port.h"

#include <stdint.h>

#define CONVERT_CODES_MAX    4095
#define CONVERT_CODES        4096  ///< codes that are 2^31 in Q31
#define CONVERT_READINGS_MAX 1024u ///< most readings; their sum fits 22 bits, and 32 bits when shifted by 10
#define CONVERT_RAIL         100u  ///< codes, 80 mV: a short or a broken wire reads this close to a rail

#define CONVERT_SENSOR_RANGE                                                                                           \
    {.full_units = CONVERT_CODES, .low_units = CONVERT_RAIL, .high_units = CONVERT_CODES_MAX - CONVERT_RAIL}

/// Returns the mean of `count` readings of the sensor, 1 to CONVERT_READINGS_MAX, to 2^-10 of a code.
static inline loop_force_t convert_sensor(uint32_t sum, uint32_t count)
{
    const uint32_t mean = (sum << 10) / count;
#ifdef TRIBO_ARITHMETIC_Q31
    return (int32_t)(mean << 9);
#else
    return (float)mean * (1.0f / 1024.0f);
#endif
}

#endif
