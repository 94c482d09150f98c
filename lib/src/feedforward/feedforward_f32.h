// One tick of the feed-forward in its three parts.

#ifndef TRIBO_FEEDFORWARD_FEEDFORWARD_F32_H
#define TRIBO_FEEDFORWARD_FEEDFORWARD_F32_H

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/friction_f32.h"
#include "tribo/status.h"

#include "../paper/compensator_f32.h"
#include "../paper/friction_f32.h"
#include "breakaway_learning_f32.h"
#include "friction_observer_f32.h"
#include "hold_f32.h"
#include "play_f32.h"
#include "reference_model_f32.h"

#include <stddef.h>

/// The next tick is the first, for a controller that starts at rest; learned values and counters stay.
void tribo_feedforward_f32_restart(tribo_feedforward_f32_state_t *state);

/// Like a restart, for a controller that is already running: the first tick adds `added_n` (the sum of the previous method) to v, so
/// that u does not jump, and e is r - y. A bad `added_n` counts as 0.
void tribo_feedforward_f32_enter(tribo_feedforward_f32_state_t *state, float added_n);

/// First call of a tick: reference `r_n` and reading `y_n` in N give the error for the controller. `friction` gives the
/// prior. Cannot fail: a bad r (NaN, or beyond input_max_n) counts as the last good one, a bad y gives e = 0 and prevents
/// learning; both are counted. `signals` must not be null, in all three calls.
float tribo_feedforward_f32_before(const tribo_feedforward_f32_params_t *params,
                                   const tribo_friction_f32_params_t    *friction,
                                   tribo_feedforward_f32_state_t        *state,
                                   float                                 r_n,
                                   float                                 y_n,
                                   tribo_feedforward_f32_signals_t      *signals);

/// Second call: returns the sum to add to the controller's output `v_n`. A NaN counts as 0.
float tribo_feedforward_f32_added(const tribo_feedforward_f32_params_t *params,
                                  tribo_feedforward_f32_state_t        *state,
                                  float                                 v_n,
                                  tribo_feedforward_f32_signals_t      *signals);

/// Last call, with the applied `u_n`, and whether it was limited. A bad u (NaN, or beyond TRIBO_F32_FORCE_MAX_N) or v is
/// neither measured nor learned from.
void tribo_feedforward_f32_after(const tribo_feedforward_f32_params_t *params,
                                 const tribo_friction_f32_params_t    *friction,
                                 tribo_feedforward_f32_state_t        *state,
                                 float                                 v_n,
                                 float                                 u_n,
                                 bool                                  limited,
                                 tribo_feedforward_f32_signals_t      *signals);

/// Prior L in `direction` at `force`.
static inline float feedforward_f32_prior(const tribo_friction_f32_params_t *friction, uint32_t direction, float force)
{
    const float load = magnitude(force);
    if (friction->table != NULL)
    {
        float L[2];
        tribo_friction_f32_look_up(friction, load, L);
        return L[direction];
    }
    return friction_f32_affine(&friction->law[direction], load);
}

/// A sign, -1, 0 or 1, even if a bit of it has flipped.
static inline int32_t feedforward_f32_sign(int32_t sign)
{
    return (sign > 0) - (sign < 0);
}

/// The index of a nonzero sign.
static inline uint32_t feedforward_f32_direction(int32_t sign)
{
    return sign < 0 ? TRIBO_BREAKAWAY_NEGATIVE : TRIBO_BREAKAWAY_POSITIVE;
}

/// Friction while sigma ramps from the old direction of r to the new one; exact at both ends.
static inline float feedforward_f32_friction(const tribo_feedforward_f32_signals_t *signals, float sigma)
{
    const float sign = (float)signals->sign;
    float       f    = signals->ahead.weighted_n;
    if (sigma != sign)
    {
        const float done = 0.5f + 0.5f * sign * sigma;
        f                = done * f - (1.0f - done) * signals->behind.weighted_n;
    }
    return sign * f;
}

