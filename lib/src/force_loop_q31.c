#include "tribo/force_loop_q31.h"

#include <stdbool.h>
#include <stddef.h>

void tribo_force_loop_q31_reset(tribo_force_loop_q31_state_t *state)
{
    state->active     = NULL;
    state->friction   = 0;
    state->bad_inputs = 0;
    state->saturated  = 0;
    tribo_controller_q31_reset(&state->controller);
    tribo_compensator_q31_reset(&state->compensator);
}

/// What friction f adds to u, Q31.
static inline int32_t feedforward(const tribo_force_loop_q31_params_t *params, int32_t f, uint32_t *saturated)
{
    return tribo_q31_saturate(tribo_q31_multiply(params->gain, f) >> 29, saturated);
}

/// What f^ of this tick is under params `p`, the state left alone.
static int32_t friction_under(const tribo_force_loop_q31_params_t *p,
                              const tribo_force_loop_q31_state_t  *state,
                              int32_t                              u)
{
    tribo_compensator_q31_state_t   copy = state->compensator;
    tribo_compensator_q31_signals_t unused;
    return tribo_compensator_q31_step(&p->compensator, &copy, u, &unused);
}

// Out of line: its copy of the compensator's state shall not be on the stack of every tick.
#ifdef __GNUC__
#define TRIBO_OUT_OF_LINE __attribute__((noinline))
#else
#define TRIBO_OUT_OF_LINE
#endif

/// The tick that changes params: as a plain tick, with the controller making up for what the other gain and the other
/// friction model would add to u in one jump.
static TRIBO_OUT_OF_LINE int32_t changing_tick(const tribo_force_loop_q31_params_t *params,
                                               tribo_force_loop_q31_state_t        *state,
                                               tribo_force_loop_q31_signals_t      *signals)
{
    const tribo_force_loop_q31_params_t *from = state->active;
    const int32_t                        e    = signals->e;

    uint32_t *const saturated = &state->saturated;
    const int64_t   gain_jump = (int64_t)signals->feedforward - feedforward(from, state->friction, saturated);
    tribo_controller_q31_change(&from->controller,
                                &params->controller,
                                &state->controller,
                                e,
                                tribo_q31_saturate(-gain_jump, saturated));
    const int32_t u = tribo_controller_q31_step(&params->controller,
                                                &state->controller,
                                                e,
                                                signals->feedforward,
                                                &signals->controller);

    const int32_t old_friction = friction_under(from, state, u);
    state->friction = tribo_compensator_q31_step(&params->compensator, &state->compensator, u, &signals->compensator);

    const int64_t model_jump =
        (int64_t)feedforward(params, state->friction, saturated) - feedforward(params, old_friction, saturated);
    tribo_controller_q31_change(&params->controller,
                                &params->controller,
                                &state->controller,
                                e,
                                tribo_q31_saturate(-model_jump, saturated));
    return u;
}

int32_t tribo_force_loop_q31_step(const tribo_force_loop_q31_params_t *params,
                                  tribo_force_loop_q31_state_t        *state,
                                  int32_t                              r,
                                  int32_t                              y,
                                  tribo_force_loop_q31_signals_t      *signals)
{
    const uint32_t max = (uint32_t)params->input_max;
    const bool     bad = tribo_q31_magnitude(r) > max || tribo_q31_magnitude(y) > max;
    if (bad)
    {
        tribo_q31_count(&state->bad_inputs);
    }
    signals->e           = bad ? 0 : tribo_q31_saturate((int64_t)r - y, &state->saturated);
    signals->feedforward = feedforward(params, state->friction, &state->saturated);

    int32_t u;
    if (state->active == params || state->active == NULL)
    {
        u = tribo_controller_q31_step(&params->controller,
                                      &state->controller,
                                      signals->e,
                                      signals->feedforward,
                                      &signals->controller);
        state->friction =
            tribo_compensator_q31_step(&params->compensator, &state->compensator, u, &signals->compensator);
    }
    else
    {
        u = changing_tick(params, state, signals);
    }
    state->active = params;
    return u;
}
