#include "tribo/controller_q31.h"

#include "controller_q31_kernel.h"

void tribo_controller_q31_reset(tribo_controller_q31_state_t *state)
{
    tribo_biquad_q31_reset(&state->cascade);
    state->limited_ticks = 0;
}

// Out of line, so that neither takes the other's stack.

static TRIBO_OUT_OF_LINE TRIBO_ALL_INLINE int32_t step_of_pair(const tribo_controller_q31_params_t *params,
                                                               tribo_controller_q31_state_t        *state,
                                                               int32_t                              e,
                                                               int32_t                              feedforward,
                                                               tribo_controller_q31_signals_t      *signals)
{
    return controller_q31_kernel(params, state, e, feedforward, signals);
}

static TRIBO_OUT_OF_LINE int32_t step_of_any(const tribo_controller_q31_params_t *params,
                                             tribo_controller_q31_state_t        *state,
                                             int32_t                              e,
                                             int32_t                              feedforward,
                                             tribo_controller_q31_signals_t      *signals)
{
    const uint32_t             last = params->cascade.count - 1u;
    tribo_biquad_q31_outputs_t outputs;
    (void)tribo_biquad_q31_output(&params->cascade, &state->cascade, e, &outputs);
    const controller_q31_limited_t l =
        controller_q31_limit(params, state, outputs.y[last], params->cascade.section[last].scale, feedforward);
    tribo_biquad_q31_advance(&params->cascade, &state->cascade, &outputs, l.correction);
    *signals = (tribo_controller_q31_signals_t){.v = l.v, .u = l.u, .limited = l.limited};
    return l.u;
}

int32_t tribo_controller_q31_step(const tribo_controller_q31_params_t *params,
                                  tribo_controller_q31_state_t        *state,
                                  int32_t                              e,
                                  int32_t                              feedforward,
                                  tribo_controller_q31_signals_t      *signals)
{
    return TRIBO_FAST_WAY(params->cascade.pair_power != 0) ? step_of_pair(params, state, e, feedforward, signals)
                                                           : step_of_any(params, state, e, feedforward, signals);
}

void tribo_controller_q31_change(const tribo_controller_q31_params_t *from,
                                 const tribo_controller_q31_params_t *to,
                                 tribo_controller_q31_state_t        *state,
                                 int32_t                              e,
                                 int32_t                              offset)
{
    tribo_biquad_q31_change(&from->cascade, &to->cascade, &state->cascade, e, offset);
}
