#include "loop/loop_config.h"

#include "loop/loop_parts.h"

#include "tribo/paper_controller.h"

#include <string.h>

/// A parameter of the library: of the keys in double, of the configuration in single precision.
#define FILL(group, symbol, member, ...) to->member = (float)from->member;

static void fill_table(common_loop_config_t *loop, const common_breakaway_config_t *breakaway)
{
    for (unsigned i = 0; i < breakaway->table_count && i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        const common_breakaway_point_t *point = &breakaway->table[i];
        loop->table[i]                        = (tribo_breakaway_point_f32_t){.force_n    = (float)point->force_n,
                                                                              .positive_n = (float)point->positive_n,
                                                                              .negative_n = (float)point->negative_n};
    }
}

static void fill_friction(common_loop_config_t *loop, const common_friction_config_t *from)
{
    tribo_friction_f32_config_t     *to        = &loop->config.compensator.friction;
    const common_breakaway_config_t *breakaway = &from->breakaway;
    TRIBO_FRICTION_PARAMETERS(FILL)
    to->positive = (tribo_breakaway_f32_t){.offset_n = (float)breakaway->offset_n, .slope = (float)breakaway->slope};
    to->negative = (tribo_breakaway_f32_t){.offset_n = (float)common_breakaway_negative_offset(breakaway),
                                           .slope    = (float)common_breakaway_negative_slope(breakaway)};
    to->table    = (breakaway->table_count > 0) ? loop->table : NULL;
    to->table_length = breakaway->table_count;
    fill_table(loop, breakaway);
}

/// Sections in z^-1 go over to the delta operator in double, as TRIBO_BIQUAD_F32 does it.
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

    tribo_controller_f32_config_t *controller = &loop->config.controller;
    controller->sections                      = loop->sections;
    controller->u_min_n                       = (float)keys->limits.u_min_n;
    controller->u_max_n                       = (float)keys->limits.u_max_n;
    if (keys->controller.kind == COMMON_CONTROLLER_PAPER || keys->controller.kind == COMMON_CONTROLLER_NONE)
    {
        // None: one section, which is never stepped, and is no paper's controller that would hold for 1 ms alone.
        memcpy(loop->sections, paper, sizeof paper);
        controller->section_count =
            keys->controller.kind == COMMON_CONTROLLER_PAPER ? TRIBO_PAPER_CONTROLLER_SECTION_COUNT : 1;
        return;
    }
    if (keys->controller.kind == COMMON_CONTROLLER_PI)
    {
        const tribo_pi_t pi       = {(float)keys->controller.kp, (float)keys->controller.ki_per_s};
        loop->sections[0]         = tribo_pi_f32_section(&pi, loop->config.sample_time_s);
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
    TRIBO_FEEDFORWARD_PARAMETERS(FILL)
}

static void fill_sensorless(tribo_sensorless_f32_config_t *to, const common_sensorless_config_t *from)
{
    TRIBO_SENSORLESS_PARAMETERS(FILL)
}

static void fill_arm(tribo_arm_f32_config_t *to, const common_arm_config_t *from)
{
    TRIBO_ARM_PARAMETERS(FILL)
}

static void fill_guard(tribo_guard_f32_config_t *to, const common_guard_config_t *from)
{
    TRIBO_GUARD_PARAMETERS(FILL)
}

void common_loop_config_fill(common_loop_config_t *loop, const common_loop_keys_t *keys)
{
    const common_compensator_config_t *compensator = &keys->compensator;

    *loop                      = (common_loop_config_t){0};
    loop->config.sample_time_s = (float)keys->sample_time_s;
    loop->config.input_max_n   = (float)keys->limits.input_max_n;
    loop->config.gain          = compensator->method == COMMON_METHOD_OFF ? 0.0f : (float)compensator->gain;
    loop->config.usual_force_n = (float)compensator->usual_force_n;
    loop->feeds_forward        = compensator->method == COMMON_METHOD_FEEDFORWARD;
    loop->is_sensorless        = loop->feeds_forward && compensator->sensor == COMMON_SENSOR_NONE;
    loop->guarded              = compensator->guard.on != 0 && !loop->is_sensorless; // it judges y
    fill_controller(loop, keys);
    fill_friction(loop, &compensator->friction);
    fill_arm(&loop->config.compensator.arm, &compensator->arm);
    fill_feedforward(&loop->feedforward, &compensator->feedforward);
    fill_sensorless(&loop->sensorless, &compensator->sensorless);
    fill_guard(&loop->guard, &compensator->guard);
}

tribo_status_t common_loop_config_status(const common_loop_config_t *loop)
{
    tribo_force_loop_f32_params_t       params;
    tribo_feedforward_f32_params_t      feedforward;
    tribo_guard_f32_params_t            guard;
    const tribo_force_loop_f32_config_t config = common_loop_with_parts(loop, &feedforward, &guard);
    return tribo_force_loop_f32_init(&params, &config);
}
