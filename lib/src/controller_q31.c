#include "tribo/controller_q31.h"

void tribo_controller_q31_reset(tribo_controller_q31_state_t *state)
{
    tribo_biquad_q31_reset(&state->cascade);
    state->limited_ticks = 0;
}

int32_t tribo_controller_q31_step(const tribo_controller_q31_params_t *params,
                                  tribo_controller_q31_state_t        *state,
                                  int32_t                              e,
                                  int32_t                              feedforward,
                                  tribo_controller_q31_signals_t      *signals)
{
    const int64_t v = tribo_biquad_q31_output(&params->cascade, &state->cascade, e);

    const int64_t wanted  = v + feedforward;
    const int64_t above   = wanted > params->u_min ? wanted : params->u_min;
    const int64_t u       = above < params->u_max ? above : params->u_max;
    const bool    limited = u != wanted;
    if (limited)
    {
        tribo_q31_count(&state->limited_ticks);
    }
    const uint32_t scale = params->cascade.section[params->cascade.count - 1u].scale;
    const int32_t  taken = tribo_q31_saturate((u - wanted) >> scale, &state->cascade.saturated);
    const int64_t  back  = tribo_q31_multiply(taken, params->anti_windup) >> params->anti_windup_shift;
    tribo_biquad_q31_advance(&params->cascade, &state->cascade, tribo_q31_saturate(back, &state->cascade.saturated));

    uint32_t only_for_the_log = 0;
    signals->v                = tribo_q31_saturate(v, &only_for_the_log);
    signals->u                = (int32_t)u;
    signals->limited          = limited;
    return (int32_t)u;
}

void tribo_controller_q31_change(const tribo_controller_q31_params_t *from,
                                 const tribo_controller_q31_params_t *to,
                                 tribo_controller_q31_state_t        *state,
                                 int32_t                              e,
                                 int32_t                              offset)
{
    tribo_biquad_q31_change(&from->cascade, &to->cascade, &state->cascade, e, offset);
}
