/// The rig of this board, for the drive: the bounds of its faults, its sensor, motor and clock, and the ceilings.
/// app/config.h explains every field with its range. The forces of the loop itself are in rig.yaml.

#ifndef STM32F405_RIG_CONFIG_H
#define STM32F405_RIG_CONFIG_H

#include "app/params.h"
#include "port/ceilings.h"
#include "wiring.h"

#ifndef STAGE_BRIDGE // 1: the board is the bridge (stage.h)
#define STAGE_BRIDGE 0
#endif

// Weak, so that the compiler reads it from the image, where a test changes it.
__attribute__((weak)) const drive_config_t rig_config = {
    .period_us          = 1000,
    .late_us            = 50,
    .budget_us          = 250,
    .stuck_ticks        = 200,
    .residual_n         = 0.11f,
    .residual_ms        = 50,
    .command_limit_ms   = 500,
    .reference_ms       = 250,
    .ready_ms           = STAGE_BRIDGE ? 50 : 0, // the bridge calibrates; the other power stage has no such output
    .ready_level        = 1,
    .fault_level        = 1,
    .full_scale_n       = 4.0f,
    .sensor_n_per_unit  = 2.0f / 1638.4f, // 0.33 to 2.97 V are -2 to 2 N; a unit is a code of 12 bits
    .sensor_zero_units  = 2048.0f,
    .sensor_reversed    = 0,
    .tare_max_n         = 0.1f,
    .command_n_per_unit = STAGE_BRIDGE ? 1.0f : 2.0f / 2048.0f, // 1 N/A; 0 to 3.3 V are -2 to 2 N
    .command_zero_units = STAGE_BRIDGE ? 0.0f : 2048.0f,
    .command_reversed   = 0,
    .command_n_per_a    = 1.0f,
    .current_max_a      = 2.0f,
    .crystal_hz         = WIRING_OSCILLATOR_HZ,
    .degraded_clock     = 0,
    .bus_unit           = 1,
    // Without the bridge this rig has no sensors at these pins, so the levels are 0.
    .over_current_a          = STAGE_BRIDGE ? 2.5f : 0.0f,
    .bus_low_v               = STAGE_BRIDGE ? 18.0f : 0.0f,
    .bus_high_v              = STAGE_BRIDGE ? 30.0f : 0.0f,
    .temperature_max_c       = STAGE_BRIDGE ? 80.0f : 0.0f,
    .over_current_ms         = 5,
    .bus_voltage_ms          = 10,
    .temperature_ms          = 1000,
    .residual_slope          = 0.45f,
    .actuator_pole_rad_per_s = 200.0f,
    .sensor_pole_rad_per_s   = 55.0f,
    .tracking_n              = 0.3f,
    .tracking_ms             = 1000,
    .speed_ms                = 20, // speed_max_units_per_s is 0: this rig has no encoder
    .debounce_n              = 1,
    .debounce_m              = 1,
    .motor_resistance_ohm    = 2.0f, // only the bridge reads these
    .motor_inductance_h      = 1e-3f,
    .current_bandwidth_hz    = 1250.0f,
    .bridge_trip_a           = 3.0f,
    .dead_time_ns            = 500,
    .swing_ms                = 1000,
};

/// The widest ranges that this board allows, over the bus or from the store. A check whose range does not contain 0 cannot
/// be turned off. Change the ranges with the rig's motor, driver and sensor.
static const params_ceiling_t rig_ceilings[] = {
    PORT_RIG_CEILINGS
    // A newton must not become more at the motor, or much more at the sensor. No current stays no current to within 0.04 N.
    {DRIVE_CONFIG_command_n_per_unit, STAGE_BRIDGE ? 1.0f : 2.0f / 2048.0f, 1.0f},
    {DRIVE_CONFIG_command_zero_units, STAGE_BRIDGE ? -0.04f : 2007.0f, STAGE_BRIDGE ? 0.04f : 2089.0f},
#if STAGE_BRIDGE
    {DRIVE_CONFIG_ready_ms, 20.0f, 500.0f},
    {DRIVE_CONFIG_over_current_a, 1e-3f, 3.0f},
    {DRIVE_CONFIG_over_current_ms, 1.0f, 20.0f},
    {DRIVE_CONFIG_bus_voltage_ms, 1.0f, 100.0f},
    {DRIVE_CONFIG_temperature_ms, 1.0f, 5000.0f},
    {DRIVE_CONFIG_bus_low_v, 10.0f, 48.0f},
    {DRIVE_CONFIG_bus_high_v, 10.0f, 50.0f},
    {DRIVE_CONFIG_temperature_max_c, 1e-3f, 100.0f},
    {DRIVE_CONFIG_bridge_trip_a, 1e-3f, 4.0f},
    {DRIVE_CONFIG_dead_time_ns, 200.0f, 6000.0f},
#endif
};

#endif
