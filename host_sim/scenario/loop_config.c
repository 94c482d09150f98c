#include "scenario/loop_config.h"

#include "plant/breakaway.h"
#include "tribo/paper_controller.h"

#include <string.h>

static void fill_table(sim_loop_config_t *loop, const sim_breakaway_config_t *breakaway)
{
    for (unsigned i = 0; i < breakaway->table_count && i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        const sim_breakaway_point_t *point = &breakaway->table[i];
        loop->table[i]                     = (tribo_breakaway_point_f32_t){.force_n    = (float)point->force_n,
                                                                           .positive_n = (float)point->positive_n,
                                                                           .negative_n = (float)point->negative_n};
    }
}

static void fill_friction(sim_loop_config_t *loop, const sim_friction_config_t *friction)
{
    const sim_breakaway_config_t *breakaway = &friction->breakaway;
    fill_table(loop, breakaway);
    loop->config.compensator.friction = (tribo_friction_f32_config_t){
        .k_min         = (float)friction->k_min,
        .k_max         = (float)friction->k_max,
        .m             = (float)friction->m,
        .v0_n_per_s    = (float)friction->v0_n_per_s,
        .positive      = {.offset_n = (float)breakaway->offset_n, .slope = (float)breakaway->slope},
        .negative      = {.offset_n = (float)sim_breakaway_negative_offset(breakaway),
                          .slope    = (float)sim_breakaway_negative_slope(breakaway)},
        .table         = (breakaway->table_count > 0) ? loop->table : NULL,
        .table_length  = breakaway->table_count,
        .set_level     = (float)friction->set_level,
        .reset_level   = (float)friction->reset_level,
        .pulse_width_s = (float)friction->pulse_width_s,
        .gravity_n     = (float)friction->gravity_n};
}

/// Sections in z^-1 go over to the delta operator in double, as TRIBO_BIQUAD_F32 does it.
static tribo_biquad_f32_section_t convert_section(const sim_section_t *section, sim_controller_kind_t kind)
{
    sim_section_t delta = *section;
    if (kind == SIM_CONTROLLER_Z)
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

static void fill_controller(sim_loop_config_t *loop, const sim_config_t *config)
{
    static const tribo_biquad_f32_section_t paper[] = TRIBO_PAPER_CONTROLLER_F32;

    tribo_controller_f32_config_t *controller = &loop->config.controller;
    controller->sections                      = loop->sections;
    controller->u_min_n                       = (float)config->limits.u_min_n;
    controller->u_max_n                       = (float)config->limits.u_max_n;
    if (config->controller.kind == SIM_CONTROLLER_PAPER || config->controller.kind == SIM_CONTROLLER_NONE)
    {
        memcpy(loop->sections, paper, sizeof paper);
        controller->section_count = TRIBO_PAPER_CONTROLLER_SECTION_COUNT;
        return;
    }
    controller->section_count = config->controller.section_count;
    for (unsigned i = 0; i < config->controller.section_count && i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        loop->sections[i] = convert_section(&config->controller.sections[i], config->controller.kind);
    }
}

static void fill_feedforward(sim_loop_config_t *loop, const sim_feedforward_config_t *config)
{
    const sim_learning_config_t *learning = &config->learning;
    const sim_hold_config_t     *hold     = &config->hold;
    loop->feedforward =
        (tribo_feedforward_f32_config_t){.actuator_pole_rad_per_s = (float)config->actuator_pole_rad_per_s,
                                         .sensor_pole_rad_per_s   = (float)config->sensor_pole_rad_per_s,
                                         .reversal_n              = (float)config->reversal_n,
                                         .jump_time_s             = (float)config->jump_time_s,
                                         .lead                    = (float)config->lead,
                                         .noise_gain              = (float)config->noise_gain,
                                         .noise_time_s            = (float)config->noise_time_s,
                                         .rate_time_s             = (float)config->rate_time_s,
                                         .rate_max_n_per_s        = (float)config->rate_max_n_per_s,
                                         .offset_time_s           = (float)config->offset_time_s,
                                         .slide_width_n           = (float)config->slide_width_n,
                                         .slide_filter_time_s     = (float)config->slide_filter_time_s,
                                         .slide_rate_max_n_per_s  = (float)config->slide_rate_max_n_per_s,
                                         .slide_run_in_n          = (float)config->slide_run_in_n,
                                         .slide_error_max_n       = (float)config->slide_error_max_n,
                                         .learning                = {.spread_scale      = (float)learning->spread_scale,
                                                                     .spread_offset_n   = (float)learning->spread_offset_n,
                                                                     .correlation       = (float)learning->correlation,
                                                                     .correlation_faded = (float)learning->correlation_faded,
                                                                     .trust             = (float)learning->trust,
                                                                     .doubt             = (float)learning->doubt,
                                                                     .weight_n          = (float)learning->weight_n,
                                                                     .forgetting_per_n  = (float)learning->forgetting_per_n,
                                                                     .scale_min         = (float)learning->scale_min,
                                                                     .scale_max         = (float)learning->scale_max},
                                         .hold                    = {.gain             = (float)hold->gain,
                                                                     .still_time_s     = (float)hold->still_time_s,
                                                                     .margin           = (float)hold->margin,
                                                                     .quick_time_s     = (float)hold->quick_time_s,
                                                                     .caution_travel_n = (float)hold->caution_travel_n,
                                                                     .deadband_time_s  = (float)hold->deadband_time_s}};
}

void sim_loop_config_fill(sim_loop_config_t *loop, const sim_config_t *config)
{
    *loop                      = (sim_loop_config_t){0};
    loop->config.sample_time_s = (float)config->sample_time_s;
    loop->config.input_max_n   = (float)config->limits.input_max_n;
    loop->config.gain          = config->compensator.method == SIM_METHOD_OFF ? 0.0f : (float)config->compensator.gain;
    loop->feeds_forward        = config->compensator.method == SIM_METHOD_FEEDFORWARD;
    const sim_bristles_config_t *lugre = &config->compensator.lugre;
    loop->has_lugre                    = config->compensator.model == SIM_MODEL_LUGRE && !loop->feeds_forward;
    loop->lugre                        = (tribo_lugre_f32_config_t){.stiffness = (float)lugre->stiffness_n_per_deg,
                                                                    .damping   = (float)lugre->bristle_damping_n_s_per_deg,
                                                                    .viscous   = (float)lugre->viscous_n_s_per_deg};
    const sim_guard_config_t *guard    = &config->compensator.guard;
    loop->guarded                      = guard->on != 0;
    loop->guard                        = (tribo_guard_f32_config_t){.turn_n       = (float)guard->turn_n,
                                                                    .quick_time_s = (float)guard->quick_time_s,
                                                                    .stray_n      = (float)guard->stray_n,
                                                                    .fade_time_s  = (float)guard->fade_time_s};
    fill_controller(loop, config);
    fill_friction(loop, &config->compensator.friction);
    fill_feedforward(loop, &config->compensator.feedforward);
    loop->config.compensator.arm =
        (tribo_arm_f32_config_t){.inertia   = (float)config->compensator.arm.inertia_n_s2_per_deg,
                                 .damping   = (float)config->compensator.arm.damping_n_s_per_deg,
                                 .stiffness = (float)config->compensator.arm.stiffness_n_per_deg};
}
