// Hold in fixed point; hold_f32.h has the equations.
//
// Forces are in one unit, within +-2^29 of them. Fractions are Q32; products are rounded towards zero, so mirrored forces give
// mirrored results. The deadband's filters stop short by less than 1/part units.
// No loops, one division of 32 bits. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_HOLD_Q31_H
#define TRIBO_FEEDFORWARD_HOLD_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_q31.h"

#include "../number/first_order_q31.h"
#include "play_q31.h"

/// Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE or a status of tribo_hold_f32_init; margin_travel_n is 1.25e-4 to 1e3 FS. Writes
/// nothing unless TRIBO_OK.
tribo_status_t tribo_hold_q31_init(tribo_hold_q31_params_t       *params,
                                   const tribo_hold_f32_config_t *config,
                                   float                          sample_time_s,
                                   float                          full_scale_n);

#define HOLD_Q31_QUICK_CHANGES 4u
#define HOLD_Q31_TENTH         429496730u // Q32
#define HOLD_Q31_CHANGED_MIN   4295u      // 1e-6
#define HOLD_Q31_NOISE_MAX     (UINT32_C(1) << 31)
#define HOLD_Q31_SELDOM        2576980378u // Q32: deadband over the mean second difference, where y seldom changes
#define HOLD_Q31_ALWAYS        558345748u  // and where it always changes

/// Not in a hold, at 0 N, without extra margin.
static inline void hold_q31_reset(tribo_hold_q31_state_t *state)
{
    *state = (tribo_hold_q31_state_t){.active = false};
}

/// True if the reference stands: it has stayed within +-half of one value for the still time. In a hold its step counts as
/// standing.
static inline bool hold_q31_stands(const tribo_hold_q31_params_t *params,
                                   tribo_hold_q31_state_t        *state,
                                   int32_t                        reference,
                                   uint32_t                       half,
                                   bool                           step)
{
    const uint32_t still = state->still;
    if (tribo_q31_magnitude(reference - state->anchor) > half)
    {
        state->anchor = reference;
        state->still  = state->active && step ? still : 0u;
    }
    else if (still < params->still_ticks)
    {
        state->still = still + 1u;
    }
    return params->on && state->still >= params->still_ticks;
}

/// Begins a hold from friction `f` and `u` of the last tick, the direction `sign`, and the reading `y`.
static inline void hold_q31_enter(tribo_hold_q31_state_t *state, int32_t u, int32_t f, int32_t sign, int32_t y)
{
    state->active        = true;
    state->quick         = 0;
    state->since         = 0;
    state->play.position = u - f;
    state->play.sign     = sign;
    state->error         = 0;
    state->y[0]          = y;
    state->y[1]          = y;
    state->noise         = 0;
    state->changed       = 0;
}

/// Counts quick successive changes of sign, and increases the margin.
static inline void hold_q31_watch(const tribo_hold_q31_params_t *params, tribo_hold_q31_state_t *state, bool changes)
{
    const bool quick = state->since < params->quick_ticks;
    state->since     = changes ? 0u : state->since + (quick ? 1u : 0u);
    if (changes)
    {
        const uint32_t run = quick ? state->quick + 1u : 0u;
        state->quick       = (uint8_t)(run < HOLD_Q31_QUICK_CHANGES ? run : HOLD_Q31_QUICK_CHANGES);
        if (state->quick == HOLD_Q31_QUICK_CHANGES)
        {
            state->extra_margin += tribo_q31_high(~state->extra_margin, HOLD_Q31_TENTH);
        }
    }
}

/// Friction to add in this tick, from `u` of the last one and the learned breakaway of both directions.
static inline int32_t hold_q31_step(const tribo_hold_q31_params_t *params,
                                    tribo_hold_q31_state_t        *state,
                                    int32_t                        u,
                                    uint32_t                       positive,
                                    uint32_t                       negative)
{
    const uint32_t fade   = tribo_q31_high(~state->extra_margin, params->margin);
    const int32_t  before = state->play.sign;
    const int32_t  below  = (int32_t)tribo_q31_high(positive, fade);
    const int32_t  above  = (int32_t)tribo_q31_high(negative, fade);
    (void)play_q31_step(&state->play, u, below, above);
    hold_q31_watch(params, state, state->play.sign != before);
    return part_of_q31(u - state->play.position, params->gain);
}

/// A low pass towards 0 or 1, Q32.
static inline uint32_t hold_q31_share(uint32_t fade, bool rises, uint32_t part)
{
    return rises ? fade + tribo_q31_high(~fade, part) : fade - tribo_q31_high(fade, part);
}

/// The error `e` less the deadband.
static inline int32_t hold_q31_deadband(const tribo_hold_q31_params_t *params,
                                        tribo_hold_q31_state_t        *state,
                                        int32_t                        e,
                                        int32_t                        y)
{
    // Second differences up to 2^31, which wrap to a number of the same magnitude.
    const int32_t  change = y - state->y[0];
    const uint32_t before = (uint32_t)(state->y[0] - state->y[1]);
    const uint32_t second = tribo_q31_magnitude((int32_t)((uint32_t)change - before));
    const uint32_t fine   = second < HOLD_Q31_NOISE_MAX >> 8 ? second << 8 : HOLD_Q31_NOISE_MAX;
    const bool     moves  = change != 0;
    const uint32_t noise  = moves ? fine : 0u;
    state->noise   = noise > state->noise ? state->noise + tribo_q31_high(noise - state->noise, params->deadband_part)
                                          : state->noise - tribo_q31_high(state->noise - noise, params->deadband_part);
    state->changed = hold_q31_share(state->changed, moves, params->deadband_part);
    state->error   = first_order_q31_step(state->error, e, params->deadband_part);
    state->y[1]    = state->y[0];
    state->y[0]    = y;

    // Over the ticks in which y changed, up to 2^24 units; 0 if the last change is long ago.
    const uint32_t mean = state->changed > HOLD_Q31_CHANGED_MIN ? ratio_q31(state->noise, state->changed) >> 7 : 0u;
    const int32_t  most =
        (int32_t)tribo_q31_high(mean,
                                HOLD_Q31_SELDOM - tribo_q31_high(state->changed, HOLD_Q31_SELDOM - HOLD_Q31_ALWAYS));
    return e - limit_q31(state->error, -most, most);
}

/// Shrinks the extra margin by learning from `travel` of slide, up to 2^20.
static inline void hold_q31_learned(const tribo_hold_q31_params_t *params,
                                    tribo_hold_q31_state_t        *state,
                                    uint32_t                       travel)
{
    const uint64_t part = tribo_q31_product(travel, params->extra_margin_per_unit) >> 16;
    state->extra_margin -= tribo_q31_high(state->extra_margin, part < UINT32_MAX ? (uint32_t)part : UINT32_MAX);
}

#endif
