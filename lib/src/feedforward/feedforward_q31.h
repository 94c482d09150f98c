// One tick of the feed-forward in its three parts. Forces are Q29 of full scale unless stated.

#ifndef TRIBO_FEEDFORWARD_FEEDFORWARD_Q31_H
#define TRIBO_FEEDFORWARD_FEEDFORWARD_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/friction_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"
#include "../paper/friction_q31.h"
#include "breakaway_learning_q31.h"
#include "friction_observer_q31.h"
#include "hold_q31.h"
#include "play_q31.h"
#include "reference_model_q31.h"

/// The next tick is the first, for a controller that starts at rest; learned values and counters stay.
void tribo_feedforward_q31_restart(tribo_feedforward_q31_state_t *state);

/// Like a restart, for a controller that is already running: the first tick adds `added`, Q31 (the sum of the previous method), to v, so
/// that u does not jump, and e is r - y.
void tribo_feedforward_q31_enter(tribo_feedforward_q31_state_t *state, int32_t added);

/// First call of a tick: reference `r` and reading `y` give the error for the controller, all Q31. `friction` gives the prior.
/// Cannot fail: an r beyond input_max counts as the last good one, such a y gives e = 0 and prevents learning; both are
/// counted. `signals` must not be null, in all three calls.
int32_t tribo_feedforward_q31_before(const tribo_feedforward_q31_params_t *params,
                                     const tribo_friction_q31_params_t    *friction,
                                     tribo_feedforward_q31_state_t        *state,
                                     int32_t                               r,
                                     int32_t                               y,
                                     tribo_feedforward_q31_signals_t      *signals);

/// Second call: returns the sum to add to the controller's output `v`, both Q31.
int32_t tribo_feedforward_q31_added(const tribo_feedforward_q31_params_t *params,
                                    tribo_feedforward_q31_state_t        *state,
                                    int32_t                               v,
                                    tribo_feedforward_q31_signals_t      *signals);

/// Last call, with the applied `u`, Q31, and whether it was limited.
void tribo_feedforward_q31_after(const tribo_feedforward_q31_params_t *params,
                                 const tribo_friction_q31_params_t    *friction,
                                 tribo_feedforward_q31_state_t        *state,
                                 int32_t                               v,
                                 int32_t                               u,
                                 bool                                  limited,
                                 tribo_feedforward_q31_signals_t      *signals);

#define FEEDFORWARD_Q31_FULL      (INT32_C(1) << 29) // FS; sigma = 1
#define FEEDFORWARD_Q31_NOISE_MAX (UINT32_C(1) << 31)

/// Q31 to Q29, mirrored for mirrored forces.
static inline int32_t feedforward_q31_inside(int32_t x)
{
    return x / 4;
}

/// Q29 to Q31, within full scale.
static inline int32_t feedforward_q31_outside(int32_t x)
{
    return 4 * limit_q31(x, 1 - FEEDFORWARD_Q31_FULL, FEEDFORWARD_Q31_FULL - 1);
}

/// Prior L in `direction` at `force`. Good forces are below FS.
static inline uint32_t feedforward_q31_prior(const tribo_friction_q31_params_t *friction,
                                             uint32_t                           direction,
                                             int32_t                            force)
{
    const uint32_t load = 4u * tribo_q31_magnitude(force); // Q31
    uint32_t       L    = friction_q31_affine(&friction->law[direction], load);
    if (!friction->is_shallow)
    {
        uint32_t both[2];
        tribo_friction_q31_look_up(friction, load, both);
        L = both[direction];
    }
    return L / 4u; // L is over 1e-6 FS and below FS
}

/// The index of a nonzero sign.
static inline uint32_t feedforward_q31_direction(int32_t sign)
{
    return sign < 0 ? TRIBO_BREAKAWAY_NEGATIVE : TRIBO_BREAKAWAY_POSITIVE;
}

