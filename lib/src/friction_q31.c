#include "tribo/friction_q31.h"

#include "friction_q31_kernel.h"

void tribo_friction_q31_reset(tribo_friction_q31_state_t *state)
{
    state->n         = 0;
    state->saturated = 0;
    tribo_relay_reset(&state->relay);
}

static uint32_t at_part(int32_t lower, int32_t upper, uint32_t part)
{
    return (uint32_t)(lower + ((int64_t)(upper - lower) * part >> 31));
}

/// Linear between the points, clamped at both ends. Visits every point, whatever the force.
void tribo_friction_q31_look_up(const tribo_friction_q31_params_t *params, uint32_t load, uint32_t L[2])
{
    const uint32_t length = params->table_length;
    uint32_t       below  = 0; // points at or below the force
    for (uint32_t i = 0; i < length; i++)
    {
        below += load >= (uint32_t)params->table[i].force;
    }
    const tribo_breakaway_point_q31_t *lower = &params->table[below > 0u ? below - 1u : 0u];
    const tribo_breakaway_point_q31_t *upper = &params->table[below < length ? below : length - 1u];

    const uint32_t span = (uint32_t)(upper->force - lower->force);
    const uint32_t part = span > 0u ? tribo_q31_ratio(load - (uint32_t)lower->force, span) : 0u;
    L[0]                = at_part(lower->positive, upper->positive, part);
    L[1]                = at_part(lower->negative, upper->negative, part);
}

int32_t tribo_friction_q31_step(const tribo_friction_q31_params_t *params,
                                tribo_friction_q31_state_t        *state,
                                int32_t                            u,
                                int32_t                            force,
                                tribo_friction_q31_signals_t      *signals)
{
    const int32_t n = tribo_q31_saturate((int64_t)u - force + params->gravity, &state->saturated);
    return friction_q31_kernel(params, state, n, force, signals, true);
}
