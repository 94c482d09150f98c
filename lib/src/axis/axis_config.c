#include "axis_config.h"

#include "../loop/prepare.h"
#include "../number/ieee_f32.h"
#include "../number/ranges.h"

#define LEAST_LAG       0.05f   // least lag of the arm, ticks: its poles stay inside the unit circle in Q31
#define LAG_MAX         1.0e3f  // largest lag of the arm, ticks
#define PRIOR_DEVIATION 0.45f   // standard deviation of the configured breakaway before learning, as a part of it
#define MODEL_DEVIATION 0.02f   // standard deviation that learning does not remove, as a part of breakaway
#define OWN_GAIN        1.0e-6f // kp that the loop's init accepts; that controller never runs

#define WARN_BAD_INPUT 1u
#define WARN_LIMITED   2u
#define WARN_AT_BOUND  4u
#define WARN_HARMS     8u
#define WARN_HUNTING   16u
#define WARN_OVERSHOOT 32u
#define WARN_FORGOTTEN 64u
#define WARN_LATE      128u

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

/// A critically damped arm with the given lag. The methods use only its damping divided by stiffness.
static tribo_arm_f32_config_t arm_of(float lag_s, float h)
{
    const float b = larger(lag_s, LEAST_LAG * h);
    return (tribo_arm_f32_config_t){.inertia = 0.25f * b * b, .damping = b, .stiffness = 1.0f};
}

tribo_status_t tribo_axis_config_expand(tribo_force_loop_f32_config_t *loop, const tribo_axis_f32_config_t *config)
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
    loop->input_max_n =
        config->input_max_n != 0.0f ? config->input_max_n : limit_f32(2.0f * most, 0.0f, TRIBO_F32_FORCE_MAX_N);
    loop->usual_force_n      = config->usual_force_n;
    loop->controller.u_min_n = config->u_min_n;
    loop->controller.u_max_n = config->u_max_n;
    loop->compensator.arm    = arm_of(config->arm_lag_s, h);

    tribo_friction_f32_config_t *const friction = &loop->compensator.friction;

    const bool is_same      = config->negative.offset_n == 0.0f && config->negative.slope == 0.0f;
    friction->positive      = config->positive;
    friction->negative      = is_same ? config->positive : config->negative;
    friction->gravity_n     = config->gravity_n;
    friction->v0_n_per_s    = larger(friction->v0_n_per_s, 1.0e-3f * most);
    friction->pulse_width_s = h;
    return set_controller(loop, &config->controller);
}

float tribo_axis_config_breakaway(const tribo_force_loop_f32_config_t *loop)
{
    const tribo_friction_f32_config_t *const friction = &loop->compensator.friction;

    const float F = tribo_force_loop_f32_usual_force_n(loop);
    return 0.5f * (friction->positive.offset_n + friction->negative.offset_n +
                   (friction->positive.slope + friction->negative.slope) * F);
}

tribo_guard_f32_config_t tribo_axis_config_guard(const tribo_force_loop_f32_config_t *loop,
                                                 const tribo_axis_f32_config_t       *config)
{
    const float lag = tribo_feedforward_f32_lag_s(&config->feedforward, &loop->compensator.arm);
    return tribo_guard_f32_tuned(tribo_axis_config_breakaway(loop), lag, config->noise_n, loop->sample_time_s);
}

uint32_t tribo_axis_checksum(const void *bytes, size_t size)
{
    const unsigned char *const at  = (const unsigned char *)bytes;
    uint32_t                   crc = UINT32_MAX;
    for (size_t i = 0; i < size; i++)
    {
        crc ^= at[i];
        for (uint32_t bit = 0; bit < 8u; bit++)
        {
            crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
        }
    }
    return ~crc;
}

uint32_t tribo_axis_config_rig(const tribo_force_loop_f32_config_t *loop,
                               const tribo_axis_f32_config_t       *config,
                               float                                full_scale_n)
{
    const tribo_friction_f32_config_t *const friction = &loop->compensator.friction;

    const float numbers[] = {friction->positive.offset_n,
                             friction->positive.slope,
                             friction->negative.offset_n,
                             friction->negative.slope,
                             tribo_axis_config_breakaway(loop),
                             config->feedforward.presliding_n,
                             full_scale_n};
    return tribo_axis_checksum(numbers, sizeof numbers);
}

void tribo_axis_report_direction(tribo_axis_report_t               *report,
                                 uint32_t                           direction,
                                 const tribo_feedforward_learned_t *learned,
                                 float                              breakaway_n)
{
    const float L = learned->L_n;
    const float spread =
        2.0f * (PRIOR_DEVIATION * root_f32(limit_f32(learned->relative_variance, 0.0f, 1.0f)) * breakaway_n +
                MODEL_DEVIATION * L);

    report->breakaway_n[direction] = L;
    report->low_n[direction]       = larger(L - spread, 0.0f);
    report->high_n[direction]      = L + spread;
    report->travel_n               = learned->travel_n;
}

static uint32_t bit_if(bool is_set, uint32_t bit)
{
    return is_set ? bit : 0u;
}

void tribo_axis_report_warn(tribo_axis_report_t               *report,
                            const tribo_feedforward_learned_t *learned,
                            tribo_guard_cause_t                cause)
{
    report->warnings =
        bit_if(report->bad_inputs > 0u, WARN_BAD_INPUT) | bit_if(report->limited_ticks > 0u, WARN_LIMITED) |
        bit_if(learned->stays_at_bound, WARN_AT_BOUND) | bit_if(learned->harms, WARN_HARMS) |
        bit_if(cause == TRIBO_GUARD_HUNTING, WARN_HUNTING) | bit_if(cause == TRIBO_GUARD_OVERSHOOT, WARN_OVERSHOOT) |
        bit_if(report->forgotten > 0u, WARN_FORGOTTEN) |
        bit_if(report->late > 0u && learned->travel_n == 0.0f, WARN_LATE);
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
    case WARN_AT_BOUND:
        return "breakaway: learning stays at its limit, 0.2 or 3 times the configured one";
    case WARN_HARMS:
        return "friction fed forward cost the controller more than it saved, and was fed back";
    case WARN_HUNTING:
        return "guard: friction faded, it reversed quickly and drove the force against the reference";
    case WARN_OVERSHOOT:
        return "guard: friction faded, the force overshot its reversals again and again";
    case WARN_FORGOTTEN:
        return "forgotten: corrupt memory was found and reset, or a tick's first half was called without its second";
    case WARN_LATE:
        return "late: nothing is learned, because nobody calls tribo_axis_q31_learn";
    default:
        return NULL;
    }
}
