// Hold in fixed point; hold_f32.h has the equations. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_HOLD_Q31_H
#define TRIBO_FEEDFORWARD_HOLD_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"
#include "bank_q31.h"
#include "constants.h"
#include "feedback.h"

static inline void hold_q31_start(tribo_feedforward_hold_q31_state_t *hold, int32_t at)
{
    hold->anchor  = at;
    hold->error   = 0;
    hold->noise   = 0;
    hold->changed = UINT32_MAX;
    hold->still   = 0;
}

static inline void hold_q31_follow(const tribo_feedforward_q31_params_t *params,
                                   tribo_feedforward_hold_q31_state_t   *hold,
                                   int32_t                               e)
{
    hold->error = first_order_q31_step(hold->error, e, params->deadband_part);
}

static inline bool hold_q31_is_still(const tribo_feedforward_q31_params_t     *params,
                                     const tribo_feedforward_hold_q31_state_t *hold)
{
    return params->still_ticks > 0u && hold->still >= params->still_ticks;
}

static inline bool hold_q31_stands(const tribo_feedforward_q31_params_t *params,
                                   tribo_feedforward_q31_state_t        *state,
                                   uint32_t                              half,
                                   bool                                  step)
{
    tribo_feedforward_hold_q31_state_t *const hold  = &state->hold;
    const int32_t                             moved = difference_q31(state->reached, hold->anchor);
    if (tribo_q31_magnitude(moved) > half)
    {
        const bool stays = state->mode == TRIBO_FEEDFORWARD_HOLD && step;
        hold->error      = stays ? moved : hold->error;
        hold->anchor     = state->reached;
        hold->still      = stays ? hold->still : 0u;
        hold->rests      = false;
    }
    else if (hold->still < params->still_ticks)
    {
        hold->still++;
    }
    return hold_q31_is_still(params, hold) || feedback_is_on(&state->monitor.feedback);
}

static inline int32_t hold_q31_friction(int32_t net, int32_t B)
{
    return part_of_q31(limit_q31(net, -B, B), BANK_Q31_Q32(FEEDFORWARD_HOLD_GAIN));
}

static inline void hold_q31_enter(tribo_feedforward_q31_state_t *state, int32_t f)
{
    tribo_feedforward_hold_q31_state_t *const hold = &state->hold;

    hold->side             = state->sign;
    hold->since            = 0;
    hold->quick            = 0;
    hold->rests            = false;
    state->offset          = sum_q31(state->offset, f - state->f);
    state->learning.sample = 0;
    state->mode            = TRIBO_FEEDFORWARD_HOLD;
}

static inline void hold_q31_watch(const tribo_feedforward_q31_params_t *params,
                                  tribo_feedforward_hold_q31_state_t   *hold,
                                  bool                                  changes)
{
    const bool quick = hold->since < params->quick_ticks;
    if (changes)
    {
        const uint32_t run = quick ? hold->quick + 1u : 0u;
        hold->quick        = (uint8_t)(run < FEEDFORWARD_QUICK_CHANGES ? run : FEEDFORWARD_QUICK_CHANGES);
        if (hold->quick == FEEDFORWARD_QUICK_CHANGES)
        {
            hold->extra_margin += tribo_q31_high(~hold->extra_margin, BANK_Q31_Q32(FEEDFORWARD_MARGIN_STEP));
        }
        hold->since = 0;
    }
    else if (quick)
    {
        hold->since++;
    }
}

static inline void hold_q31_turn(const tribo_feedforward_q31_params_t *params,
                                 tribo_feedforward_hold_q31_state_t   *hold,
                                 int32_t                               net,
                                 int32_t                               B)
{
    const int8_t side = (int8_t)(tribo_q31_magnitude(net) > (uint32_t)B ? bank_q31_sign(net) : hold->side);
    hold_q31_watch(params, hold, side != hold->side);
    hold->side = side;
}

static inline int32_t hold_q31_deadband(const tribo_feedforward_q31_params_t *params,
                                        tribo_feedforward_hold_q31_state_t   *hold,
                                        int32_t                               e,
                                        int32_t                               y,
                                        const int32_t                         last[2],
                                        uint32_t                              noise)
{
    const uint32_t part    = params->deadband_part;
    const bool     changes = y != last[0];
    const uint32_t second  = bank_q31_second(y, last);
    hold->changed          = bank_q31_pass(hold->changed, changes ? UINT32_MAX : 0u, part);
    hold->noise            = changes ? bank_q31_pass(hold->noise, second, part) : hold->noise;

    const uint32_t seldom = tribo_q31_high(hold->noise, ~hold->changed);
    const uint32_t rare   = tribo_q31_high(seldom, BANK_Q31_Q32(FEEDFORWARD_DEADBAND_RARE)) >> 8;
    const uint32_t all    = tribo_q31_high(noise, BANK_Q31_Q32(FEEDFORWARD_DEADBAND_ALL)) >> 8;
    const uint32_t least  = hold->rests ? (uint32_t)(2.0f * FEEDFORWARD_REST) * all / 2u : all;
    const int32_t  most   = (int32_t)(all + rare);
    hold->rests           = hold_q31_is_still(params, hold) && tribo_q31_magnitude(hold->error) < least;
    return difference_q31(e, limit_q31(hold->error, -most, most));
}

#endif
