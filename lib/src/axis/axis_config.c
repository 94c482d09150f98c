#include "axis_config.h"

#include "../loop/prepare.h"
#include "../number/ieee_f32.h"
#include "../number/ranges.h"

#define LEAST_LAG   0.05f // least lag of the arm, ticks: its poles stay inside the unit circle in Q31
#define INERTIA_MIN 1.0e-12f
#define STIFF       1048576.0f // of a quick arm, 2^20
#define LAG_MAX     1.0e3f     // largest lag of the arm, ticks
#define INPUT_LEAST 1.0e-6f    // N, of the input_max_n that follows from the limits of u
#define USUAL_PART  0.25f      // of the larger limit of u, as in tribo_force_loop_f32_usual_force_n
#define OWN_GAIN    1.0e-6f    // kp that the loop's init accepts; that controller never runs

tribo_axis_controller_t tribo_pi(float kp, float ki_per_s)
{
    return (tribo_axis_controller_t){.kind = TRIBO_CONTROLLER_PI, .kp = kp, .ki_per_s = ki_per_s};
}

/// Static, because the address of another source's function would be an absolute one.
static tribo_status_t make_sections(tribo_controller_f32_params_t       *made,
                                    const tribo_controller_f32_config_t *controller,
                                    float                                sample_time_s)
{
    return tribo_force_loop_f32_make_sections(made, controller, sample_time_s);
}

tribo_axis_controller_t tribo_sections(const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    tribo_axis_controller_t controller = {.kind          = TRIBO_CONTROLLER_SECTIONS,
                                          .sections      = sections,
                                          .section_count = count};
    controller.make                    = make_sections;
    return controller;
}

tribo_axis_controller_t tribo_paper(void)
{
    const tribo_force_loop_f32_config_t paper = tribo_force_loop_f32_paper();
    return tribo_sections(paper.controller.sections, paper.controller.section_count);
}

tribo_axis_controller_t tribo_own(void)
{
    return (tribo_axis_controller_t){.kind = TRIBO_CONTROLLER_OWN};
}

tribo_axis_f32_config_t tribo_axis_f32_config(void)
{
    tribo_axis_f32_config_t config = {.feedforward = tribo_feedforward_f32_default()};

    config.feedforward.actuator_pole_rad_per_s = 0.0f;
    config.feedforward.sensor_pole_rad_per_s   = 0.0f;
    return config;
}

static tribo_status_t set_controller(tribo_force_loop_f32_config_t *loop, const tribo_axis_controller_t *controller)
{
    switch (controller->kind)
    {
    case TRIBO_CONTROLLER_PI:
        loop->pi = (tribo_pi_t){controller->kp, controller->ki_per_s};
        return controller->kp > 0.0f ? TRIBO_OK : TRIBO_ERR_PI; // kp = 0 would mean no PI to the loop
    case TRIBO_CONTROLLER_SECTIONS:
        loop->controller.sections      = controller->sections;
        loop->controller.section_count = controller->section_count;
        return controller->make != NULL ? TRIBO_OK : TRIBO_ERR_CONTROLLER;
    case TRIBO_CONTROLLER_OWN:
        loop->pi.kp = OWN_GAIN;
        return TRIBO_OK;
    default:
        return TRIBO_ERR_CONTROLLER;
    }
}

/// A critically damped arm with the given lag. The methods use only its damping divided by stiffness. A quick arm is
/// stiff because its inertia would otherwise be less than an arm may have.
static tribo_arm_f32_config_t arm_of(float lag_s, float h)
{
    const float b = larger(lag_s, LEAST_LAG * h);
    const float I = 0.25f * b * b;
    const float K = I < INERTIA_MIN ? STIFF : 1.0f;
    return (tribo_arm_f32_config_t){.inertia = I * K, .damping = b * K, .stiffness = K};
}