/// Friction while sigma ramps from the old direction of r to the new one; exact at both ends.
static inline int32_t feedforward_q31_friction(const tribo_feedforward_q31_signals_t *signals, int32_t sigma)
{
    const int32_t along = signals->sign < 0 ? -sigma : sigma;
    int32_t       f     = (int32_t)signals->ahead.weighted;
    if (along != FEEDFORWARD_Q31_FULL)
    {
        const uint32_t done   = (uint32_t)(FEEDFORWARD_Q31_FULL + along); // Q30
        const uint32_t undone = (uint32_t)(FEEDFORWARD_Q31_FULL - along);
        f                     = (int32_t)(tribo_q31_product(done, signals->ahead.weighted) >> 30) -
            (int32_t)(tribo_q31_product(undone, signals->behind.weighted) >> 30);
    }
    return f * signals->sign;
}

/// b in Q29, rounded towards zero.
static inline int32_t feedforward_q31_offset(const tribo_feedforward_q31_state_t *state)
{
    const int32_t high = (int32_t)(uint32_t)((uint64_t)state->offset >> 32);
    return high + (int32_t)(high < 0 && (uint32_t)state->offset != 0u);
}

/// All states at rest at y; beside a running controller, the states that follow r at r.
static inline void feedforward_q31_start(tribo_feedforward_q31_state_t *state, int32_t r, int32_t y)
{
    const int32_t at     = state->entering ? r : y;
    state->running       = true;
    state->limited       = 0;
    state->r[0]          = r;
    state->r[1]          = r;
    state->noise         = 0;
    state->reached       = at;
    state->rate          = 0;
    state->sigma         = 0;
    state->offset        = 0;
    state->held[0]       = 0;
    state->held[1]       = 0;
    state->error         = 0;
    state->distance      = 0;
    state->u             = y;
    state->f             = 0;
    state->hold.active   = false; // the extra margin stays, like the learned law
    state->learning.slid = 0;     // a slide of the previous run does not count
    state->hold.still    = 0;
    state->hold.anchor   = at;
    play_q31_reset(&state->reversal, at);
    play_q31_reset(&state->slide, y);
    tribo_reference_model_q31_reset(&state->reference_model);
    tribo_friction_observer_q31_reset(&state->observer, y);
}

/// w_n from the mean second difference of r. Each tick counts at most four times the mean, so that reversals and steps are
/// not noise.
static inline uint32_t feedforward_q31_noise(const tribo_feedforward_q31_params_t *params,
                                             tribo_feedforward_q31_state_t        *state,
                                             int32_t                               r)
{
    // Up to 2^31, which wraps to a number of the same magnitude.
    const int32_t  change = difference_q31(r, state->r[0]);
    const uint32_t second = tribo_q31_magnitude(difference_q31(change, difference_q31(state->r[0], state->r[1])));
    const uint32_t fine   = second < FEEDFORWARD_Q31_NOISE_MAX >> 8 ? second << 8 : FEEDFORWARD_Q31_NOISE_MAX; // Q37
    const uint32_t mean   = state->noise;
    const uint32_t known =
        mean < FEEDFORWARD_Q31_NOISE_MAX >> 3 ? 4u * mean + params->noise_floor : FEEDFORWARD_Q31_NOISE_MAX;
    const uint32_t counts = fine < known ? fine : known;
    state->noise          = counts > mean ? mean + tribo_q31_high(counts - mean, params->noise_part)
                                          : mean - tribo_q31_high(mean - counts, params->noise_part);
    state->r[1]           = state->r[0];
    state->r[0]           = r;
    return (uint32_t)(tribo_q31_product(state->noise, params->noise_gain) >> 35);
}

/// Updates rs and its rate: rs follows r, but not further into a limit of u. Returns the move; above step it is a step.
static inline int32_t feedforward_q31_reach(const tribo_feedforward_q31_params_t *params,
                                            tribo_feedforward_q31_state_t        *state,
                                            int32_t                               r)
{
    int32_t change = r - state->reached;
    if (state->limited * change > 0)
    {
        change = 0;
    }
    const bool step = tribo_q31_magnitude(change) > (uint32_t)params->step;
    state->reached += change;
    state->rate = first_order_q31_step(state->rate, step ? 0 : change * 256, params->rate_part);
    return change;
}

