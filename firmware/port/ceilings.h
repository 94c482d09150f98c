/// The ceilings that the boards share, because they are of one rig: change them with its motor, driver or sensor.

#ifndef PORT_CEILINGS_H
#define PORT_CEILINGS_H

#include "app/params.h"

// clang-format off: one row a ceiling
#define PORT_RIG_CEILINGS                                                                                                              \
    {PARAMS_INPUT_MAX, 1e-6f, 2.0f},                                                                                                   \
    {PARAMS_U_MIN, -2.0f, 0.0f},                                                                                                       \
    {PARAMS_U_MAX, 0.0f, 2.0f},                                                                                                        \
    {DRIVE_CONFIG_late_us, 0.0f, 100.0f},                                                                                              \
    {DRIVE_CONFIG_budget_us, 1.0f, 500.0f},                                                                                            \
    {DRIVE_CONFIG_stuck_ticks, 1.0f, 1000.0f},                                                                                         \
    {DRIVE_CONFIG_residual_n, 1e-6f, 0.5f},                                                                                            \
    {DRIVE_CONFIG_residual_ms, 1.0f, 200.0f},                                                                                          \
    {DRIVE_CONFIG_residual_slope, 0.0f, 1.0f},                                                                                         \
    {DRIVE_CONFIG_tracking_n, 1e-6f, 1.0f},                                                                                            \
    {DRIVE_CONFIG_tracking_ms, 1.0f, 5000.0f},                                                                                         \
    {DRIVE_CONFIG_debounce_n, 1.0f, 3.0f},                                                                                             \
    {DRIVE_CONFIG_command_limit_ms, 1.0f, 5000.0f},                                                                                    \
    {DRIVE_CONFIG_swing_ms, 1.0f, 2000.0f},                                                                                            \
    {DRIVE_CONFIG_tare_max_n, 0.0f, 0.5f},                                                                                             \
    {DRIVE_CONFIG_current_max_a, 1e-6f, 2.0f},                                                                                         \
    {DRIVE_CONFIG_command_n_per_a, 1e-6f, 1.0f},                                                                                       \
    /* The residual's model: if it were slower than the rig, or had another weight, it would expect whatever a broken sensor shows. */ \
    {DRIVE_CONFIG_actuator_pole_rad_per_s, 100.0f, 1e6f},                                                                              \
    {DRIVE_CONFIG_sensor_pole_rad_per_s, 27.5f, 1e6f},                                                                                 \
    {PARAMS_INERTIA, 1e-12f, 2.4e-4f},                                                                                                 \
    {PARAMS_DAMPING, 0.0f, 0.0576f},                                                                                                   \
    {PARAMS_STIFFNESS, 1.92f, 1e12f},                                                                                                  \
    {PARAMS_GRAVITY, -0.1f, 0.1f},                                                                                                     \
    {DRIVE_CONFIG_sensor_n_per_unit, 0.8f * 2.0f / 1638.4f, 1.0f},                                                                     \
    {DRIVE_CONFIG_sensor_zero_units, 2048.0f - 410.0f, 2048.0f + 410.0f}, /* 0.5 N, for any number of saved tares */                   \
    {DRIVE_CONFIG_reference_ms, 1.0f, 5000.0f},                                                                                        \
    {DRIVE_CONFIG_reference_ramp_n_per_s, 0.0f, 0.0f}, /* a slow ramp without a host is as good as no fault */
// clang-format on

#endif