/// All states at rest at y; beside a running controller, the states that follow r at r.
static inline void feedforward_f32_start(tribo_feedforward_f32_state_t *state, float r, float y)
{
    const float at       = state->entering ? r : y;
    state->running       = true;
    state->limited       = 0;
    state->r_n[0]        = r;
    state->r_n[1]        = r;
    state->noise_n       = 0.0f;
    state->reached_n     = at;
    state->rate_n_s      = 0.0f;
    state->sigma         = 0.0f;
    state->offset_n      = 0.0f;
    state->held_n[0]     = 0.0f;
    state->held_n[1]     = 0.0f;
    state->error_n       = 0.0f;
    state->distance_n    = 0.0f;
    state->u_n           = y;
    state->f_n           = 0.0f;
    state->hold.active   = false; // the extra margin stays, like the learned law
    state->learning.slid = 0;     // a slide of the previous run does not count
    state->hold.still    = 0;
    state->hold.anchor_n = at;
    play_f32_reset(&state->reversal, at);
    play_f32_reset(&state->slide, y);
    tribo_reference_model_f32_reset(&state->reference_model);
    tribo_friction_observer_f32_reset(&state->observer, y);
}

/// Mean second difference of r. Each tick counts at most four times the mean, so that reversals and steps are not noise.
static inline float feedforward_f32_noise(const tribo_feedforward_f32_params_t *params,
                                          tribo_feedforward_f32_state_t        *state,
                                          float                                 r)
{
    const float second = magnitude((r - state->r_n[0]) - (state->r_n[0] - state->r_n[1]));
    const float most   = 4.0f * state->noise_n + params->noise_floor_n;
    state->noise_n     = first_order_f32_step(state->noise_n, second < most ? second : most, params->noise_part);
    state->r_n[1]      = state->r_n[0];
    state->r_n[0]      = r;
    return params->noise_gain * state->noise_n;
}

/// Updates rs and its rate: rs follows r, but not further into a limit of u. Returns the move; above step_n it is a step.
static inline float feedforward_f32_reach(const tribo_feedforward_f32_params_t *params,
                                          tribo_feedforward_f32_state_t        *state,
                                          float                                 r)
{
    float       change  = r - state->reached_n;
    const float further = (float)state->limited * change;
    change              = further > 0.0f ? 0.0f : change;
    const bool  step    = magnitude(change) > params->step_n;
    const float rate    = step ? 0.0f : change * params->rate_hz;
    state->reached_n    = state->reached_n + change;
    state->rate_n_s     = first_order_f32_step(state->rate_n_s, rate, params->rate_part);
    return change;
}

/// rs, for `direction`.
static inline tribo_breakaway_learning_f32_place_t feedforward_f32_place(const tribo_feedforward_f32_params_t *params,
                                                                         const tribo_friction_f32_params_t    *friction,
                                                                         const tribo_feedforward_f32_state_t  *state,
                                                                         uint32_t direction)
{
    return breakaway_learning_f32_place(&params->learning,
                                        feedforward_f32_prior(friction, direction, state->reached_n));
}

/// Learned L in `direction` at rs, with the guard's fade in its weight.
static inline tribo_breakaway_learning_f32_signals_t feedforward_f32_breakaway(
    const tribo_feedforward_f32_params_t       *params,
    const tribo_feedforward_f32_state_t        *state,
    uint32_t                                    direction,
    const tribo_breakaway_learning_f32_place_t *place)
{
    tribo_breakaway_learning_f32_signals_t L =
        breakaway_learning_f32_at(&params->learning, &state->learning, direction, place);
    L.weighted_n *= state->fade;
    return L;
}

/// f while r moves: sigma ramps to the sign of r. `first`: first reversal since the start; `step`: reversal by a step of r.
static inline void feedforward_f32_follow(const tribo_feedforward_f32_params_t *params,
                                          tribo_feedforward_f32_state_t        *state,
                                          bool                                  first,
                                          bool                                  step,
                                          tribo_feedforward_f32_signals_t      *signals)
{
    const float sign = (float)signals->sign;
    state->offset_n -= params->offset_part * state->offset_n;
    // The controller alone takes the first reversal and a step into a direction with little learned: f jumps, b cancels it.
    if (signals->turns && (first || (step && signals->ahead.relative_variance > 0.5f)))
    {
        const float f_before = feedforward_f32_friction(signals, state->sigma);
        state->sigma         = sign;
        state->offset_n += feedforward_f32_friction(signals, sign) - f_before;
        signals->turns = false;
    }
    const float before = state->sigma;
    if (before != sign)
    {
        state->sigma = bound_f32(before + bound_f32(sign - before, params->jump), 1.0f); // true for NaN
    }
    signals->f_n = feedforward_f32_friction(signals, state->sigma);
    if (state->entering)
    {
        state->entry_n += signals->f_n - feedforward_f32_friction(signals, before); // the remaining ramp still acts
    }
}