/// Lead of lin before rs, within FS/2. A noisy r has an unreliable rate.
static inline int32_t feedforward_q31_ahead(const tribo_feedforward_q31_params_t *params,
                                            tribo_feedforward_q31_state_t        *state,
                                            uint32_t                              width)
{
    const uint32_t fade = 2u * ratio_q31(params->reversal, width); // Q32
    return part_of_q31(state->rate, tribo_q31_high(params->lead, fade)) * (int32_t)(UINT32_C(1) << params->lead_shift);
}

/// A force times the guard's fade.
static inline uint32_t feedforward_q31_left(const tribo_feedforward_q31_state_t *state, uint32_t force)
{
    return state->fade == UINT32_MAX ? force : tribo_q31_high(force, state->fade);
}

/// rs, for `direction`.
static inline tribo_breakaway_learning_q31_place_t feedforward_q31_place(const tribo_feedforward_q31_params_t *params,
                                                                         const tribo_friction_q31_params_t    *friction,
                                                                         const tribo_feedforward_q31_state_t  *state,
                                                                         uint32_t direction)
{
    return breakaway_learning_q31_place(&params->learning, feedforward_q31_prior(friction, direction, state->reached));
}

/// Learned L in `direction` at rs, with the guard's fade in its weight.
static inline tribo_breakaway_learning_q31_signals_t feedforward_q31_breakaway(
    const tribo_feedforward_q31_params_t       *params,
    const tribo_feedforward_q31_state_t        *state,
    uint32_t                                    direction,
    const tribo_breakaway_learning_q31_place_t *place)
{
    tribo_breakaway_learning_q31_signals_t L =
        breakaway_learning_q31_at(&params->learning, &state->learning, direction, place);
    L.weighted = feedforward_q31_left(state, L.weighted);
    return L;
}

/// Moves b by a force.
static inline void feedforward_q31_move_offset(tribo_feedforward_q31_state_t *state, int32_t by)
{
    state->offset += (int64_t)by * (INT64_C(1) << 32);
}

/// f while r moves: sigma ramps to the sign of r. `first`: first reversal since the start; `step`: reversal by a step of r.
static inline void feedforward_q31_follow(const tribo_feedforward_q31_params_t *params,
                                          tribo_feedforward_q31_state_t        *state,
                                          bool                                  first,
                                          bool                                  step,
                                          tribo_feedforward_q31_signals_t      *signals)
{
    const int32_t sign = signals->sign * FEEDFORWARD_Q31_FULL;
    state->offset -= tribo_q31_multiply(feedforward_q31_offset(state), params->offset_part);
    // The controller alone takes the first reversal and a step into a direction with little learned: f jumps, b cancels it.
    if (signals->turns && (first || (step && signals->ahead.relative_variance > UINT32_C(1) << 30)))
    {
        const int32_t f_before = feedforward_q31_friction(signals, state->sigma);
        state->sigma           = sign;
        feedforward_q31_move_offset(state, feedforward_q31_friction(signals, sign) - f_before);
        signals->turns = false;
    }
    const int32_t before = state->sigma;
    if (before != sign)
    {
        state->sigma = before + limit_q31(sign - before, -params->jump, params->jump);
    }
    signals->f = feedforward_q31_friction(signals, state->sigma);
    if (state->entering)
    {
        state->entry += 4 * (signals->f - feedforward_q31_friction(signals, before)); // the remaining ramp still acts
    }
}

/// f while r stands: stiction fed back.
static inline void feedforward_q31_hold(const tribo_feedforward_q31_params_t *params,
                                        tribo_feedforward_q31_state_t        *state,
                                        tribo_feedforward_q31_signals_t      *signals)
{
    const bool     falls    = signals->sign < 0;
    const uint32_t positive = feedforward_q31_left(state, falls ? signals->behind.L : signals->ahead.L);
    const uint32_t negative = feedforward_q31_left(state, falls ? signals->ahead.L : signals->behind.L);
    const bool     enters   = !state->hold.active;
    if (enters)
    {
        hold_q31_enter(&state->hold, state->u, state->f, signals->sign, signals->y);
    }
    signals->f = hold_q31_step(&params->hold, &state->hold, state->u, positive, negative);
    if (signals->y_good)
    {
        signals->error = hold_q31_deadband(&params->hold, &state->hold, signals->error, signals->y);
    }
    if (enters)
    {
        feedforward_q31_move_offset(state, signals->f - state->f);
    }
    state->sigma   = 0;
    signals->turns = false;
}

