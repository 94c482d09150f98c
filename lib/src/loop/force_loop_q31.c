#include "tribo/force_loop_q31.h"

#include "tribo/force_loop_f32.h"

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "loop_q31.h"
#include "prepare.h"

#include "parts.h"

/// Makes what every method needs from the controller and the gain that the set-up in float32 has accepted.
static tribo_status_t make_controller(tribo_force_loop_q31_params_t       *made,
                                      const tribo_force_loop_q31_config_t *config,
                                      const tribo_controller_f32_config_t *controller,
                                      tribo_headroom_q31_t                *headroom)
{
    const tribo_force_loop_f32_config_t *const loop         = &config->loop;
    const float                                full_scale_n = config->full_scale_n;
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    if (!within(loop->input_max_n / full_scale_n, FIXED_Q31_SMALLEST, 1.0f))
    {
        return TRIBO_ERR_INPUT_MAX;
    }
    *made = (tribo_force_loop_q31_params_t){.input_max = fixed_input_max(loop->input_max_n, full_scale_n),
                                            .gain      = fixed(loop->gain, LOOP_Q31_GAIN_FRACTION)};
    return tribo_force_loop_f32_controller_status(
        loop,
        tribo_controller_q31_init(&made->controller, controller, full_scale_n, headroom));
}

tribo_status_t tribo_force_loop_q31_init(tribo_force_loop_q31_params_t       *params,
                                         const tribo_force_loop_q31_config_t *config)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    const tribo_force_loop_f32_config_t *const loop         = &config->loop;
    const float                                full_scale_n = config->full_scale_n;

    tribo_force_loop_q31_params_t made;
    tribo_headroom_q31_t          headroom;
    tribo_force_loop_f32_params_t f32;
    tribo_controller_f32_config_t controller;
    tribo_biquad_f32_section_t    section;

    tribo_status_t status = tribo_force_loop_f32_prepare(&f32, loop, &controller, &section);
    status                = status == TRIBO_OK ? make_controller(&made, config, &controller, &headroom) : status;
    if (status == TRIBO_OK)
    {
        status = tribo_compensator_q31_init(&made.compensator,
                                            config->table,
                                            &loop->compensator,
                                            loop->sample_time_s,
                                            full_scale_n);
    }
    status = status == TRIBO_OK ? make_parts(loop, full_scale_n, &made) : status;
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    if (status == TRIBO_OK && config->headroom != NULL)
    {
        *config->headroom = headroom;
    }
    return status;
}

tribo_status_t tribo_force_loop_q31_init_method(tribo_force_loop_q31_params_t       *made,
                                                const tribo_force_loop_q31_config_t *config)
{
    const tribo_force_loop_f32_config_t *const loop = &config->loop;
    tribo_headroom_q31_t                       headroom;
    tribo_force_loop_f32_params_t              f32;
    tribo_controller_f32_config_t              controller;
    tribo_biquad_f32_section_t                 section;

    tribo_status_t status = tribo_force_loop_f32_prepare_method(&f32, loop, &controller, &section);
    status                = status == TRIBO_OK ? make_controller(made, config, &controller, &headroom) : status;
    if (status == TRIBO_OK)
    {
        status = tribo_friction_q31_init(&made->compensator.friction,
                                         NULL,
                                         &loop->compensator.friction,
                                         loop->sample_time_s,
                                         config->full_scale_n);
    }
    return status == TRIBO_OK ? make_parts(loop, config->full_scale_n, made) : status;
}

#include "step.h"
