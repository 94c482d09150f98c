/// Converts the drive's outputs to compare values of the RP2040's PWM, and the codes of its 12-bit converter to the
/// quantities other than the sensor's (port/converter.h). It uses no hardware registers, so that the host can test it.
///
///     output    -CONVERT_TOP to CONVERT_TOP: the share of a period in which the bridge pushes, forward or backward

#ifndef RP2040_CONVERT_H
#define RP2040_CONVERT_H

#include "port/converter.h"

#define CONVERT_TOP 6250 ///< cycles of a period: 20 kHz at 125 MHz

#define CONVERT_OUTPUT_RANGE {.full_units = 2 * CONVERT_TOP, .low_units = -CONVERT_TOP, .high_units = CONVERT_TOP}

// Scales of the bridge's current and supply. Change these with its amplifier and divider.
#define CONVERT_CURRENT_MA 16500 ///< current of the whole range: 0.2 V/A around 1.65 V
#define CONVERT_BUS_MV     66000 ///< supply of the whole range, divided by 20

static inline port_measured_t convert_measured(uint32_t current, uint32_t bus)
{
    return (port_measured_t){.current_ma = ((int32_t)current - CONVERT_CODES / 2) * CONVERT_CURRENT_MA / CONVERT_CODES,
                             .bus_mv     = (int32_t)bus * CONVERT_BUS_MV / CONVERT_CODES};
}

/// Returns both compare values of the slice, forward in the low half and backward in the high half; never both above 0.
static inline uint32_t convert_output(loop_force_t output)
{
#ifdef TRIBO_ARITHMETIC_Q31
    const int64_t scaled = (int64_t)output * (2 * CONVERT_TOP);
    const int32_t cycles = (int32_t)((scaled + (scaled >= 0 ? 1 << 30 : -(1 << 30))) / 2147483648);
#else
    const float   top     = (float)CONVERT_TOP;
    const float   limited = output > top ? top : output < -top ? -top : output == output ? output : 0.0f;
    const int32_t cycles  = (int32_t)(limited + (limited >= 0.0f ? 0.5f : -0.5f));
#endif
    const int32_t within = cycles > CONVERT_TOP ? CONVERT_TOP : cycles < -CONVERT_TOP ? -CONVERT_TOP : cycles;
    return within >= 0 ? (uint32_t)within : (uint32_t)-within << 16;
}

#endif