/// f in the first tick after a hold, chosen so that u continues.
static inline void feedforward_q31_leave(tribo_feedforward_q31_state_t *state, tribo_feedforward_q31_signals_t *signals)
{
    const int32_t  ahead     = (int32_t)signals->ahead.weighted;
    const int32_t  behind    = (int32_t)signals->behind.weighted;
    const uint32_t direction = feedforward_q31_direction(signals->sign);

    int32_t along = FEEDFORWARD_Q31_FULL;
    if (state->hold.play.sign != signals->sign)
    {
        // Between the L behind and the L ahead of r.
        const int32_t left = signals->sign * (state->u - signals->lin - state->held[direction]);
        const int32_t f    = limit_q31(left, -behind, ahead);
        along -= (int32_t)(ratio_q31((uint32_t)(ahead - f), (uint32_t)(ahead + behind)) / 2u);
    }
    state->sigma       = signals->sign * along;
    signals->f         = feedforward_q31_friction(signals, state->sigma);
    signals->turns     = false;
    signals->leaves    = true;
    state->hold.active = false;
}

static inline int32_t feedforward_q31_before(const tribo_feedforward_q31_params_t *params,
                                             const tribo_friction_q31_params_t    *friction,
                                             tribo_feedforward_q31_state_t        *state,
                                             int32_t                               r_q31,
                                             int32_t                               y_q31,
                                             tribo_feedforward_q31_signals_t      *signals)
{
    const bool bad_r = tribo_q31_magnitude(r_q31) > params->input_max;
    const bool bad_y = tribo_q31_magnitude(y_q31) > params->input_max;
    if (bad_r || bad_y)
    {
        tribo_q31_count(&state->bad_inputs);
    }
    const int32_t y = bad_y ? state->y : feedforward_q31_inside(y_q31);
    int32_t       r = bad_r ? state->r[0] : feedforward_q31_inside(r_q31);
    state->y        = y;
    if (!state->running)
    {
        r = bad_r && state->entering ? y : r; // the reference of the previous run is void
        feedforward_q31_start(state, r, y);
    }

    const uint32_t noise = feedforward_q31_noise(params, state, r);
    const int32_t  was   = state->reached;
    const int32_t  moved = feedforward_q31_reach(params, state, r);
    const bool     step  = tribo_q31_magnitude(moved) > (uint32_t)params->step;
    const uint32_t width = params->reversal + noise;
    const uint32_t half  = width / 2u;

    // Sign of r: of the last move of rs by more than the width.
    const int32_t before = state->reversal.sign;
    (void)play_q31_step(&state->reversal, state->reached, (int32_t)half, (int32_t)half);
    const int32_t sign   = state->reversal.sign;
    const bool    stands = hold_q31_stands(&params->hold, &state->hold, state->reached, half, step) && sign != 0;
    const bool    leaves = state->hold.active && !stands;

    const int32_t ahead = feedforward_q31_ahead(params, state, width);

    // Like y, the expected y belongs to the end of the last tick; it is stored relative to the rs of that tick.
    const int32_t error =
        bad_y ? 0
              : tribo_q31_add(difference_q31(was, y), state->reference_model.sensor, &state->reference_model.saturated);
    (void)reference_model_q31_step(&params->reference_model, &state->reference_model, moved, ahead);
    signals->error   = limit_q31(error, -FEEDFORWARD_Q31_FULL, FEEDFORWARD_Q31_FULL);
    signals->lin     = state->reached + ahead;
    signals->y       = y;
    signals->reached = state->reached;
    signals->sign    = (int8_t)sign;
    signals->turns   = sign != before;
    signals->leaves  = false;
    signals->y_good  = !bad_y;
    signals->r_good  = !bad_r;

    // The opposite L matters only during the ramp.
    const uint32_t direction = feedforward_q31_direction(sign);
    signals->place           = feedforward_q31_place(params, friction, state, direction);
    signals->ahead           = feedforward_q31_breakaway(params, state, direction, &signals->place);
    signals->behind          = (tribo_breakaway_learning_q31_signals_t){.L = 0};
    if (stands || state->sigma != sign * FEEDFORWARD_Q31_FULL)
    {
        const tribo_breakaway_learning_q31_place_t place =
            feedforward_q31_place(params, friction, state, 1u - direction);
        signals->behind = feedforward_q31_breakaway(params, state, 1u - direction, &place);
    }
    if (signals->turns)
    {
        tribo_breakaway_learning_q31_slide_ends(&params->learning,
                                                &state->learning,
                                                1u - direction,
                                                feedforward_q31_prior(friction, 1u - direction, state->reached));
    }
    if (stands)
    {
        feedforward_q31_hold(params, state, signals);
    }
    else if (leaves)
    {
        feedforward_q31_leave(state, signals);
    }
    else
    {
        feedforward_q31_follow(params, state, before == 0, step, signals);
    }
    state->f       = signals->f;
    signals->sigma = state->sigma;
    signals->e     = feedforward_q31_outside(signals->error);
    state->e       = signals->e;
    return signals->e;
}

