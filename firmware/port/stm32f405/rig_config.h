/// The rig of this board, for the drive: the bounds of its faults and what its sensor, its motor and its clock are. Every field
/// is explained with its range in app/config.h. The forces of the loop itself are in rig.yaml.

#ifndef STM32F405_RIG_CONFIG_H
#define STM32F405_RIG_CONFIG_H

#include "app/config.h"

static const drive_config_t rig_config = {
    .period_us          = 1000,
    .late_us            = 50,
    .budget_us          = 250,
    .stuck_ticks        = 200,
    .residual_n         = 0.2f,
    .residual_ms        = 50,
    .command_limit_ms   = 500,
    .reference_ms       = 0, // a person at the serial line types no reference 1,000 times a second
    .ready_ms           = 0, // this power stage has no such output
    .ready_level        = 1,
    .fault_level        = 1,
    .full_scale_n       = 4.0f,
    .sensor_n_per_unit  = 2.0f / 1638.4f, // 0.33 to 2.97 V are -2 to 2 N; a unit is a code of 12 bits
    .sensor_zero_units  = 2048.0f,
    .sensor_reversed    = 0,
    .tare_max_n         = 0.1f,
    .command_n_per_unit = 2.0f / 2048.0f, // 0 to 3.3 V are -2 to 2 N
    .command_zero_units = 2048.0f,
    .command_reversed   = 0,
    .command_n_per_a    = 1.0f,
    .current_max_a      = 2.0f,
    .crystal_hz         = 8000000,
    .degraded_clock     = 0,
    .bus_unit           = 1,
};

#endif
