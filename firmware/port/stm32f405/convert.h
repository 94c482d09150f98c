/// Converts outputs, and measured quantities other than the sensor's (port/converter.h), for the STM32F405's 12-bit
/// converters. It uses no hardware registers, so that the host can test it.

#ifndef STM32F405_CONVERT_H
#define STM32F405_CONVERT_H

#include "port/converter.h"

#define CONVERT_ZERO 2048u ///< half of the supply: no current, before the config is known

/// An output of 4096 becomes 4095, so a range of u that ends at the supply is one code short.
#define CONVERT_OUTPUT_RANGE {.full_units = CONVERT_CODES, .low_units = 0, .high_units = CONVERT_CODES}

// The bridge's output is a current in amperes.
#define CONVERT_BRIDGE_FULL_A 8.25f
#define CONVERT_BRIDGE_RANGE                                                                                           \
    {.full_units = CONVERT_BRIDGE_FULL_A, .low_units = -CONVERT_BRIDGE_FULL_A, .high_units = CONVERT_BRIDGE_FULL_A}

// Scales of the power stage's measurements. Change these with its amplifiers and dividers.
#define CONVERT_MEASURED       3u     ///< quantities: current, supply, temperature
#define CONVERT_CURRENT_MA     16500  ///< current of the whole range: 0.2 V/A around 1.65 V
#define CONVERT_BUS_MV         66000  ///< supply of the whole range, divided by 20
#define CONVERT_TEMPERATURE_MC 330000 ///< temperature of the whole range: 10 mV/degC from 0 degC

static inline port_measured_t convert_measured(const uint32_t codes[CONVERT_MEASURED])
{
    return (port_measured_t){.current_ma =
                                 ((int32_t)codes[0] - (int32_t)CONVERT_ZERO) * CONVERT_CURRENT_MA / CONVERT_CODES,
                             .bus_mv         = (int32_t)codes[1] * CONVERT_BUS_MV / CONVERT_CODES,
                             .temperature_mc = (int32_t)codes[2] * CONVERT_TEMPERATURE_MC / CONVERT_CODES};
}

/// Converts a code to the bridge's current in A.
static inline float convert_bridge(loop_force_t output)
{
#ifdef TRIBO_ARITHMETIC_Q31
    return (float)output * (CONVERT_BRIDGE_FULL_A / 2147483648.0f);
#else
    return output;
#endif
}

/// Returns TIM1's bits DTG for a dead time, rounded up; at most 1008 cycles.
static inline uint32_t convert_dead_time(uint32_t ns, uint32_t timer_hz)
{
    static const struct
    {
        uint32_t most, step, first, code;
    } ranges[] = {{127u, 1u, 0u, 0x00u}, {254u, 2u, 64u, 0x80u}, {504u, 8u, 32u, 0xc0u}, {1008u, 16u, 32u, 0xe0u}};
    const uint32_t cycles = (ns * (timer_hz / 1000000u) + 999u) / 1000u;
    for (uint32_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++)
    {
        if (cycles <= ranges[i].most)
        {
            const uint32_t steps = (cycles + ranges[i].step - 1u) / ranges[i].step;
            return ranges[i].code | ((steps > ranges[i].first ? steps : ranges[i].first) - ranges[i].first);
        }
    }
    return 0xffu;
}

/// Returns the code nearest to an output, within the range of the converter.
static inline uint32_t convert_output(loop_force_t output)
{
#ifdef TRIBO_ARITHMETIC_Q31
    const int32_t  limited = output < 0 ? 0 : output;
    const uint32_t code    = ((uint32_t)limited + (1u << 18)) >> 19;
#else
    const float    limited = output > 0.0f ? (output < 4095.0f ? output : 4095.0f) : 0.0f; // 0 for a NaN
    const uint32_t code    = (uint32_t)(limited + 0.5f);
#endif
    return code > CONVERT_CODES_MAX ? CONVERT_CODES_MAX : code;
}

#endif
