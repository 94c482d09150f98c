#include "tribo/force_loop_f32.h"

#include "tribo/paper_controller.h"

#include "../friction/law_f32.h"
#include "../number/ranges.h"
#include "loop_f32.h"
#include "prepare.h"

#include <stddef.h>

#include "parts.h"

#define PI_MAX 1.0e5f // largest kp, and largest ki_per_s

#define ROW(...) PARAMETERS_ROW(tribo_force_loop_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_loop_parameters[] = {TRIBO_SAMPLE_PARAMETERS(ROW) TRIBO_INPUT_PARAMETERS(ROW)
                                                       TRIBO_GAIN_PARAMETERS(ROW)};
#undef ROW

tribo_force_loop_f32_config_t tribo_force_loop_f32_paper(void)
{
    tribo_force_loop_f32_config_t paper = {
        TRIBO_SAMPLE_PARAMETERS(PARAMETERS_DEFAULT) TRIBO_INPUT_PARAMETERS(PARAMETERS_DEFAULT)
            TRIBO_GAIN_PARAMETERS(PARAMETERS_DEFAULT)
                .controller = {.section_count = TRIBO_PAPER_CONTROLLER_SECTION_COUNT,
                               TRIBO_LIMIT_PARAMETERS(PARAMETERS_DEFAULT)},
        .compensator        = {.friction = {TRIBO_FRICTION_PARAMETERS(PARAMETERS_DEFAULT)
                                                TRIBO_BREAKAWAY_PARAMETERS(PARAMETERS_DEFAULT)},
                               .arm      = {TRIBO_ARM_PARAMETERS(PARAMETERS_DEFAULT)}},
    };
    paper.controller.sections = tribo_paper_controller_f32; // an address in an initialiser would be a relocation
    return paper;
}

tribo_force_loop_f32_config_t tribo_force_loop_f32_rig(void)
{
    const tribo_force_loop_f32_config_t rig = {TRIBO_GAIN_PARAMETERS(PARAMETERS_DEFAULT).compensator.friction = {
                                                   TRIBO_FRICTION_PARAMETERS(PARAMETERS_DEFAULT)}};
    return rig;
}

/// True if each number of the sections is that of the paper's controller.
static bool is_papers(const tribo_controller_f32_config_t *config)
{
    const uint32_t each    = sizeof(tribo_biquad_f32_section_t) / sizeof(float);
    const uint32_t numbers = TRIBO_PAPER_CONTROLLER_SECTION_COUNT * each;
    const float   *papers  = (const float *)tribo_paper_controller_f32;
    const float   *own     = (const float *)config->sections;
    bool           same    = config->section_count == TRIBO_PAPER_CONTROLLER_SECTION_COUNT;
    for (uint32_t i = 0; i < numbers && same; i++)
    {
        same = own[i] == papers[i];
    }
    return same;
}

/// The PI kp + ki h/2 (z + 1)/(z - 1) as a section in d = z - 1. Its second pole is at z = 0, where a zero cancels it.
/// Without ki both poles are cancelled there.
tribo_biquad_f32_section_t tribo_pi_f32_section(const tribo_pi_t *pi, float sample_time_s)
{
    const float step = pi->ki_per_s * sample_time_s;
    const float b0   = pi->kp + 0.5f * step;
    return step > 0.0f ? (tribo_biquad_f32_section_t){.b0 = b0, .b1 = b0 + step, .b2 = step, .a1 = 1.0f}
                       : (tribo_biquad_f32_section_t){.b0 = b0, .b1 = b0, .b2 = 0.25f * b0, .a1 = 1.0f, .a2 = 0.25f};
}

/// Gives the controller of `config`: its sections, or its PI as the one section `section`.
static tribo_status_t name_controller(tribo_controller_f32_config_t       *controller,
                                      tribo_biquad_f32_section_t          *section,
                                      const tribo_force_loop_f32_config_t *config)
{
    const tribo_pi_t *const pi = &config->pi;

    *controller = config->controller;
    if (pi->kp == 0.0f && pi->ki_per_s == 0.0f)
    {
        return TRIBO_OK;
    }
    if (!within(pi->kp, 1.0e-6f, PI_MAX) || !within(pi->ki_per_s, 0.0f, PI_MAX) ||
        pi->ki_per_s * config->sample_time_s > 2.0f * pi->kp)
    {
        return TRIBO_ERR_PI;
    }
    if (controller->section_count > 0u)
    {
        return TRIBO_ERR_CONTROLLER;
    }
    *section                  = tribo_pi_f32_section(pi, config->sample_time_s);
    controller->sections      = section;
    controller->section_count = 1;
    return TRIBO_OK;
}

