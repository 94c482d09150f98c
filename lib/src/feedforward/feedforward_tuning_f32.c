#include "tribo/feedforward_f32.h"

#include "feedforward_f32.h"

static float larger_f32(float a, float b)
{
    return a > b ? a : b;
}

/// Square root of a number up to 1, by Newton's method from above.
static float root_f32(float x)
{
    float root = 1.0f;
    for (int i = 0; i < 40; i++)
    {
        root = 0.5f * (root + x / root);
    }
    return root;
}

/// B.
static float breakaway_of(const tribo_feedforward_f32_rig_t *rig)
{
    const float force = 0.25f * rig->input_max_n;
    return 0.5f * (feedforward_f32_prior(rig->friction, TRIBO_BREAKAWAY_POSITIVE, force) +
                   feedforward_f32_prior(rig->friction, TRIBO_BREAKAWAY_NEGATIVE, force));
}

/// tau.
static float lag_of(const tribo_feedforward_f32_rig_t *rig)
{
    return 1.0f / rig->actuator_pole_rad_per_s + rig->arm->damping / rig->arm->stiffness;
}

tribo_feedforward_f32_config_t tribo_feedforward_f32_tuned(const tribo_feedforward_f32_rig_t *rig)
{
    const float                    B     = breakaway_of(rig);
    const float                    lag   = lag_of(rig);
    const float                    h     = rig->sample_time_s;
    tribo_feedforward_f32_config_t tuned = tribo_feedforward_f32_default();

    tuned.actuator_pole_rad_per_s   = rig->actuator_pole_rad_per_s;
    tuned.sensor_pole_rad_per_s     = rig->sensor_pole_rad_per_s;
    tuned.reversal_n                = B / 314.0f;
    tuned.jump_time_s               = 1.6f * lag;
    tuned.noise_time_s              = larger_f32(0.25f, 100.0f * h);
    tuned.rate_time_s               = larger_f32(0.8f * lag, 2.0f * h);
    tuned.rate_max_n_per_s          = B / 0.0785f;
    tuned.slide_width_n             = larger_f32(B / 52.333f, 3.0f * rig->noise_n);
    tuned.slide_filter_time_s       = larger_f32(1.6f * lag, 10.0f * h);
    tuned.slide_rate_max_n_per_s    = B / 0.314f;
    tuned.slide_run_in_n            = tuned.slide_width_n * (5.0f / 3.0f);
    const float peak                = 6.0f * rig->noise_n * root_f32(h / (2.0f * tuned.slide_filter_time_s));
    tuned.slide_error_max_n         = larger_f32(B / 157.0f, peak);
    tuned.learning.offset_sd_n      = B / 15.7f;
    tuned.learning.weight_n         = B / 785.0f;
    tuned.learning.forgetting_per_n = 0.0157f / B;
    tuned.hold.margin_travel_n      = B / 1.57f;
    return tuned;
}

tribo_guard_f32_config_t tribo_guard_f32_tuned(const tribo_feedforward_f32_rig_t *rig)
{
    const float              B     = breakaway_of(rig);
    tribo_guard_f32_config_t tuned = tribo_guard_f32_default();

    tuned.turn_n       = B / 3.14f;
    tuned.stray_n      = larger_f32(B / 15.7f, 8.0f * rig->noise_n);
    tuned.quick_time_s = larger_f32(16.0f * lag_of(rig), 20.0f * rig->sample_time_s);
    return tuned;
}