static inline int32_t feedforward_q31_added(const tribo_feedforward_q31_params_t *params,
                                            tribo_feedforward_q31_state_t        *state,
                                            int32_t                               v_q31,
                                            tribo_feedforward_q31_signals_t      *signals)
{
    const int32_t wanted = signals->lin + signals->f;
    int64_t       b      = state->offset;
    if (signals->turns)
    {
        const int32_t held = state->held[feedforward_q31_direction(signals->sign)];
        b = (int64_t)(feedforward_q31_inside(v_q31) - held) * (INT64_C(1) << 32); // integral wound up during stiction
    }
    if (signals->leaves)
    {
        b = (int64_t)(wanted - state->u + feedforward_q31_inside(v_q31)) * (INT64_C(1) << 32);
    }
    if (state->entering)
    {
        b               = (int64_t)(wanted - feedforward_q31_inside(state->entry)) * (INT64_C(1) << 32);
        state->entering = !signals->r_good; // until a good r arrives
    }
    const int64_t most = (int64_t)params->offset_max * (INT64_C(1) << 32);
    state->offset      = b > most ? most : b < -most ? -most : b;
    signals->b         = feedforward_q31_offset(state);
    signals->added     = feedforward_q31_outside(wanted - signals->b);
    state->added       = signals->added;
    return signals->added;
}

/// True when r has crossed 0; see feedforward_f32.h.
static inline bool feedforward_q31_crosses(const tribo_feedforward_q31_state_t *state)
{
    return tribo_q31_multiply(state->reversal.position, state->side) < 0;
}

/// Slide of the arm in this tick, Q29; 0 where learning is not allowed.
static inline uint32_t feedforward_q31_travel(const tribo_feedforward_q31_params_t  *params,
                                              tribo_feedforward_q31_state_t         *state,
                                              const tribo_feedforward_q31_signals_t *signals)
{
    const int32_t  before = state->slide.sign;
    const uint32_t moved  = tribo_q31_magnitude(
        play_q31_step(&state->slide, signals->observer.force, params->slide_half, params->slide_half));
    const int32_t  sign     = state->slide.sign;
    const uint32_t distance = (sign == before ? state->distance : 0u) + moved; // up to 2 FS
    // Regular slide: sigma, F and r have one sign, F tracks r, and u is not limited.
    const bool slides = state->sigma == sign * FEEDFORWARD_Q31_FULL &&
                        tribo_q31_magnitude(state->error) <= (uint32_t)params->slide_error_max && state->limited == 0 &&
                        !feedforward_q31_crosses(state);
    state->distance   = slides ? distance : 0u;
    const bool steady = state->distance > params->slide_run_in &&
                        tribo_q31_magnitude(signals->observer.change) < (uint32_t)params->slide_change_max &&
                        signals->y_good;
    return steady ? moved : 0u;
}

