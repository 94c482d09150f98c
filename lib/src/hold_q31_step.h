// The parts of a tick in hold, for forces within +-2^29 units.

#ifndef TRIBO_HOLD_Q31_STEP_H
#define TRIBO_HOLD_Q31_STEP_H

#include "tribo/hold_q31.h"

#include "first_order_q31.h"
#include "limit_q31.h"
#include "play_q31_step.h"

#define HOLD_Q31_QUICK_CHANGES 4u
#define HOLD_Q31_TENTH         429496730u // Q32
#define HOLD_Q31_CHANGED_MIN   4295u      // 1e-6
#define HOLD_Q31_NOISE_MAX     (UINT32_C(1) << 31)
#define HOLD_Q31_SELDOM        2576980378u // Q32: deadband over the mean second difference, where y seldom changes
#define HOLD_Q31_ALWAYS        558345748u  // and where it always does

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

static inline void hold_q31_enter(tribo_hold_q31_state_t *state, int32_t u, int32_t f, int32_t way, int32_t y)
{
    state->active        = true;
    state->quick         = 0;
    state->since         = 0;
    state->play.position = u - f;
    state->play.way      = way;
    state->error         = 0;
    state->y[0]          = y;
    state->y[1]          = y;
    state->noise         = 0;
    state->changed       = 0;
}

/// Counts changes of side that follow one another quickly, and grows cautious.
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
            state->caution += tribo_q31_high(~state->caution, HOLD_Q31_TENTH);
        }
    }
}

static inline int32_t hold_q31_step(const tribo_hold_q31_params_t *params,
                                    tribo_hold_q31_state_t        *state,
                                    int32_t                        u,
                                    uint32_t                       positive,
                                    uint32_t                       negative)
{
    const uint32_t share  = tribo_q31_high(~state->caution, params->margin);
    const int32_t  before = state->play.way;
    const int32_t  below  = (int32_t)tribo_q31_high(positive, share);
    const int32_t  above  = (int32_t)tribo_q31_high(negative, share);
    (void)play_q31_step(&state->play, u, below, above);
    hold_q31_watch(params, state, state->play.way != before);
    return part_of_q31(u - state->play.position, params->gain);
}

/// A share of the way to 0 or 1, Q32.
static inline uint32_t hold_q31_share(uint32_t share, bool rises, uint32_t part)
{
    return rises ? share + tribo_q31_high(~share, part) : share - tribo_q31_high(share, part);
}

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

    // Over the ticks in which y changed, up to 2^24 units; none where it has not for long.
    const uint32_t mean = state->changed > HOLD_Q31_CHANGED_MIN ? ratio_q31(state->noise, state->changed) >> 7 : 0u;
    const int32_t  most =
        (int32_t)tribo_q31_high(mean,
                                HOLD_Q31_SELDOM - tribo_q31_high(state->changed, HOLD_Q31_SELDOM - HOLD_Q31_ALWAYS));
    return e - limit_q31(state->error, -most, most);
}

static inline void hold_q31_learned(const tribo_hold_q31_params_t *params,
                                    tribo_hold_q31_state_t        *state,
                                    uint32_t                       travel)
{
    const uint64_t part = tribo_q31_product(travel, params->caution_per_unit) >> 16;
    state->caution -= tribo_q31_high(state->caution, part < UINT32_MAX ? (uint32_t)part : UINT32_MAX);
}

#endif
