// One tick of the feed-forward in its three parts, for inputs that are known to be good.

#ifndef TRIBO_FEEDFORWARD_F32_STEP_H
#define TRIBO_FEEDFORWARD_F32_STEP_H

#include "tribo/feedforward_f32.h"

#include "breakaway_learning_f32_step.h"
#include "friction_f32_step.h"
#include "friction_meter_f32_step.h"
#include "hold_f32_step.h"
#include "path_f32_step.h"
#include "play_f32_step.h"

#include <stddef.h>

/// L in `direction` at `force` before anything is learned.
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

/// -1, 0 or 1: a way, whatever a flipped bit has made of it.
static inline int32_t feedforward_f32_sign(int32_t way)
{
    return (way > 0) - (way < 0);
}

/// The direction of a way that is not 0.
static inline uint32_t feedforward_f32_direction(int32_t way)
{
    return way < 0 ? TRIBO_BREAKAWAY_NEGATIVE : TRIBO_BREAKAWAY_POSITIVE;
}

/// Friction between that of the way that r went before and that of the way it goes, exactly these at the ends.
static inline float feedforward_f32_friction(const tribo_feedforward_f32_signals_t *signals, float sigma)
{
    const float way = (float)signals->way;
    float       f   = signals->ahead.weighted_n;
    if (sigma != way)
    {
        const float done = 0.5f + 0.5f * way * sigma;
        f                = done * f - (1.0f - done) * signals->behind.weighted_n;
    }
    return way * f;
}

/// Everything stands where y is; beside a controller that has followed r already, what follows r where r is.
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
    state->hold.active   = false; // caution is kept, as what was learned is
    state->learning.slid = 0;     // the slide of a former run
    state->hold.still    = 0;
    state->hold.anchor_n = at;
    tribo_play_f32_reset(&state->reversal, at);
    tribo_play_f32_reset(&state->slide, y);
    tribo_path_f32_reset(&state->path);
    tribo_friction_meter_f32_reset(&state->meter, y);
}

/// Mean second difference of r. A single one counts up to four times the mean, so that a reversal or a step is no noise.
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

/// Moves rs towards r, but not further into a limit of u, and its rate. Returns by how much; more than step_n is a step.
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

/// What is known of L in `direction` at rs, weighted by what a guard leaves of it, too.
static inline tribo_breakaway_learning_f32_signals_t feedforward_f32_breakaway(
    const tribo_feedforward_f32_params_t       *params,
    const tribo_feedforward_f32_state_t        *state,
    uint32_t                                    direction,
    const tribo_breakaway_learning_f32_place_t *place)
{
    tribo_breakaway_learning_f32_signals_t L =
        breakaway_learning_f32_at(&params->learning, &state->learning, direction, place);
    L.weighted_n *= state->share;
    return L;
}

/// f while r moves: sigma goes to the way of r. `first` tells of the first reversal, `step` of one that r has jumped to.
static inline void feedforward_f32_follow(const tribo_feedforward_f32_params_t *params,
                                          tribo_feedforward_f32_state_t        *state,
                                          bool                                  first,
                                          bool                                  step,
                                          tribo_feedforward_f32_signals_t      *signals)
{
    const float way = (float)signals->way;
    state->offset_n -= params->offset_part * state->offset_n;
    // The first reversal, and a step into a direction that is little known, are the controller's alone: f jumps and b with it.
    if (signals->turns && (first || (step && signals->ahead.doubt > 0.5f)))
    {
        const float f_before = feedforward_f32_friction(signals, state->sigma);
        state->sigma         = way;
        state->offset_n += feedforward_f32_friction(signals, way) - f_before;
        signals->turns = false;
    }
    const float before = state->sigma;
    if (before != way)
    {
        state->sigma = bound_f32(before + bound_f32(way - before, params->jump), 1.0f); // also where it was corrupt
    }
    signals->f_n = feedforward_f32_friction(signals, state->sigma);
    if (state->entering)
    {
        state->entry_n += signals->f_n - feedforward_f32_friction(signals, before); // a jump goes on
    }
}