/// Learns from a slide of `travel` in the direction of r.
static inline void feedforward_q31_learn(const tribo_feedforward_q31_params_t  *params,
                                         const tribo_friction_q31_params_t     *friction,
                                         tribo_feedforward_q31_state_t         *state,
                                         int32_t                                v,
                                         uint32_t                               travel,
                                         const tribo_feedforward_q31_signals_t *signals)
{
    const bool     falls     = signals->sign < 0;
    const uint32_t direction = feedforward_q31_direction(signals->sign);
    const int32_t  z         = falls ? -signals->observer.friction : signals->observer.friction;
    const uint32_t prior     = feedforward_q31_prior(friction, direction, signals->observer.force);
    breakaway_learning_q31_step(&params->learning, &state->learning, direction, travel, prior, z);
    state->learning.slid = 1;

    const int32_t  held  = state->held[direction];
    const int32_t  holds = limit_q31(v - signals->b, -params->offset_max, params->offset_max);
    const uint32_t part  = 2u * ratio_q31(travel, travel + params->slide_run_in); // Q32

    state->held[direction] = first_order_q31_step(held, holds, part);
    hold_q31_learned(&params->hold, &state->hold, travel);
}

/// Exchanges the learned sides when r has crossed 0, but not during a ramp of sigma or a step of r, which avoids the
/// worst-case tick. Returns true if f changes by it; in a hold it does not.
static inline bool feedforward_q31_change_side(const tribo_feedforward_q31_params_t  *params,
                                               tribo_feedforward_q31_state_t         *state,
                                               const tribo_feedforward_q31_signals_t *signals)
{
    const bool goes  = signals->behind.L == 0u;
    const bool jumps = tribo_q31_magnitude(state->r[0] - state->r[1]) > (uint32_t)params->step;
    if (!feedforward_q31_crosses(state) || !(goes || (state->hold.active && !jumps)))
    {
        return false;
    }
    state->side = state->reversal.position > 0 ? 1 : -1;
    tribo_breakaway_learning_q31_change_side(&state->learning);
    return goes;
}

/// b takes the change of f, so that learning does not move u.
static inline void feedforward_q31_keep(const tribo_feedforward_q31_params_t  *params,
                                        tribo_feedforward_q31_state_t         *state,
                                        const tribo_feedforward_q31_signals_t *signals)
{
    const uint32_t                               direction = feedforward_q31_direction(signals->sign);
    const tribo_breakaway_learning_q31_signals_t now =
        feedforward_q31_breakaway(params, state, direction, &signals->place);
    const int32_t moved = signals->sign * ((int32_t)now.weighted - (int32_t)signals->ahead.weighted);
    state->held[direction] -= moved;
    feedforward_q31_move_offset(state, moved);
}

static inline void feedforward_q31_after(const tribo_feedforward_q31_params_t *params,
                                         const tribo_friction_q31_params_t    *friction,
                                         tribo_feedforward_q31_state_t        *state,
                                         int32_t                               v,
                                         int32_t                               u,
                                         bool                                  limited,
                                         tribo_feedforward_q31_signals_t      *signals)
{
    state->limited = 0;
    if (limited)
    {
        const int64_t wanted = (int64_t)v + signals->added;
        state->limited       = (int8_t)((wanted > u) - (wanted < u));
    }
    state->u = feedforward_q31_inside(u);
    friction_observer_q31_step(&params->observer, &state->observer, state->u, signals->y, &signals->observer);
    state->error    = first_order_q31_step(state->error, signals->error, params->observer.filter_part);
    signals->travel = feedforward_q31_travel(params, state, signals);
    if (signals->travel > 0u)
    {
        feedforward_q31_learn(params, friction, state, feedforward_q31_inside(v), signals->travel, signals);
    }
    else if (!feedforward_q31_change_side(params, state, signals))
    {
        return;
    }
    feedforward_q31_keep(params, state, signals);
}

#endif