/// f while r stands: stiction fed back.
static inline void feedforward_f32_hold(const tribo_feedforward_f32_params_t *params,
                                        tribo_feedforward_f32_state_t        *state,
                                        tribo_feedforward_f32_signals_t      *signals)
{
    const bool  falls    = signals->sign < 0;
    const float positive = state->fade * (falls ? signals->behind.L_n : signals->ahead.L_n);
    const float negative = state->fade * (falls ? signals->ahead.L_n : signals->behind.L_n);
    const bool  enters   = !state->hold.active;
    if (enters)
    {
        hold_f32_enter(&state->hold, state->u_n, state->f_n, signals->sign, signals->y_n);
    }
    signals->f_n = hold_f32_step(&params->hold, &state->hold, state->u_n, positive, negative);
    if (signals->y_good)
    {
        signals->e_n = hold_f32_deadband(&params->hold, &state->hold, signals->e_n, signals->y_n);
    }
    if (enters)
    {
        state->offset_n += signals->f_n - state->f_n;
    }
    state->sigma   = 0.0f;
    signals->turns = false;
}

/// f in the first tick after a hold, chosen so that u continues.
static inline void feedforward_f32_leave(tribo_feedforward_f32_state_t *state, tribo_feedforward_f32_signals_t *signals)
{
    const float    sign      = (float)signals->sign;
    const float    ahead     = signals->ahead.weighted_n;
    const float    behind    = signals->behind.weighted_n;
    const uint32_t direction = feedforward_f32_direction(signals->sign);

    state->sigma = sign;
    if (state->hold.play.sign != signals->sign && ahead + behind > 0.0f)
    {
        // Between the L behind and the L ahead of r.
        const float f = limit_f32(sign * (state->u_n - signals->lin_n - state->held_n[direction]), -behind, ahead);
        state->sigma  = sign * (1.0f - 2.0f * (ahead - f) / (ahead + behind));
    }
    signals->f_n       = feedforward_f32_friction(signals, state->sigma);
    signals->turns     = false;
    signals->leaves    = true;
    state->hold.active = false;
}

