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

/// L+ and L-: linear between the points, clamped at both ends. Visits every point, whatever the force.
static void look_up(const tribo_friction_q31_params_t *params, uint32_t load, uint32_t L[2])
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

/// L by an affine law, whatever its slope.
static uint32_t steep(const tribo_friction_q31_params_t *params, uint32_t side, uint32_t load)
{
    const uint64_t L = friction_q31_affine(&params->law[side], load) + tribo_q31_product(params->law_whole[side], load);
    return L < TRIBO_Q31_MAX ? (uint32_t)L : (uint32_t)TRIBO_Q31_MAX;
}

friction_q31_levels_t tribo_friction_q31_levels(const tribo_friction_q31_params_t *params,
                                                uint32_t                           load,
                                                uint32_t                           side,
                                                uint32_t                           side_before)
{
    uint32_t L[2];
    if (params->table != NULL)
    {
        look_up(params, load, L);
    }
    else
    {
        L[0] = steep(params, 0, load);
        L[1] = steep(params, 1, load);
    }
    return (friction_q31_levels_t){.L = L[side], .reset = tribo_q31_high(params->reset_level, L[side_before])};
}

int32_t tribo_friction_q31_step(const tribo_friction_q31_params_t *params,
                                tribo_friction_q31_state_t        *state,
                                int32_t                            u,
                                int32_t                            force,
                                tribo_friction_q31_signals_t      *signals)
{
    const int32_t n = tribo_q31_balance(u, force, params->gravity, &state->saturated);
    return friction_q31_kernel(params, state, n, force, signals, true);
}
