#include "app/expected.h"

/// The step of a low pass in one tick, by backward Euler, which is stable for any pole.
static scaling_gain_t part_per_tick(float pole_rad_per_s, const drive_config_t *config)
{
    const float x = pole_rad_per_s * (1e-6f * (float)config->period_us);
    return scaling_gain(x / (1.0f + x));
}

void expected_init(expected_t *expected, const drive_config_t *config, const loop_params_t *params)
{
    *expected = (expected_t){.arm      = &params->compensator.arm,
                             .down     = -params->compensator.friction.TRIBO_N(gravity),
                             .actuator = part_per_tick(config->actuator_pole_rad_per_s, config),
                             .sensor   = part_per_tick(config->sensor_pole_rad_per_s, config)};
}

void expected_reset(expected_state_t *state)
{
    *state = (expected_state_t){.y = 0};
    TRIBO(arm, reset)(&state->arm);
}
