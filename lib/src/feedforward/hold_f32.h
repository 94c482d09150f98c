// Hold, single precision: feedback of friction while the reference stands.
//
// A stuck step or a moving environment requires motion that the reference does not announce. Friction is then fed back, as in
// the paper, with a play in place of its arm and relays:
//
//     force = min(u + B-, max(u - B+, force))      the arm's force, which follows u beyond breakaway B
//     f     = gain (u - force)
//
// u is that of the last tick, and B the learned L less a margin, so that the loop's gain through it stays below 1. If the play
// chatters nevertheless, e.g. where breakaway is much smaller than learned, the margin grows: after four changes of sign within
// quick_time_s of one another, extra margin += (1 - extra margin)/10 at each. Learning reduces it again.
//
// A deadband keeps the controller from following its own sensor's noise. It subtracts the low-pass filtered error, up to a
// fraction of the mean second difference of y. The fraction is smaller where y changes in every tick (noise that averages out)
// than where it seldom changes (a coarse converter).
// No loops, one division. Not synchronized: one state, one tick. All inputs are finite; a breakaway is 0 or more.

#ifndef TRIBO_FEEDFORWARD_HOLD_F32_H
#define TRIBO_FEEDFORWARD_HOLD_F32_H

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

#include "../number/first_order_f32.h"
#include "play_f32.h"

/// The defaults of the design, for forces about 1 N.
tribo_hold_f32_config_t tribo_hold_f32_default(void);

/// Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME or that of a row of TRIBO_HOLD_PARAMETERS. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_hold_f32_init(tribo_hold_f32_params_t       *params,
                                   const tribo_hold_f32_config_t *config,
                                   float                          sample_time_s);

#define HOLD_F32_QUICK_CHANGES 4u
#define HOLD_F32_CHANGED_MIN   1.0e-6f
#define HOLD_F32_SELDOM        0.6f  // deadband over the mean second difference of y, where y seldom changes
#define HOLD_F32_ALWAYS        0.13f // and where it always changes: 0.1 lets F slip within minutes at 0.3 mN of noise

/// Not in a hold, at 0 N, without extra margin.
static inline void hold_f32_reset(tribo_hold_f32_state_t *state)
{
    *state = (tribo_hold_f32_state_t){.active = false};
}

/// True if the reference stands: it has stayed within +-half of one value for the still time. In a hold its step counts as
/// standing.
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

/// Begins a hold from friction `f` and `u` of the last tick, the direction `sign`, and the reading `y`.
static inline void hold_f32_enter(tribo_hold_f32_state_t *state, float u, float f, int32_t sign, float y)
{
    state->active          = true;
    state->quick           = 0;
    state->since           = 0;
    state->play.position_n = u - f;
    state->play.sign       = sign;
    state->error_n         = 0.0f;
    state->y_n[0]          = y;
    state->y_n[1]          = y;
    state->noise_n         = 0.0f;
    state->changed         = 0.0f;
}

/// Counts quick successive changes of sign, and increases the margin.
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
            state->extra_margin += 0.1f * (1.0f - state->extra_margin);
        }
    }
}

/// Friction to add in this tick, from `u` of the last one and the learned breakaway of both directions.
static inline float hold_f32_step(const tribo_hold_f32_params_t *params,
                                  tribo_hold_f32_state_t        *state,
                                  float                          u,
                                  float                          positive,
                                  float                          negative)
{
    const float   fade   = (1.0f - state->extra_margin) * params->margin;
    const int32_t before = state->play.sign;
    (void)play_f32_step(&state->play, u, fade * positive, fade * negative);
    hold_f32_watch(params, state, state->play.sign != before);
    return params->gain * (u - state->play.position_n);
}

/// The error `e` less the deadband.
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

    // Over the ticks in which y changed; 0 if the last change is long ago.
    const float mean = state->changed > HOLD_F32_CHANGED_MIN ? state->noise_n / state->changed : 0.0f;
    return e -
           bound_f32(state->error_n, mean * (HOLD_F32_SELDOM - (HOLD_F32_SELDOM - HOLD_F32_ALWAYS) * state->changed));
}

/// Shrinks the extra margin by learning from `travel` of slide, 0 or more.
static inline void hold_f32_learned(const tribo_hold_f32_params_t *params, tribo_hold_f32_state_t *state, float travel)
{
    const float part = travel * params->extra_margin_per_n;
    state->extra_margin -= (part < 1.0f ? part : 1.0f) * state->extra_margin;
}

#endif
