// Hold, single precision: feedback of friction, steps 4 (stands), 7 and 8 of docs/feedforward.md.
//
// A stuck step or a moving environment requires motion that the reference does not announce. Friction is then fed back, as in
// the paper, with what is measured in place of its arm and relays: what u has beyond the arm's force, up to breakaway B.
// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_HOLD_F32_H
#define TRIBO_FEEDFORWARD_HOLD_F32_H

#include "tribo/feedforward_f32.h"

#include "../number/first_order_f32.h"
#include "bank_f32.h"
#include "constants.h"
#include "feedback.h"

static inline void hold_f32_start(tribo_feedforward_hold_f32_state_t *hold, float at)
{
    hold->anchor_n = at;
    hold->error_n  = 0.0f;
    hold->noise_n  = 0.0f;
    hold->changed  = 1.0f;
    hold->still    = 0;
}

/// Follows the error in every mode, so that a hold begins with what it is.
static inline void hold_f32_follow(const tribo_feedforward_f32_params_t *params,
                                   tribo_feedforward_hold_f32_state_t   *hold,
                                   float                                 e)
{
    const float error = first_order_f32_step(hold->error_n, e, params->deadband_part);
    hold->error_n     = exceeds(error, FEEDFORWARD_FORCE_MAX_N) ? 0.0f : error;
}

/// True if rs has stayed within +-half of one value for the still time. In a hold its step counts as standing.
static inline bool hold_f32_is_still(const tribo_feedforward_f32_params_t     *params,
                                     const tribo_feedforward_hold_f32_state_t *hold)
{
    return params->still_ticks > 0u && hold->still >= params->still_ticks;
}

/// True if r stands. Or if friction is fed back while r moves, as fed forward it did harm. In a hold a step ends a rest, and is the
/// error that is to come: else u would rest on, and b take the step.
static inline bool hold_f32_stands(const tribo_feedforward_f32_params_t *params,
                                   tribo_feedforward_f32_state_t        *state,
                                   float                                 half,
                                   bool                                  step)
{
    tribo_feedforward_hold_f32_state_t *const hold  = &state->hold;
    const float                               moved = state->reached_n - hold->anchor_n;
    if (!(magnitude(moved) <= half)) // true for NaN
    {
        const bool stays = state->mode == TRIBO_FEEDFORWARD_HOLD && step;
        hold->error_n    = stays ? moved : hold->error_n;
        hold->anchor_n   = state->reached_n;
        hold->still      = stays ? hold->still : 0u;
        hold->rests      = false;
    }
    else if (hold->still < params->still_ticks)
    {
        hold->still++;
    }
    return hold_f32_is_still(params, hold) || feedback_is_on(&state->monitor.feedback);
}

/// Begins a hold with friction `f`; b takes its change.
static inline void hold_f32_enter(tribo_feedforward_f32_state_t *state, float f)
{
    tribo_feedforward_hold_f32_state_t *const hold = &state->hold;

    hold->side  = state->sign;
    hold->since = 0;
    hold->quick = 0;
    hold->rests = false;
    state->offset_n += f - state->f_n;
    state->learning.sample_n = 0.0f;
    state->mode              = TRIBO_FEEDFORWARD_HOLD;
}

/// Counts quick successive changes of side, and increases the margin: a play that chatters, as breakaway is smaller than learned.
static inline void hold_f32_watch(const tribo_feedforward_f32_params_t *params,
                                  tribo_feedforward_hold_f32_state_t   *hold,
                                  bool                                  changes)
{
    const bool quick = hold->since < params->quick_ticks;
    if (changes)
    {
        const uint32_t run = quick ? hold->quick + 1u : 0u;
        hold->quick        = (uint8_t)(run < FEEDFORWARD_QUICK_CHANGES ? run : FEEDFORWARD_QUICK_CHANGES);
        hold->extra_margin +=
            hold->quick == FEEDFORWARD_QUICK_CHANGES ? FEEDFORWARD_MARGIN_STEP * (1.0f - hold->extra_margin) : 0.0f;
        hold->since = 0;
    }
    else if (quick)
    {
        hold->since++;
    }
}

/// f in a hold: a part of what friction balances as the arm sticks, `net`, up to `B`.
static inline float hold_f32_friction(float net, float B)
{
    return FEEDFORWARD_HOLD_GAIN * bound_f32(net, B);
}

/// The side of breakaway on which friction was last.
static inline void hold_f32_turn(const tribo_feedforward_f32_params_t *params,
                                 tribo_feedforward_hold_f32_state_t   *hold,
                                 float                                 net,
                                 float                                 B)
{
    const int8_t side = (int8_t)(magnitude(net) > B ? bank_f32_sign(net) : hold->side);
    hold_f32_watch(params, hold, side != hold->side);
    hold->side = side;
}

/// The error `e` less a deadband, so that the controller does not follow its own sensor's noise. Once the error is within that, u
/// rests, until the error has grown. `last` are y of the last two ticks,
/// `noise` is n_y, which a step does not raise: by one that it does u would rest where F is far off.
static inline float hold_f32_deadband(const tribo_feedforward_f32_params_t *params,
                                      tribo_feedforward_hold_f32_state_t   *hold,
                                      float                                 e,
                                      float                                 y,
                                      const float                           last[2],
                                      float                                 noise)
{
    const float part    = params->deadband_part;
    const bool  changes = y != last[0];
    const float second  = magnitude((y - last[0]) - (last[0] - last[1]));
    hold->changed       = first_order_f32_step(hold->changed, changes ? 1.0f : 0.0f, part);
    hold->noise_n       = changes ? first_order_f32_step(hold->noise_n, second, part) : hold->noise_n;
    const float all     = FEEDFORWARD_DEADBAND_ALL * noise;
    const float rare    = FEEDFORWARD_DEADBAND_RARE * (1.0f - hold->changed) * hold->noise_n;
    const float least   = hold->rests ? FEEDFORWARD_REST * all : all;
    hold->rests         = hold_f32_is_still(params, hold) && magnitude(hold->error_n) < least;
    return e - bound_f32(hold->error_n, all + rare);
}

#endif