static inline float feedforward_f32_before(const tribo_feedforward_f32_params_t *params,
                                           const tribo_friction_f32_params_t    *friction,
                                           tribo_feedforward_f32_state_t        *state,
                                           float                                 r_n,
                                           float                                 y_n,
                                           tribo_feedforward_f32_signals_t      *signals)
{
    const bool bad_r = exceeds(r_n, params->input_max_n);
    const bool bad_y = exceeds(y_n, params->input_max_n);
    if (bad_r || bad_y)
    {
        count(&state->bad_inputs);
    }
    const float y = bad_y ? state->observer.y_n : y_n;
    float       r = bad_r ? state->r_n[0] : r_n;
    if (!state->running)
    {
        r = bad_r && state->entering ? y : r; // the reference of the previous run is void
        feedforward_f32_start(state, r, y);
    }

    const float noise = feedforward_f32_noise(params, state, r);
    const float was   = state->reached_n;
    const float moved = feedforward_f32_reach(params, state, r);
    const bool  step  = magnitude(moved) > params->step_n;
    const float width = params->reversal_n + noise;
    const float half  = 0.5f * width;

    // Sign of r: of the last move of rs by more than the width.
    const int32_t before = feedforward_f32_sign(state->reversal.sign);
    (void)play_f32_step(&state->reversal, state->reached_n, half, half);
    const int32_t sign   = feedforward_f32_sign(state->reversal.sign);
    const bool    stands = hold_f32_stands(&params->hold, &state->hold, state->reached_n, half, step) && sign != 0;
    const bool    leaves = state->hold.active && !stands;

    // A noisy r has an unreliable rate.
    const float ahead = params->lead_s * state->rate_n_s * (params->reversal_n / width);

    // Like y, the expected y belongs to the end of the last tick; it is stored relative to the rs of that tick.
    signals->e_n = bad_y ? 0.0f : (was - y) + state->reference_model.sensor_n;
    (void)reference_model_f32_step(&params->reference_model, &state->reference_model, moved, ahead);
    signals->lin_n     = state->reached_n + ahead;
    signals->y_n       = y;
    signals->reached_n = state->reached_n;
    signals->sign      = (int8_t)sign;
    signals->turns     = sign != before;
    signals->leaves    = false;
    signals->y_good    = !bad_y;
    signals->r_good    = !bad_r;

    // The opposite L matters only during the ramp.
    const uint32_t direction = feedforward_f32_direction(sign);
    signals->place           = feedforward_f32_place(params, friction, state, direction);
    signals->ahead           = feedforward_f32_breakaway(params, state, direction, &signals->place);
    signals->behind          = (tribo_breakaway_learning_f32_signals_t){.L_n = 0.0f};
    if (stands || state->sigma != (float)sign)
    {
        const tribo_breakaway_learning_f32_place_t place =
            feedforward_f32_place(params, friction, state, 1u - direction);
        signals->behind = feedforward_f32_breakaway(params, state, 1u - direction, &place);
    }
    if (signals->turns)
    {
        tribo_breakaway_learning_f32_slide_ends(&params->learning,
                                                &state->learning,
                                                1u - direction,
                                                feedforward_f32_prior(friction, 1u - direction, state->reached_n));
    }
    if (stands)
    {
        feedforward_f32_hold(params, state, signals);
    }
    else if (leaves)
    {
        feedforward_f32_leave(state, signals);
    }
    else
    {
        feedforward_f32_follow(params, state, before == 0, step, signals);
    }
    state->f_n     = signals->f_n;
    state->e_n     = signals->e_n;
    signals->sigma = state->sigma;
    return signals->e_n;
}

static inline float feedforward_f32_added(const tribo_feedforward_f32_params_t *params,
                                          tribo_feedforward_f32_state_t        *state,
                                          float                                 v,
                                          tribo_feedforward_f32_signals_t      *signals)
{
    const float wanted = signals->lin_n + signals->f_n;
    float       b      = state->offset_n;
    if (signals->turns)
    {
        b = v - state->held_n[feedforward_f32_direction(signals->sign)]; // integral wound up during stiction
    }
    if (signals->leaves)
    {
        b = v + wanted - state->u_n;
    }
    if (state->entering)
    {
        b               = wanted - state->entry_n;
        state->entering = !signals->r_good; // until a good r arrives
    }
    state->offset_n  = bound_f32(b, params->offset_max_n);
    signals->b_n     = state->offset_n;
    signals->added_n = wanted - state->offset_n;
    state->added_n   = signals->added_n;
    return signals->added_n;
}

/// True when r has crossed 0. A wrong command scale looks like friction that grows with F in one direction and falls in the
/// other, with the roles exchanged beyond 0. No L(|F|) can express both, so each side of 0 learns its own.
static inline bool feedforward_f32_crosses(const tribo_feedforward_f32_state_t *state)
{
    return !(state->reversal.position_n * state->side >= 0.0f); // true for NaN
}

/// Slide of the arm in this tick, N; 0 where learning is not allowed.
static inline float feedforward_f32_travel(const tribo_feedforward_f32_params_t  *params,
                                           tribo_feedforward_f32_state_t         *state,
                                           const tribo_feedforward_f32_signals_t *signals)
{
    const int32_t before = state->slide.sign;
    const float   moved =
        magnitude(play_f32_step(&state->slide, signals->observer.force_n, params->slide_half_n, params->slide_half_n));
    const int32_t sign     = state->slide.sign;
    const float   distance = (sign == before ? state->distance_n : 0.0f) + moved;
    // Regular slide: sigma, F and r have one sign, F tracks r, and u is not limited.
    const bool slides = state->sigma == (float)sign && magnitude(state->error_n) <= params->slide_error_max_n &&
                        state->limited == 0 && !feedforward_f32_crosses(state);
    state->distance_n = slides ? distance : 0.0f;
    const bool steady = state->distance_n > params->slide_run_in_n &&
                        magnitude(signals->observer.change_n) < params->slide_change_max_n && signals->y_good;
    return steady ? moved : 0.0f;
}

