// The parts of a tick in hold, for inputs that are known to be good.

#ifndef TRIBO_HOLD_F32_STEP_H
#define TRIBO_HOLD_F32_STEP_H

#include "tribo/hold_f32.h"

#include "first_order_f32.h"
#include "limit_f32.h"
#include "play_f32_step.h"

#define HOLD_F32_QUICK_CHANGES 4u
#define HOLD_F32_CHANGED_MIN   1.0e-6f
#define HOLD_F32_SELDOM        0.6f  // deadband over the mean second difference of y, where y seldom changes
#define HOLD_F32_ALWAYS        0.13f // and where it always does: 0.1 lets F slip within minutes at 0.3 mN of noise

static inline bool hold_f32_stands(const tribo_hold_f32_params_t *params,
                                   tribo_hold_f32_state_t        *state,
                                   float                          reference,
                                   float                          half,
                                   bool                           step)
{
    const uint32_t still = state->still;
    if (magnitude(reference - state->anchor_n) > half)
    {
        state->anchor_n = reference;
        state->still    = state->active && step ? still : 0u;
    }
    else if (still < params->still_ticks)
    {
        state->still = still + 1u;
    }
    return params->on && state->still >= params->still_ticks;
}

static inline void hold_f32_enter(tribo_hold_f32_state_t *state, float u, float f, int32_t way, float y)
{
    state->active          = true;
    state->quick           = 0;
    state->since           = 0;
    state->play.position_n = u - f;
    state->play.way        = way;
    state->error_n         = 0.0f;
    state->y_n[0]          = y;
    state->y_n[1]          = y;
    state->noise_n         = 0.0f;
    state->changed         = 0.0f;
}

/// Counts changes of side that follow one another quickly, and grows cautious.
static inline void hold_f32_watch(const tribo_hold_f32_params_t *params, tribo_hold_f32_state_t *state, bool changes)
{
    const bool quick = state->since < params->quick_ticks;
    state->since     = changes ? 0u : state->since + (quick ? 1u : 0u);
    if (changes)
    {
        const uint32_t run = quick ? state->quick + 1u : 0u;
        state->quick       = (uint8_t)(run < HOLD_F32_QUICK_CHANGES ? run : HOLD_F32_QUICK_CHANGES);
        if (state->quick == HOLD_F32_QUICK_CHANGES)
        {
            state->caution += 0.1f * (1.0f - state->caution);
        }
    }
}

static inline float hold_f32_step(const tribo_hold_f32_params_t *params,
                                  tribo_hold_f32_state_t        *state,
                                  float                          u,
                                  float                          positive,
                                  float                          negative)
{
    const float   share  = (1.0f - state->caution) * params->margin;
    const int32_t before = state->play.way;
    (void)play_f32_step(&state->play, u, share * positive, share * negative);
    hold_f32_watch(params, state, state->play.way != before);
    return params->gain * (u - state->play.position_n);
}

static inline float hold_f32_deadband(const tribo_hold_f32_params_t *params,
                                      tribo_hold_f32_state_t        *state,
                                      float                          e,
                                      float                          y)
{
    const float change = y - state->y_n[0];
    const float second = change - (state->y_n[0] - state->y_n[1]);
    const bool  moves  = change != 0.0f;
    state->noise_n     = first_order_f32_step(state->noise_n, moves ? magnitude(second) : 0.0f, params->deadband_part);
    state->changed     = first_order_f32_step(state->changed, moves ? 1.0f : 0.0f, params->deadband_part);
    state->error_n     = first_order_f32_step(state->error_n, e, params->deadband_part);
    state->y_n[1]      = state->y_n[0];
    state->y_n[0]      = y;

    // Over the ticks in which y changed; none where it has not for long.
    const float mean = state->changed > HOLD_F32_CHANGED_MIN ? state->noise_n / state->changed : 0.0f;
    return e -
           bound_f32(state->error_n, mean * (HOLD_F32_SELDOM - (HOLD_F32_SELDOM - HOLD_F32_ALWAYS) * state->changed));
}

static inline void hold_f32_learned(const tribo_hold_f32_params_t *params, tribo_hold_f32_state_t *state, float travel)
{
    const float part = travel * params->caution_per_n;
    state->caution -= (part < 1.0f ? part : 1.0f) * state->caution;
}

#endif
