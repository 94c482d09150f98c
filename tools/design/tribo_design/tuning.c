// Prints what the library's rule makes of a rig, for tuning.py: its defaults are tuned nowhere else.
//   in   offset, slope, negative offset and slope, I, b, K, actuator pole, sensor pole, input_max, noise, sample time
//   out  "error TEXT", or one "key value" a line

#include "tribo/feedforward_f32.h"

#include <stdio.h>

#define PRINT(from, name, field) (void)printf("%s%s %.6g\n", from, name, (double)(field))

int main(void)
{
    tribo_compensator_f32_config_t model = tribo_force_loop_f32_paper().compensator;
    tribo_breakaway_f32_t         *up    = &model.friction.positive;
    tribo_breakaway_f32_t         *down  = &model.friction.negative;
    tribo_compensator_f32_params_t made;
    tribo_feedforward_f32_rig_t    rig = {.arm = &model.arm, .friction = &made.friction};
    tribo_feedforward_f32_params_t params;
    tribo_guard_f32_params_t       guard_params;

    if (scanf("%f %f %f %f", &up->offset_n, &up->slope, &down->offset_n, &down->slope) != 4 ||
        scanf("%f %f %f", &model.arm.inertia, &model.arm.damping, &model.arm.stiffness) != 3 ||
        scanf("%f %f %f", &rig.actuator_pole_rad_per_s, &rig.sensor_pole_rad_per_s, &rig.input_max_n) != 3 ||
        scanf("%f %f", &rig.noise_n, &rig.sample_time_s) != 2)
    {
        return 2;
    }
    model.friction.pulse_width_s = 3.0f * rig.sample_time_s; // of no matter here
    tribo_status_t status        = tribo_compensator_f32_init(&made, &model, rig.sample_time_s);
    if (status != TRIBO_OK)
    {
        (void)printf("error %s\n", tribo_status_text(status));
        return 0;
    }
    const tribo_feedforward_f32_config_t tuned = tribo_feedforward_f32_tuned(&rig);
    const tribo_guard_f32_config_t       guard = tribo_guard_f32_tuned(&rig);
    status =
        tribo_feedforward_f32_init(&params, &tuned, &model.arm, &made.friction, rig.input_max_n, rig.sample_time_s);
    if (status == TRIBO_OK)
    {
        status = tribo_guard_f32_init(&guard_params, &guard, rig.sample_time_s);
    }
    if (status != TRIBO_OK)
    {
        (void)printf("error %s\n", tribo_status_text(status));
        return 0;
    }
    PRINT("feedforward.", "actuator_pole_rad_per_s", tuned.actuator_pole_rad_per_s);
    PRINT("feedforward.", "sensor_pole_rad_per_s", tuned.sensor_pole_rad_per_s);
    PRINT("feedforward.", "reversal_N", tuned.reversal_n);
    PRINT("feedforward.", "presliding_N", tuned.presliding_n);
    PRINT("feedforward.", "jump_time_s", tuned.jump_time_s);
    PRINT("feedforward.", "forgetting_per_N", tuned.forgetting_per_n);
    PRINT("guard.", "turn_N", guard.turn_n);
    PRINT("guard.", "quick_time_s", guard.quick_time_s);
    PRINT("guard.", "stray_N", guard.stray_n);
    PRINT("guard.", "fade_time_s", guard.fade_time_s);
    return 0;
}