tribo_status_t tribo_axis_config_expand(tribo_force_loop_f32_config_t *loop,
                                        const tribo_axis_f32_config_t *config,
                                        float                          most_n)
{
    const float h = config->sample_time_s;
    if (!sample_time_ok(h))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    if (!within(config->u_min_n, -TRIBO_F32_FORCE_MAX_N, 0.0f))
    {
        return TRIBO_ERR_U_MIN;
    }
    if (!within(config->u_max_n, 0.0f, TRIBO_F32_FORCE_MAX_N) || !(config->u_max_n > config->u_min_n))
    {
        return TRIBO_ERR_U_MAX;
    }
    if (!within(config->arm_lag_s, 0.0f, LAG_MAX * h))
    {
        return TRIBO_ERR_AXIS_LAG;
    }
    if (!within(config->noise_n, 0.0f, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_AXIS_NOISE;
    }
    const float most = larger(-config->u_min_n, config->u_max_n);

    *loop               = tribo_force_loop_f32_rig();
    loop->sample_time_s = h;
    loop->input_max_n = config->input_max_n != 0.0f ? config->input_max_n : limit_f32(2.0f * most, INPUT_LEAST, most_n);
    loop->usual_force_n      = config->usual_force_n != 0.0f ? config->usual_force_n : USUAL_PART * most;
    loop->controller.u_min_n = config->u_min_n;
    loop->controller.u_max_n = config->u_max_n;
    loop->compensator.arm    = arm_of(config->arm_lag_s, h);

    tribo_friction_f32_config_t *const friction = &loop->compensator.friction;

    const bool is_same      = config->negative.offset_n == 0.0f && config->negative.slope == 0.0f;
    friction->positive      = config->positive;
    friction->negative      = is_same ? config->positive : config->negative;
    friction->gravity_n     = config->gravity_n;
    friction->v0_n_per_s    = larger(friction->v0_n_per_s, 1.0e-3f * most_n); // not used, but checked in Q31
    friction->pulse_width_s = h;
    return set_controller(loop, &config->controller);
}

const char *tribo_axis_warning(uint32_t *warnings)
{
    const uint32_t first = *warnings & (0u - *warnings);
    *warnings &= ~first;
    switch (first)
    {
    case WARN_BAD_INPUT:
        return "bad_inputs: a reference or a reading was not a number, or beyond input_max_n";
    case WARN_LIMITED:
        return "limited_ticks: u was at u_min_n or u_max_n";
    case WARN_TOO_SMALL:
        return "breakaway: friction is 3 times the configured one or more, or gravity_n lacks a load: "
               "configure 3 times the breakaway, or the load, and initialise the axis again";
    case WARN_TOO_LARGE:
        return "breakaway: learning stays below 0.25 times the configured one: configure 0.2 times as much and "
               "initialise the axis again; if the breakaway is certain, lost contact, noise of y or steps of r hide it";
    case WARN_LONG:
        return "presliding: friction builds up over a longer travel than configured: double presliding_n "
               "(0 stands for 1/11 of the breakaway) and initialise the axis again";
    case WARN_SHORT:
        return "presliding: friction builds up over a shorter travel than configured: halve presliding_n "
               "(0 stands for 1/11 of the breakaway) and initialise the axis again";
    case WARN_HUNTING:
        return "guard: friction faded until a restore; it reversed quickly and drove the force against the reference: "
               "do what a warning of breakaway or presliding says; if that is not enough set still_time_s to 0 where r "
               "steps or holds a still object, otherwise measure the poles, arm_lag_s and breakaway again";
    case WARN_OVERSHOOT:
        return "guard: friction faded until a restore; the force overshot its reversals again and again: "
               "do what a warning of breakaway or presliding says; if that is not enough set noise_n to an eighth "
               "of the overshoot that you accept, or double presliding_n (0 stands for 1/11 of the breakaway)";
    case WARN_FORGOTTEN:
        return "forgotten: corrupt memory was found and reset, or a tick's first half was called without its second";
    case WARN_LATE:
        return "late: nothing is learned, because nobody calls tribo_axis_q31_learn";
    case WARN_CALLS:
        return "calls: tribo_own runs by tribo_axis_..._error and then _command, any other controller by "
               "tribo_axis_..._step";
    default:
        return NULL;
    }
}
