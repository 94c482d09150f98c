// doors axis|joint: reads a row of inputs a tick, of the axis with its kp, and writes u as a hexadecimal float. By the library's own calls.

#include "tribo/axis_f32.h"
#include "tribo/joint_f32.h"

#include <stdio.h>
#include <string.h>

static void axis(void)
{
    static tribo_axis_f32_t own;
    tribo_axis_f32_config_t config             = tribo_axis_f32_config();
    config.sample_time_s                       = 1e-3f;
    config.u_min_n                             = -2.0f;
    config.u_max_n                             = 2.0f;
    config.positive                            = (tribo_breakaway_f32_t){.offset_n = 0.007f, .slope = 0.3f};
    config.feedforward.actuator_pole_rad_per_s = 200.0f;
    config.feedforward.sensor_pole_rad_per_s   = 55.0f;
    config.controller                          = tribo_pi(1.9f, 110.0f);
    (void)tribo_axis_f32_init(&own, &config);
    for (float r, y, kp; scanf("%f %f %f", &r, &y, &kp) == 3;)
    {
        if (kp != config.controller.kp)
        {
            static tribo_axis_f32_params_t params[8];
            static unsigned                count;
            config.controller = tribo_pi(kp, 110.0f);
            (void)tribo_axis_f32_prepare(&params[count % 8u], &config);
            (void)tribo_axis_f32_change(&own, &params[count++ % 8u]);
        }
        (void)printf("%a\n", (double)tribo_axis_f32_step(&own, r, y));
    }
}

static void joint(void)
{
    static tribo_joint_f32_t own;
    tribo_joint_config_t     config = tribo_joint_config();
    config.sample_time_s            = 1e-3f;
    config.effort_max               = 1.0f;
    config.travel                   = 4.0f / 8192.0f;
    (void)tribo_joint_f32_init(&own, &config);
    for (float effort, q_ref, q; scanf("%f %f %f", &effort, &q_ref, &q) == 3;)
    {
        (void)printf("%a\n", (double)tribo_joint_f32_step(&own, effort, q_ref, q));
    }
}

int main(int count, char **arguments)
{
    if (count == 2 && strcmp(arguments[1], "axis") == 0)
    {
        axis();
    }
    else
    {
        joint();
    }
    return 0;
}