tribo_status_t tribo_force_loop_f32_make_sections(tribo_controller_f32_params_t       *made,
                                                  const tribo_controller_f32_config_t *controller,
                                                  float                                sample_time_s)
{
    const tribo_status_t status = tribo_controller_f32_init(made, controller);
    const bool           other  = magnitude(sample_time_s - TRIBO_PAPER_CONTROLLER_SAMPLE_TIME_S) > 1.0e-9f;
    return status == TRIBO_OK && other && is_papers(controller) ? TRIBO_ERR_PAPER_SAMPLE_TIME : status;
}

tribo_status_t tribo_force_loop_f32_controller_status(const tribo_force_loop_f32_config_t *config,
                                                      tribo_status_t                       status)
{
    const bool is_section = status == TRIBO_ERR_ANTI_WINDUP || status == TRIBO_ERR_HEADROOM;
    return is_section && config->pi.kp > 0.0f ? TRIBO_ERR_PI : status;
}

/// Makes what every method needs: the ranges of the inputs, and the controller.
static tribo_status_t make_controller(tribo_force_loop_f32_params_t       *made,
                                      const tribo_force_loop_f32_config_t *config,
                                      tribo_controller_f32_make_t         *make,
                                      tribo_controller_f32_config_t       *controller,
                                      tribo_biquad_f32_section_t          *section)
{
    *made                 = (tribo_force_loop_f32_params_t){.input_max_n = config->input_max_n, .gain = config->gain};
    tribo_status_t status = PARAMETERS_CHECK(tribo_loop_parameters, config);
    status                = status == TRIBO_OK ? name_controller(controller, section, config) : status;
    if (status == TRIBO_OK)
    {
        status = make != NULL ? make(&made->controller, controller, config->sample_time_s)
                              : tribo_controller_f32_init_pi(&made->controller, controller);
        status = tribo_force_loop_f32_controller_status(config, status);
    }
    return status;
}

/// Makes what a method other than the paper's needs.
static tribo_status_t make_for_method(tribo_force_loop_f32_params_t       *made,
                                      const tribo_force_loop_f32_config_t *config,
                                      tribo_controller_f32_make_t         *make,
                                      tribo_controller_f32_config_t       *controller,
                                      tribo_biquad_f32_section_t          *section)
{
    const tribo_status_t status = make_controller(made, config, make, controller, section);
    return status == TRIBO_OK ? tribo_friction_f32_init_law(&made->compensator.friction, &config->compensator.friction)
                              : status;
}

tribo_status_t tribo_force_loop_f32_prepare(tribo_force_loop_f32_params_t       *made,
                                            const tribo_force_loop_f32_config_t *config,
                                            tribo_controller_f32_config_t       *controller,
                                            tribo_biquad_f32_section_t          *section)
{
    const tribo_status_t status =
        make_controller(made, config, tribo_force_loop_f32_make_sections, controller, section);
    return status == TRIBO_OK
               ? tribo_compensator_f32_init(&made->compensator, &config->compensator, config->sample_time_s)
               : status;
}

tribo_status_t tribo_force_loop_f32_prepare_method(tribo_force_loop_f32_params_t       *made,
                                                   const tribo_force_loop_f32_config_t *config,
                                                   tribo_controller_f32_config_t       *controller,
                                                   tribo_biquad_f32_section_t          *section)
{
    return make_for_method(made, config, tribo_force_loop_f32_make_sections, controller, section);
}

tribo_status_t tribo_force_loop_f32_init(tribo_force_loop_f32_params_t       *params,
                                         const tribo_force_loop_f32_config_t *config)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_force_loop_f32_params_t made;
    tribo_controller_f32_config_t controller;
    tribo_biquad_f32_section_t    section;
    tribo_status_t                status = tribo_force_loop_f32_prepare(&made, config, &controller, &section);
    status                               = status == TRIBO_OK ? make_parts(config, 1.0f, &made) : status;
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

tribo_status_t tribo_force_loop_f32_init_method(tribo_force_loop_f32_params_t       *made,
                                                const tribo_force_loop_f32_config_t *config,
                                                tribo_controller_f32_make_t         *make)
{
    tribo_controller_f32_config_t controller;
    tribo_biquad_f32_section_t    section;
    const tribo_status_t          status = make_for_method(made, config, make, &controller, &section);
    return status == TRIBO_OK ? make_parts(config, 1.0f, made) : status;
}

#include "step.h"