/// Learns from a slide of `travel` in the direction of r.
static inline void feedforward_f32_learn(const tribo_feedforward_f32_params_t  *params,
                                         const tribo_friction_f32_params_t     *friction,
                                         tribo_feedforward_f32_state_t         *state,
                                         float                                  v,
                                         float                                  travel,
                                         const tribo_feedforward_f32_signals_t *signals)
{
    const float    sign      = (float)signals->sign;
    const uint32_t direction = feedforward_f32_direction(signals->sign);
    const float    prior     = feedforward_f32_prior(friction, direction, signals->observer.force_n);
    breakaway_learning_f32_step(&params->learning,
                                &state->learning,
                                direction,
                                travel,
                                prior,
                                sign * signals->observer.friction_n);
    state->learning.slid = 1;

    const float held  = state->held_n[direction];
    const float holds = bound_f32(v - state->offset_n, params->offset_max_n);

    hold_f32_learned(&params->hold, &state->hold, travel);
    state->held_n[direction] = held + travel / (travel + params->slide_run_in_n) * (holds - held);
}

/// Exchanges the learned sides when r has crossed 0, but not during a ramp of sigma or a step of r, which avoids the
/// worst-case tick. Returns true if f changes by it; in a hold it does not.
static inline bool feedforward_f32_change_side(const tribo_feedforward_f32_params_t  *params,
                                               tribo_feedforward_f32_state_t         *state,
                                               const tribo_feedforward_f32_signals_t *signals)
{
    const bool goes  = signals->behind.L_n == 0.0f;
    const bool jumps = magnitude(state->r_n[0] - state->r_n[1]) > params->step_n;
    if (!feedforward_f32_crosses(state) || !(goes || (state->hold.active && !jumps)))
    {
        return false;
    }
    state->side = state->reversal.position_n > 0.0f ? 1.0f : -1.0f;
    tribo_breakaway_learning_f32_change_side(&params->learning, &state->learning);
    return goes;
}

/// b takes the change of f, so that learning does not move u.
static inline void feedforward_f32_keep(const tribo_feedforward_f32_params_t  *params,
                                        tribo_feedforward_f32_state_t         *state,
                                        const tribo_feedforward_f32_signals_t *signals)
{
    const uint32_t                               direction = feedforward_f32_direction(signals->sign);
    const tribo_breakaway_learning_f32_signals_t now =
        feedforward_f32_breakaway(params, state, direction, &signals->place);
    const float moved = (float)signals->sign * (now.weighted_n - signals->ahead.weighted_n);
    state->held_n[direction] -= moved;
    state->offset_n += moved;
}

static inline void feedforward_f32_after(const tribo_feedforward_f32_params_t *params,
                                         const tribo_friction_f32_params_t    *friction,
                                         tribo_feedforward_f32_state_t        *state,
                                         float                                 v,
                                         float                                 u,
                                         bool                                  limited,
                                         tribo_feedforward_f32_signals_t      *signals)
{
    const float wanted = v + signals->added_n;
    state->limited     = (int8_t)(limited ? (wanted > u) - (wanted < u) : 0);
    state->u_n         = u;
    friction_observer_f32_step(&params->observer, &state->observer, u, signals->y_n, &signals->observer);
    state->error_n    = first_order_f32_step(state->error_n, signals->e_n, params->observer.filter_part);
    signals->travel_n = feedforward_f32_travel(params, state, signals);
    if (signals->travel_n > 0.0f)
    {
        feedforward_f32_learn(params, friction, state, v, signals->travel_n, signals);
    }
    else if (!feedforward_f32_change_side(params, state, signals))
    {
        return;
    }
    feedforward_f32_keep(params, state, signals);
}

#endif
