#include "loop/tuned.h"

tribo_status_t common_tune(common_tuned_t *tuned, const common_rig_t *rig)
{
    const float h = rig->sample_time_s;

    tribo_feedforward_f32_params_t params;
    tribo_guard_f32_params_t       guard_params;
    common_tuned_t                 made      = {.feedforward = tribo_feedforward_f32_default()};
    made.feedforward.actuator_pole_rad_per_s = rig->actuator_pole_rad_per_s;
    made.feedforward.sensor_pole_rad_per_s   = rig->sensor_pole_rad_per_s;
    const tribo_status_t status              = tribo_feedforward_f32_init(&params,
                                                             &made.feedforward,
                                                             &rig->arm,
                                                             &rig->friction,
                                                             TRIBO_F32_FORCE_MAX_N,
                                                             rig->usual_force_n,
                                                             h);
    if (status != TRIBO_OK)
    {
        return status;
    }
    const float B   = params.learning.breakaway_n;
    const float tau = tribo_feedforward_f32_lag_s(&made.feedforward, &rig->arm);

    made.feedforward.reversal_n       = params.reversal;
    made.feedforward.presliding_n     = 1.0f / params.learning.per_n[TRIBO_FEEDFORWARD_WEIGHTS - 1u];
    made.feedforward.jump_time_s      = TRIBO_FEEDFORWARD_JUMP_TIME * tau;
    made.feedforward.forgetting_per_n = params.learning.forgetting_per_n;
    made.guard                        = tribo_guard_f32_tuned(B, tau, rig->noise_n, h);
    const tribo_status_t guarded      = tribo_guard_f32_init(&guard_params, &made.guard, h);
    if (guarded == TRIBO_OK)
    {
        *tuned = made;
    }
    return guarded;
}
