#include "foreign_loop.h"

#include "../support/init_parts.h"
#include "loop/tuned.h"

#include "tribo/paper_controller.h"

#include <math.h>
#include <string.h>

const foreign_rig_t foreign_rigs[FOREIGN_RIGS] = {
    {"paper, 1 kHz", 1e-3, 200.0, 55.0, 1.2e-4, 0.0288, 3.84, 0.007, 0.3, 0.5, 0.1, true},
    {"2 kg axis, 100 N, 2 kHz", 5e-4, 700.0, 300.0, 2.0, 2800.0, 2e6, 2.0, 0.15, 60.0, 25.0, false},
    {"slow drive, 500 Hz", 2e-3, 60.0, 25.0, 0.02, 1.4, 30.0, 0.05, 0.1, 1.5, 0.4, false},
    {"gripper, 20 mN, 4 kHz", 2.5e-4, 1500.0, 500.0, 1e-6, 0.0014, 1.0, 5e-4, 0.2, 0.02, 6e-3, false},
    {"hub in Nm, 5 kHz, both signs", 2e-4, 900.0, 400.0, 3e-3, 2.3, 900.0, 3.0, 0.05, 0.0, 20.0, false},
};

/// (1 + s/zero) crossover/s or (1 + s/zero), over 1 + s/pole, by Tustin's rule in the delta operator.
static tribo_biquad_f32_section_t section(double h, double zero, double pole, double crossover)
{
    const double a = 2.0 / (h * zero);
    const double c = 2.0 / (h * pole);
    const double z = (c - 1.0) / (c + 1.0);
    if (crossover > 0.0)
    {
        const double gain = crossover * h / 2.0 / (1.0 + c);
        const double b0   = gain * (1.0 + a);
        const double b1   = gain * 2.0;
        const double b2   = gain * (1.0 - a);
        return (tribo_biquad_f32_section_t){.b0 = (float)b0,
                                            .b1 = (float)(2.0 * b0 + b1),
                                            .b2 = (float)(b0 + b1 + b2),
                                            .a1 = (float)(1.0 - z),
                                            .a2 = 0.0f}; // the integrator
    }
    const double gain = (1.0 + a) / (1.0 + c);
    const double from = (a - 1.0) / (a + 1.0);
    return (tribo_biquad_f32_section_t){.b0 = (float)gain,
                                        .b1 = (float)(gain * (2.0 - from)),
                                        .b2 = (float)(gain * (1.0 - from)),
                                        .a1 = (float)(2.0 - z),
                                        .a2 = (float)(1.0 - z)};
}

static tribo_force_loop_f32_config_t config_of(const foreign_rig_t        *rig,
                                               tribo_biquad_f32_section_t *sections,
                                               double                      full_scale_n)
{
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    const double                  fast   = fmin(10.0 * rig->sensor_pole, 1.0 / rig->sample_time_s);
    sections[0]                          = section(rig->sample_time_s, rig->stiffness / rig->damping, fast, 0.0);
    sections[1]                          = section(rig->sample_time_s, rig->sensor_pole, fast, 0.4 * rig->sensor_pole);
    if (!rig->paper_controller)
    {
        config.controller.sections      = sections;
        config.controller.section_count = 2u;
    }
    const tribo_breakaway_f32_t breakaway  = {.offset_n = (float)rig->offset, .slope = (float)rig->slope};
    config.sample_time_s                   = (float)rig->sample_time_s;
    config.input_max_n                     = (float)(0.5 * full_scale_n);
    config.usual_force_n                   = 0.25f * config.input_max_n;
    config.controller.u_min_n              = (float)(-0.5 * full_scale_n);
    config.controller.u_max_n              = (float)(0.5 * full_scale_n);
    config.compensator.arm.inertia         = (float)rig->inertia;
    config.compensator.arm.damping         = (float)rig->damping;
    config.compensator.arm.stiffness       = (float)rig->stiffness;
    config.compensator.friction.positive   = breakaway;
    config.compensator.friction.negative   = breakaway;
    config.compensator.friction.v0_n_per_s = (float)(0.007 * (rig->offset + rig->slope * rig->mean) / 0.157);
    return config;
}

tribo_status_t foreign_loop_open(foreign_loop_t *loop, const foreign_rig_t *rig, foreign_method_t method, double noise)
{
    tribo_biquad_f32_section_t sections[2];
    memset(loop, 0, sizeof *loop);
    loop->full_scale_n                   = 8.0 * (rig->mean + rig->amplitude);
    const float                   scale  = (float)loop->full_scale_n;
    tribo_force_loop_f32_config_t config = config_of(rig, sections, loop->full_scale_n);
    config.gain                          = 0.0f;
    tribo_status_t status                = TRIBO_OK;
    if (method != FOREIGN_FEEDFORWARD)
    {
        status = tribo_init_loop(&loop->params, NULL, &config, scale);
        return status == TRIBO_OK ? TRIBO(force_loop, start)(&loop->state.state, &loop->params, false) : status;
    }
    common_rig_t   believed = {.actuator_pole_rad_per_s = (float)rig->actuator_pole,
                               .sensor_pole_rad_per_s   = (float)rig->sensor_pole,
                               .arm                     = config.compensator.arm,
                               .usual_force_n           = tribo_force_loop_f32_usual_force_n(&config),
                               .noise_n                 = (float)noise,
                               .sample_time_s           = config.sample_time_s};
    common_tuned_t tuned;
    status = tribo_friction_f32_init(&believed.friction, &config.compensator.friction, config.sample_time_s);
    if (status == TRIBO_OK)
    {
        status = common_tune(&tuned, &believed);
    }
    if (status == TRIBO_OK)
    {
        config.guard = TRIBO(guard, use)(&loop->guard, &tuned.guard);
        status = tribo_init_feedforward(&loop->params, NULL, &loop->feedforward, &config, &tuned.feedforward, scale);
    }
    loop->state.state.memory = &loop->state.memory.state.tick;
    return status == TRIBO_OK ? TRIBO(force_loop, start)(&loop->state.state, &loop->params, false) : status;
}

double foreign_loop_step(foreign_loop_t *loop, double r, double y)
{
    const tribo_force_t reference = tribo_force_of_n(r, loop->full_scale_n);
    const tribo_force_t reading   = tribo_force_of_n(y, loop->full_scale_n);
    const tribo_force_t u = TRIBO(force_loop, step)(&loop->params, &loop->state.state, reference, reading, NULL);
    (void)TRIBO(feedforward, learn)(&loop->params, &loop->state.memory);
    return tribo_force_n(u, loop->full_scale_n);
}

bool foreign_loop_says(const foreign_loop_t *loop, const foreign_state_t *before)
{
    const foreign_state_t             *now     = &loop->state;
    const tribo_feedforward_learner_t *learner = &now->memory.state.learner;
    return now->state.guard.cause != TRIBO_GUARD_NONE || learner->at_bound >= TRIBO_FEEDFORWARD_BOUND_TURNS ||
           learner->harms != 0u || now->state.bad_inputs != before->state.bad_inputs ||
           now->memory.state.forgotten != before->memory.state.forgotten ||
           learner->forgotten != before->memory.state.learner.forgotten ||
           TRIBO_EITHER(false, now->state.controller.cascade.saturated != before->state.controller.cascade.saturated);
}
