#include "tribo/force_loop_f32.h"

#include "tribo/paper_controller.h"

#include "../controller/anti_windup_f32.h"
#include "../friction/compensator_f32.h"
#include "../number/ranges.h"
#include "loop_f32.h"

#include <stddef.h>

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

/// Whether the sections are the paper's controller, number by number.
static bool is_papers(const tribo_controller_f32_config_t *config)
{
    const uint32_t each    = sizeof(tribo_biquad_f32_section_t) / sizeof(float);
    const uint32_t numbers = TRIBO_PAPER_CONTROLLER_SECTION_COUNT * each;
    const float   *papers  = &tribo_paper_controller_f32[0].b0;
    const float   *own     = &config->sections[0].b0;
    bool           same    = config->section_count == TRIBO_PAPER_CONTROLLER_SECTION_COUNT;
    for (uint32_t i = 0; i < numbers && same; i++)
    {
        same = own[i] == papers[i];
    }
    return same;
}

tribo_status_t tribo_force_loop_f32_init(tribo_force_loop_f32_params_t       *params,
                                         const tribo_force_loop_f32_config_t *config)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_force_loop_f32_params_t made   = {.input_max_n = config->input_max_n, .gain = config->gain};
    tribo_status_t                status = PARAMETERS_CHECK(tribo_loop_parameters, config);
    if (status == TRIBO_OK)
    {
        status = tribo_controller_f32_init(&made.controller, &config->controller);
    }
    if (status == TRIBO_OK && is_papers(&config->controller) &&
        magnitude(config->sample_time_s - TRIBO_PAPER_CONTROLLER_SAMPLE_TIME_S) > 1.0e-9f)
    {
        status = TRIBO_ERR_PAPER_SAMPLE_TIME;
    }
    if (status == TRIBO_OK)
    {
        status = tribo_compensator_f32_init(&made.compensator, &config->compensator, config->sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        *params = made;
    }
    return status;
}

void tribo_force_loop_f32_reset(tribo_force_loop_f32_state_t *state)
{
    force_loop_f32_activate(state, NULL);
    state->memory      = NULL;
    state->memory_seal = ~(uintptr_t)NULL;
    state->guard       = NULL;
    state->guard_seal  = ~(uintptr_t)NULL;
    state->fade        = 1.0f;
    state->friction_n  = 0.0f;
    state->bad_inputs  = 0;
    tribo_controller_f32_reset(&state->controller);
    tribo_compensator_f32_reset(&state->compensator);
}

/// The guard, if any: judges the friction added in this tick, and sets the fade for the next. Returns f^ of the last tick,
/// faded.
static float guarded_friction(const tribo_force_loop_f32_params_t *params,
                              tribo_force_loop_f32_state_t        *state,
                              const tribo_force_loop_f32_tick_t   *tick,
                              float                                r_n,
                              float                                y_n)
{
    const float f      = force_loop_f32_faded(params, state);
    float       judged = 0.0f;
    if (params->method == NULL)
    {
        judged = params->gain * f;
    }
    else if (tick != NULL)
    {
        judged = tick->friction_n;
    }
    if (!loop_sealed(state->guard, state->guard_seal))
    {
        count(&state->bad_inputs); // the fade stays
        return f;
    }
    state->fade = 1.0f;
    if (state->guard != NULL)
    {
        const bool good = !force_loop_f32_bad(params, r_n, y_n);
        state->fade     = params->guard->step(params->guard, state->guard, r_n, y_n, judged, good);
    }
    return f;
}

// Fig. 9, for every method.
float tribo_force_loop_f32_step(const tribo_force_loop_f32_params_t *params,
                                tribo_force_loop_f32_state_t        *state,
                                float                                r_n,
                                float                                y_n,
                                tribo_force_loop_f32_signals_t      *signals)
{
    const tribo_force_loop_f32_method_t *const method = params->method; // null: the paper's

    tribo_force_loop_f32_functions_t functions;
    void *const                      memory = method != NULL ? force_loop_f32_memory(state) : NULL;
    if (memory != NULL)
    {
        method->functions(&functions);
    }

    tribo_force_loop_f32_signals_t        unseen;
    tribo_force_loop_f32_signals_t *const seen = signals != NULL ? signals : &unseen; // cppcheck-suppress uninitvar
    tribo_biquad_f32_outputs_t            nodes;

    // error, 0 for a bad input: u coasts on the controller's state
    float e = r_n - y_n;
    if (force_loop_f32_bad(params, r_n, y_n))
    {
        e = 0.0f;
        count(&state->bad_inputs);
    }
    if (state->active != params)
    {
        tribo_force_loop_f32_change(params, state, r_n, y_n, e);
    }
    if (memory != NULL)
    {
        e = functions.error(params, memory, r_n, y_n, force_loop_f32_fade(params, state));
    }
    else if (method != NULL && !loop_sealed(state->memory, state->memory_seal))
    {
        count(&state->bad_inputs);
    }
    float friction = state->friction_n;
    if (params->guard != NULL)
    {
        friction = guarded_friction(params, state, memory, r_n, y_n);
    }
    seen->e_n = e;

    // controller
    const tribo_controller_f32_params_t *const controller = &params->controller;

    const float v    = biquad_f32_output(&controller->cascade, &state->controller.cascade, e, &nodes);
    float       term = 0.0f;
    if (memory != NULL)
    {
        term = functions.term(params, memory, v);
    }
    else if (method == NULL)
    {
        term = params->gain * friction;
    }
    const float u         = controller_f32_apply(controller, &state->controller, e, v, term, &nodes, &seen->controller);
    seen->friction_term_n = term;

    // compensation
    if (state->active != params)
    {
        tribo_force_loop_f32_change_friction(params, state, seen->e_n, u);
    }
    if (method == NULL)
    {
        const float n     = compensator_f32_net_force(&params->compensator, &state->compensator, u);
        state->friction_n = compensator_f32_step(&params->compensator, &state->compensator, n, &seen->compensator);
    }
    else
    {
        seen->compensator = (tribo_compensator_f32_signals_t){.force_n = 0.0f};
        if (memory != NULL)
        {
            functions.after(params, memory, seen->controller.v_n, u, seen);
        }
    }
    return u;
}
