#include "bridge/current.h"

#define TWO_PI 6.2831853f

static bool is_positive(float x)
{
    return x > 0.0f && x <= 1e9f;
}

float current_bandwidth_max_hz(float sample_time_s)
{
    return CURRENT_PHASE_MAX / (TWO_PI * sample_time_s);
}

bool current_init(current_params_t *params, const current_config_t *config)
{
    if (!is_positive(config->resistance_ohm) || !is_positive(config->inductance_h) ||
        !is_positive(config->bandwidth_hz) || !is_positive(config->sample_time_s) || !is_positive(config->limit_a) ||
        config->bandwidth_hz > current_bandwidth_max_hz(config->sample_time_s))
    {
        return false;
    }
    const float w = TWO_PI * config->bandwidth_hz;
    const float x = config->resistance_ohm * config->sample_time_s / config->inductance_h;
    if (x > CURRENT_POLE_MAX)
    {
        return false;
    }
    // Approximates x / (1 - exp(-x)) to 1 % up to x = 2.
    const float kp = w * config->inductance_h * (1.0f + x * (0.5f + x * (1.0f / 12.0f)));
    *params        = (current_params_t){.kp_v_per_a = kp,
                                        .kp_a_per_v = 1.0f / kp,
                                        .ki_v_per_a = w * config->resistance_ohm * config->sample_time_s,
                                        .limit_a    = config->limit_a};
    return true;
}

void current_reset(current_state_t *state)
{
    *state = (current_state_t){.integral_v = 0.0f};
}