/// f while r stands: what the arm holds back.
static inline void feedforward_f32_hold(const tribo_feedforward_f32_params_t *params,
                                        tribo_feedforward_f32_state_t        *state,
                                        tribo_feedforward_f32_signals_t      *signals)
{
    const bool  falls    = signals->way < 0;
    const float positive = state->share * (falls ? signals->behind.L_n : signals->ahead.L_n);
    const float negative = state->share * (falls ? signals->ahead.L_n : signals->behind.L_n);
    const bool  enters   = !state->hold.active;
    if (enters)
    {
        hold_f32_enter(&state->hold, state->u_n, state->f_n, signals->way, signals->y_n);
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

/// f in the first tick after a hold: where u has been left by it.
static inline void feedforward_f32_leave(tribo_feedforward_f32_state_t *state, tribo_feedforward_f32_signals_t *signals)
{
    const float    way       = (float)signals->way;
    const float    ahead     = signals->ahead.weighted_n;
    const float    behind    = signals->behind.weighted_n;
    const uint32_t direction = feedforward_f32_direction(signals->way);

    state->sigma = way;
    if (state->hold.play.way != signals->way && ahead + behind > 0.0f)
    {
        // Along the way that r goes, from that behind to that ahead.
        const float f = limit_f32(way * (state->u_n - signals->lin_n - state->held_n[direction]), -behind, ahead);
        state->sigma  = way * (1.0f - 2.0f * (ahead - f) / (ahead + behind));
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
    const float y = bad_y ? state->meter.y_n : y_n;
    float       r = bad_r ? state->r_n[0] : r_n;
    if (!state->running)
    {
        r = bad_r && state->entering ? y : r; // no reference of a former run
        feedforward_f32_start(state, r, y);
    }

    const float noise = feedforward_f32_noise(params, state, r);
    const float was   = state->reached_n;
    const float moved = feedforward_f32_reach(params, state, r);
    const bool  step  = magnitude(moved) > params->step_n;
    const float width = params->reversal_n + noise;
    const float half  = 0.5f * width;

    // Reversal: the way that rs has gone by more than the width.
    const int32_t before = feedforward_f32_sign(state->reversal.way);
    (void)play_f32_step(&state->reversal, state->reached_n, half, half);
    const int32_t way    = feedforward_f32_sign(state->reversal.way);
    const bool    stands = hold_f32_stands(&params->hold, &state->hold, state->reached_n, half, step) && way != 0;
    const bool    leaves = state->hold.active && !stands;

    // Where r is noisy its rate is not worth much.
    const float ahead = params->lead_s * state->rate_n_s * (params->reversal_n / width);

    // y expected is of the end of the last tick, as y is; and so is the r that it is a distance from.
    signals->e_n = bad_y ? 0.0f : (was - y) + state->path.sensor_n;
    (void)path_f32_step(&params->path, &state->path, moved, ahead);
    signals->lin_n     = state->reached_n + ahead;
    signals->y_n       = y;
    signals->reached_n = state->reached_n;
    signals->way       = (int8_t)way;
    signals->turns     = way != before;
    signals->leaves    = false;
    signals->y_good    = !bad_y;
    signals->r_good    = !bad_r;

    // The other direction counts only while f is not at the end of the one that r goes.
    const uint32_t direction = feedforward_f32_direction(way);
    signals->place           = feedforward_f32_place(params, friction, state, direction);
    signals->ahead           = feedforward_f32_breakaway(params, state, direction, &signals->place);
    signals->behind          = (tribo_breakaway_learning_f32_signals_t){.L_n = 0.0f};
    if (stands || state->sigma != (float)way)
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
        b = v - state->held_n[feedforward_f32_direction(signals->way)]; // what v wound up while F stood
    }
    if (signals->leaves)
    {
        b = v + wanted - state->u_n;
    }
    if (state->entering)
    {
        b               = wanted - state->entry_n;
        state->entering = !signals->r_good; // until there is one
    }
    state->offset_n  = bound_f32(b, params->offset_max_n);
    signals->b_n     = state->offset_n;
    signals->added_n = wanted - state->offset_n;
    return signals->added_n;
}

/// Whether r has come to the other side of 0. A command of the wrong scale looks like friction that grows with F in one direction and
/// falls in the other, and the other way round on the other side of 0: no L(|F|) has both, so each side learns its own.
static inline bool feedforward_f32_crosses(const tribo_feedforward_f32_state_t *state)
{
    return !(state->reversal.position_n * state->side >= 0.0f); // also where the side was corrupt
}

/// How far the arm has slid in this tick, if something can be learned from it, else 0.
static inline float feedforward_f32_travel(const tribo_feedforward_f32_params_t  *params,
                                           tribo_feedforward_f32_state_t         *state,
                                           const tribo_feedforward_f32_signals_t *signals)
{
    const int32_t before = state->slide.way;
    const float   moved =
        magnitude(play_f32_step(&state->slide, signals->meter.force_n, params->slide_half_n, params->slide_half_n));
    const int32_t way      = state->slide.way;
    const float   distance = (way == before ? state->distance_n : 0.0f) + moved;
    // Slides as asked: the friction fed forward is all of the way that F goes, and so does r; and F is where r is.
    const bool slides = state->sigma == (float)way && magnitude(state->error_n) <= params->slide_error_max_n &&
                        state->limited == 0 && !feedforward_f32_crosses(state);
    state->distance_n = slides ? distance : 0.0f;
    const bool steady = state->distance_n > params->slide_run_in_n &&
                        magnitude(signals->meter.change_n) < params->slide_change_max_n && signals->y_good;
    return steady ? moved : 0.0f;
}

/// The arm has slid by `travel` the way that r goes.
static inline void feedforward_f32_learn(const tribo_feedforward_f32_params_t  *params,
                                         const tribo_friction_f32_params_t     *friction,
                                         tribo_feedforward_f32_state_t         *state,
                                         float                                  v,
                                         float                                  travel,
                                         const tribo_feedforward_f32_signals_t *signals)
{
    const float    way       = (float)signals->way;
    const uint32_t direction = feedforward_f32_direction(signals->way);
    const float    prior     = feedforward_f32_prior(friction, direction, signals->meter.force_n);
    breakaway_learning_f32_step(&params->learning,
                                &state->learning,
                                direction,
                                travel,
                                prior,
                                way * signals->meter.friction_n);
    state->learning.slid = 1;

    const float held  = state->held_n[direction];
    const float holds = bound_f32(v - state->offset_n, params->offset_max_n);

    hold_f32_learned(&params->hold, &state->hold, travel);
    state->held_n[direction] = held + travel / (travel + params->slide_run_in_n) * (holds - held);
}

/// Learning changes to the other side of 0 when r has come there. Not while f goes from one direction's L to the other's, nor
/// where r jumps: such a tick has enough to do. Returns whether f moves by it; in a hold it does not.
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

/// What f will move by, b moves by as well: another L does not move u.
static inline void feedforward_f32_keep(const tribo_feedforward_f32_params_t  *params,
                                        tribo_feedforward_f32_state_t         *state,
                                        const tribo_feedforward_f32_signals_t *signals)
{
    const uint32_t                               direction = feedforward_f32_direction(signals->way);
    const tribo_breakaway_learning_f32_signals_t now =
        feedforward_f32_breakaway(params, state, direction, &signals->place);
    const float moved = (float)signals->way * (now.weighted_n - signals->ahead.weighted_n);
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
    friction_meter_f32_step(&params->meter, &state->meter, u, signals->y_n, &signals->meter);
    state->error_n    = first_order_f32_step(state->error_n, signals->e_n, params->meter.filter_part);
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
