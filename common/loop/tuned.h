/// Computes the parameters of feed-forward and guard for a rig.

#ifndef COMMON_TUNED_H
#define COMMON_TUNED_H

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"

/// Data of a rig.
typedef struct
{
    float                       actuator_pole_rad_per_s, sensor_pole_rad_per_s;
    tribo_arm_f32_config_t      arm;
    tribo_friction_f32_params_t friction;      ///< the model's breakaway
    float                       usual_force_n; ///< |F| around which the rig works; breakaway there sets the widths
    float                       noise_n;       ///< standard deviation of y; 0 if unknown
    float                       sample_time_s;
} common_rig_t;

/// The parameters; those that the library would derive are given as numbers.
typedef struct
{
    tribo_feedforward_f32_config_t feedforward;
    tribo_guard_f32_config_t       guard;
} common_tuned_t;

/// Returns TRIBO_OK, or the status with which the library refuses the rig; `tuned` is not written then.
tribo_status_t common_tune(common_tuned_t *tuned, const common_rig_t *rig);

#endif
