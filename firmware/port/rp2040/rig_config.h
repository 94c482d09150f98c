/// The rig of this board, for the drive, and its ceilings. app/config.h explains every field with its range. The loop's params
/// are the paper's until others come over the bus.

#ifndef RP2040_RIG_CONFIG_H
#define RP2040_RIG_CONFIG_H

#include "app/params.h"
#include "convert.h"
#include "port/ceilings.h"
#include "wiring.h"

static inline drive_config_t rig_config(void)
{
    drive_config_t config = drive_config_default();
#ifndef TRIBO_ARITHMETIC_Q31
    config.budget_us = 500; // floats are computed in software
#endif
    config.stuck_ticks        = 200;
    config.sensor_n_per_unit  = 2.0f / 1638.4f; // 0.33 to 2.97 V are -2 to 2 N; a unit is a code of 12 bits
    config.sensor_zero_units  = 2048.0f;
    config.tare_max_n         = 0.1f;
    config.command_n_per_unit = 2.0f / (float)CONVERT_TOP; // the whole period is 2 N
    config.current_max_a      = 2.0f;
    config.crystal_hz         = WIRING_OSCILLATOR_HZ;
    return config;
}

/// The widest ranges that this board allows to any client. A check whose range does not contain 0 cannot be turned off.
/// Change the ranges with the rig.
static const params_ceiling_t rig_ceilings[] = {
    PORT_RIG_CEILINGS
    // A newton must not become more at the motor, or much more at the sensor. No force stays no force to within 0.04 N.
    {DRIVE_CONFIG_command_n_per_unit, 2.0f / (float)CONVERT_TOP, 1.0f},
    {DRIVE_CONFIG_command_zero_units, -125.0f, 125.0f},
};

#endif
