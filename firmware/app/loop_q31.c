#include "app/loop.h"

#include <stddef.h>

const char *loop_arithmetic(void)
{
    return "q31";
}

void loop_reset(loop_state_t *state)
{
    tribo_force_loop_q31_reset(state);
}

loop_force_t loop_step(const loop_params_t *params,
                       loop_state_t        *state,
                       loop_force_t         r,
                       loop_force_t         y,
                       loop_signals_t      *signals)
{
    return tribo_force_loop_q31_step_with_signals(params, state, r, y, signals);
}

loop_force_t loop_force(int32_t part, float full_scale_n)
{
    (void)full_scale_n;
    return part;
}

int32_t loop_part(loop_force_t x, float full_scale_n)
{
    (void)full_scale_n;
    return x;
}

bool loop_is_nan(loop_force_t x)
{
    (void)x;
    return false;
}

bool loop_is_credible(const loop_params_t *params, loop_force_t x)
{
    const int64_t end = params->input_end;
    return x >= -end && x < end;
}

loop_force_t loop_u_min(const loop_params_t *params)
{
    return params->controller.u_min;
}

loop_force_t loop_u_max(const loop_params_t *params)
{
    return params->controller.u_max;
}

uint32_t loop_word(loop_force_t x)
{
    return (uint32_t)x;
}

loop_force_t loop_from_word(uint32_t word)
{
    return (loop_force_t)word;
}

bool loop_is_limited(const loop_signals_t *signals)
{
    return signals->controller.limited;
}

void loop_words(const loop_signals_t *signals, uint32_t words[LOOP_WORDS])
{
    const tribo_friction_q31_signals_t *friction = &signals->compensator.friction;

    words[LOOP_WORD_BITS]        = (uint32_t)signals->controller.limited | (uint32_t)friction->relays << 1;
    words[LOOP_WORD_E]           = loop_word(signals->e);
    words[LOOP_WORD_CONTROLLER]  = loop_word(signals->controller.v);
    words[LOOP_WORD_FEEDFORWARD] = loop_word(signals->feedforward);
    words[LOOP_WORD_U]           = loop_word(signals->controller.u);
    words[LOOP_WORD_F_HAT]       = loop_word(signals->compensator.force);
    words[LOOP_WORD_N]           = loop_word(friction->n);
    words[LOOP_WORD_L]           = loop_word(friction->L);
    words[LOOP_WORD_RATE]        = loop_word(friction->rise);
    words[LOOP_WORD_FRICTION]    = loop_word(friction->f);
}

uint32_t loop_limited_ticks(const loop_state_t *state)
{
    return state->controller.limited_ticks;
}

uint32_t loop_bad_inputs(const loop_state_t *state)
{
    return state->bad_inputs;
}
