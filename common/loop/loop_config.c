#include "loop/loop_config.h"

#include "loop/compensator_config.h"
#include "tribo/paper_controller.h"
#include "tribo_arithmetic.h"

#include <string.h>

/// Converts a section in z^-1 to the delta operator in double precision, with the formulas of TRIBO_BIQUAD_F32.
static tribo_biquad_f32_section_t convert_section(const common_section_t *section, common_controller_kind_t kind)
{
    common_section_t delta = *section;
    if (kind == COMMON_CONTROLLER_Z)
    {
        delta.b1 = 2.0 * section->b0 + section->b1;
        delta.b2 = section->b0 + section->b1 + section->b2;
        delta.a1 = 2.0 + section->a1;
        delta.a2 = 1.0 + section->a1 + section->a2;
    }
    return (tribo_biquad_f32_section_t){.b0 = (float)delta.b0,
                                        .b1 = (float)delta.b1,
                                        .b2 = (float)delta.b2,
                                        .a1 = (float)delta.a1,
                                        .a2 = (float)delta.a2};
}

static void fill_controller(common_loop_config_t *loop, const common_loop_keys_t *keys)
{
    static const tribo_biquad_f32_section_t paper[] = TRIBO_PAPER_CONTROLLER_F32;

    tribo_controller_f32_config_t *controller = &loop->parts.config.controller;
    controller->sections                      = loop->sections;
    controller->u_min_n                       = (float)keys->limits.u_min_n;
    controller->u_max_n                       = (float)keys->limits.u_max_n;
    if (keys->controller.kind == COMMON_CONTROLLER_PAPER || keys->controller.kind == COMMON_CONTROLLER_NONE)
    {
        // For kind none, one section stands in. It is never stepped, and is not the paper's controller, which is refused
        // unless h is 1 ms.
        memcpy(loop->sections, paper, sizeof paper);
        controller->section_count =
            keys->controller.kind == COMMON_CONTROLLER_PAPER ? TRIBO_PAPER_CONTROLLER_SECTION_COUNT : 1;
        return;
    }
    if (keys->controller.kind == COMMON_CONTROLLER_PI)
    {
        const tribo_pi_t pi       = {(float)keys->controller.kp, (float)keys->controller.ki_per_s};
        loop->sections[0]         = tribo_pi_f32_section(&pi, loop->parts.config.sample_time_s);
        controller->section_count = 1;
        return;
    }
    controller->section_count = keys->controller.section_count;
    for (unsigned i = 0; i < keys->controller.section_count && i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        loop->sections[i] = convert_section(&keys->controller.sections[i], keys->controller.kind);
    }
}

static void fill_feedforward(tribo_feedforward_f32_config_t *to, const common_feedforward_config_t *from)
{
    TRIBO_FEEDFORWARD_PARAMETERS(COMMON_FILL)
}

static void fill_sensorless(tribo_sensorless_f32_config_t *to, const common_sensorless_config_t *from)
{
    TRIBO_SENSORLESS_PARAMETERS(COMMON_FILL)
}

static void fill_guard(tribo_guard_f32_config_t *to, const common_guard_config_t *from)
{
    TRIBO_GUARD_PARAMETERS(COMMON_FILL)
}

void common_loop_config_fill(common_loop_config_t *loop, const common_loop_keys_t *keys)
{
    const common_compensator_config_t *compensator = &keys->compensator;

    tribo_loop_parts_t *parts = &loop->parts;

    *loop                       = (common_loop_config_t){0};
    parts->config.sample_time_s = (float)keys->sample_time_s;
    parts->config.input_max_n   = (float)keys->limits.input_max_n;
    parts->config.gain          = compensator->method == COMMON_METHOD_OFF ? 0.0f : (float)compensator->gain;
    parts->config.usual_force_n = (float)compensator->usual_force_n;
    parts->feeds_forward        = compensator->method == COMMON_METHOD_FEEDFORWARD;
    parts->is_sensorless        = parts->feeds_forward && compensator->sensor == COMMON_SENSOR_NONE;
    parts->guarded              = compensator->guard.on != 0 && !parts->is_sensorless; // a guard judges y
    fill_controller(loop, keys);
    common_friction_config_fill(&parts->config.compensator.friction, loop->table, &compensator->friction);
    common_arm_config_fill(&parts->config.compensator.arm, &compensator->arm);
    fill_feedforward(&parts->feedforward, &compensator->feedforward);
    fill_sensorless(&parts->sensorless, &compensator->sensorless);
    fill_guard(&parts->guard, &compensator->guard);
}

tribo_status_t common_loop_config_status(const common_loop_config_t *loop)
{
    tribo_force_loop_f32_params_t       params;
    tribo_feedforward_f32_params_t      feedforward;
    tribo_guard_f32_params_t            guard;
    const tribo_force_loop_f32_config_t config = tribo_loop_with_parts(&loop->parts, &feedforward, &guard);
    return tribo_force_loop_f32_init(&params, &config);
}
