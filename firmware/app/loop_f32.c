#include "app/loop.h"

#include <string.h>

const char *loop_arithmetic(void)
{
    return "f32";
}

void loop_reset(loop_state_t *state)
{
    tribo_force_loop_f32_reset(state);
}

loop_force_t loop_step(const loop_params_t *params,
                       loop_state_t        *state,
                       loop_force_t         r,
                       loop_force_t         y,
                       loop_signals_t      *signals)
{
    return tribo_force_loop_f32_step_with_signals(params, state, r, y, signals);
}

loop_force_t loop_force(int32_t part, float full_scale_n)
{
    return (float)part * (full_scale_n * (1.0f / 2147483648.0f));
}

int32_t loop_part(loop_force_t x, float full_scale_n)
{
    const float part = x / full_scale_n * 2147483648.0f;
    return part >= 2147483648.0f ? INT32_MAX : part <= -2147483648.0f ? INT32_MIN : (int32_t)part;
}

bool loop_is_nan(loop_force_t x)
{
    return (loop_word(x) & 0x7fffffffu) > 0x7f800000u;
}

bool loop_is_credible(const loop_params_t *params, loop_force_t x)
{
    return loop_word(x) << 1 < params->input_end;
}

loop_force_t loop_u_min(const loop_params_t *params)
{
    return params->controller.u_min_n;
}

loop_force_t loop_u_max(const loop_params_t *params)
{
    return params->controller.u_max_n;
}

uint32_t loop_word(loop_force_t x)
{
    uint32_t word;
    memcpy(&word, &x, sizeof word);
    return word;
}

loop_force_t loop_from_word(uint32_t word)
{
    loop_force_t x;
    memcpy(&x, &word, sizeof x);
    return x;
}

bool loop_is_limited(const loop_signals_t *signals)
{
    return signals->controller.limited;
}

void loop_words(const loop_signals_t *signals, uint32_t words[LOOP_WORDS])
{
    const tribo_friction_f32_signals_t *friction = &signals->compensator.friction;

    words[LOOP_WORD_BITS]        = (uint32_t)signals->controller.limited | (uint32_t)friction->relays << 1;
    words[LOOP_WORD_E]           = loop_word(signals->e_n);
    words[LOOP_WORD_CONTROLLER]  = loop_word(signals->controller.v_n);
    words[LOOP_WORD_FEEDFORWARD] = loop_word(signals->feedforward_n);
    words[LOOP_WORD_U]           = loop_word(signals->controller.u_n);
    words[LOOP_WORD_F_HAT]       = loop_word(signals->compensator.force_n);
    words[LOOP_WORD_N]           = loop_word(friction->n_n);
    words[LOOP_WORD_L]           = loop_word(friction->L_n);
    words[LOOP_WORD_RATE]        = loop_word(friction->v_n_per_s);
    words[LOOP_WORD_FRICTION]    = loop_word(friction->f_n);
}

uint32_t loop_limited_ticks(const loop_state_t *state)
{
    return state->controller.limited_ticks;
}

uint32_t loop_bad_inputs(const loop_state_t *state)
{
    return state->bad_inputs;
}
