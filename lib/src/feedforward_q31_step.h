// One tick of the feed-forward in its three parts. Forces are Q29 of full scale where nothing else is said.

#ifndef TRIBO_FEEDFORWARD_Q31_STEP_H
#define TRIBO_FEEDFORWARD_Q31_STEP_H

#include "tribo/feedforward_q31.h"

#include "breakaway_learning_q31_step.h"
#include "first_order_q31.h"
#include "friction_meter_q31_step.h"
#include "friction_q31_step.h"
#include "hold_q31_step.h"
#include "limit_q31.h"
#include "path_q31_step.h"
#include "play_q31_step.h"

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

/// L in `direction` at `force` before anything is learned. Good forces are below FS.
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

/// The direction of a way that is not 0.
static inline uint32_t feedforward_q31_direction(int32_t way)
{
    return way < 0 ? TRIBO_BREAKAWAY_NEGATIVE : TRIBO_BREAKAWAY_POSITIVE;
}

/// Friction between that of the way that r went before and that of the way it goes, exactly these at the ends.
static inline int32_t feedforward_q31_friction(const tribo_feedforward_q31_signals_t *signals, int32_t sigma)
{
    const int32_t along = signals->way < 0 ? -sigma : sigma;
    int32_t       f     = (int32_t)signals->ahead.weighted;
    if (along != FEEDFORWARD_Q31_FULL)
    {
        const uint32_t done   = (uint32_t)(FEEDFORWARD_Q31_FULL + along); // Q30
        const uint32_t undone = (uint32_t)(FEEDFORWARD_Q31_FULL - along);
        f                     = (int32_t)(tribo_q31_product(done, signals->ahead.weighted) >> 30) -
            (int32_t)(tribo_q31_product(undone, signals->behind.weighted) >> 30);
    }
    return f * signals->way;
}

/// b in Q29, rounded towards zero.
static inline int32_t feedforward_q31_offset(const tribo_feedforward_q31_state_t *state)
{
    const int32_t high = (int32_t)(uint32_t)((uint64_t)state->offset >> 32);
    return high + (int32_t)(high < 0 && (uint32_t)state->offset != 0u);
}

/// Everything stands where y is; beside a controller that has followed r already, what follows r where r is.
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
    state->hold.active   = false; // caution is kept, as what was learned is
    state->learning.slid = 0;     // the slide of a former run
    state->hold.still    = 0;
    state->hold.anchor   = at;
    tribo_play_q31_reset(&state->reversal, at);
    tribo_play_q31_reset(&state->slide, y);
    tribo_path_q31_reset(&state->path);
    tribo_friction_meter_q31_reset(&state->meter, y);
}

/// w_n from the mean second difference of r. A single one counts up to four times the mean, so that a reversal or a step is
/// no noise.
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

/// Moves rs towards r, but not further into a limit of u, and its rate. Returns by how much; more than step is a step.
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

/// How far lin is ahead of rs, within FS/2. Where r is noisy its rate is not worth much.
static inline int32_t feedforward_q31_ahead(const tribo_feedforward_q31_params_t *params,
                                            tribo_feedforward_q31_state_t        *state,
                                            uint32_t                              width)
{
    const uint32_t share = 2u * ratio_q31(params->reversal, width); // Q32
    return part_of_q31(state->rate, tribo_q31_high(params->lead, share)) * (int32_t)(UINT32_C(1) << params->lead_shift);
}

/// What a guard leaves of a force.
static inline uint32_t feedforward_q31_left(const tribo_feedforward_q31_state_t *state, uint32_t force)
{
    return state->share == UINT32_MAX ? force : tribo_q31_high(force, state->share);
}

/// rs, for `direction`.
static inline tribo_breakaway_learning_q31_place_t feedforward_q31_place(const tribo_feedforward_q31_params_t *params,
                                                                         const tribo_friction_q31_params_t    *friction,
                                                                         const tribo_feedforward_q31_state_t  *state,
                                                                         uint32_t direction)
{
    return breakaway_learning_q31_place(&params->learning, feedforward_q31_prior(friction, direction, state->reached));
}

/// What is known of L in `direction` at rs, weighted by what a guard leaves of it, too.
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

/// f while r moves: sigma goes to the way of r. `first` tells of the first reversal, `step` of one that r has jumped to.
static inline void feedforward_q31_follow(const tribo_feedforward_q31_params_t *params,
                                          tribo_feedforward_q31_state_t        *state,
                                          bool                                  first,
                                          bool                                  step,
                                          tribo_feedforward_q31_signals_t      *signals)
{
    const int32_t way = signals->way * FEEDFORWARD_Q31_FULL;
    state->offset -= tribo_q31_multiply(feedforward_q31_offset(state), params->offset_part);
    // The first reversal, and a step into a direction that is little known, are the controller's alone: f jumps and b with it.
    if (signals->turns && (first || (step && signals->ahead.doubt > UINT32_C(1) << 30)))
    {
        const int32_t f_before = feedforward_q31_friction(signals, state->sigma);
        state->sigma           = way;
        feedforward_q31_move_offset(state, feedforward_q31_friction(signals, way) - f_before);
        signals->turns = false;
    }
    const int32_t before = state->sigma;
    if (before != way)
    {
        state->sigma = before + limit_q31(way - before, -params->jump, params->jump);
    }
    signals->f = feedforward_q31_friction(signals, state->sigma);
    if (state->entering)
    {
        state->entry += 4 * (signals->f - feedforward_q31_friction(signals, before)); // a jump goes on
    }
}

/// f while r stands: what the arm holds back.
static inline void feedforward_q31_hold(const tribo_feedforward_q31_params_t *params,
                                        tribo_feedforward_q31_state_t        *state,
                                        tribo_feedforward_q31_signals_t      *signals)
{
    const bool     falls    = signals->way < 0;
    const uint32_t positive = feedforward_q31_left(state, falls ? signals->behind.L : signals->ahead.L);
    const uint32_t negative = feedforward_q31_left(state, falls ? signals->ahead.L : signals->behind.L);
    const bool     enters   = !state->hold.active;
    if (enters)
    {
        hold_q31_enter(&state->hold, state->u, state->f, signals->way, signals->y);
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

/// f in the first tick after a hold: where u has been left by it.
static inline void feedforward_q31_leave(tribo_feedforward_q31_state_t *state, tribo_feedforward_q31_signals_t *signals)
{
    const int32_t  ahead     = (int32_t)signals->ahead.weighted;
    const int32_t  behind    = (int32_t)signals->behind.weighted;
    const uint32_t direction = feedforward_q31_direction(signals->way);

    int32_t along = FEEDFORWARD_Q31_FULL;
    if (state->hold.play.way != signals->way)
    {
        // Along the way that r goes, from that behind to that ahead.
        const int32_t left = signals->way * (state->u - signals->lin - state->held[direction]);
        const int32_t f    = limit_q31(left, -behind, ahead);
        along -= (int32_t)(ratio_q31((uint32_t)(ahead - f), (uint32_t)(ahead + behind)) / 2u);
    }
    state->sigma       = signals->way * along;
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
        r = bad_r && state->entering ? y : r; // no reference of a former run
        feedforward_q31_start(state, r, y);
    }

    const uint32_t noise = feedforward_q31_noise(params, state, r);
    const int32_t  was   = state->reached;
    const int32_t  moved = feedforward_q31_reach(params, state, r);
    const bool     step  = tribo_q31_magnitude(moved) > (uint32_t)params->step;
    const uint32_t width = params->reversal + noise;
    const uint32_t half  = width / 2u;

    // Reversal: the way that rs has gone by more than the width.
    const int32_t before = state->reversal.way;
    (void)play_q31_step(&state->reversal, state->reached, (int32_t)half, (int32_t)half);
    const int32_t way    = state->reversal.way;
    const bool    stands = hold_q31_stands(&params->hold, &state->hold, state->reached, half, step) && way != 0;
    const bool    leaves = state->hold.active && !stands;

    const int32_t ahead = feedforward_q31_ahead(params, state, width);

    // y expected is of the end of the last tick, as y is; and so is the r that it is a distance from.
    const int32_t error = bad_y ? 0 : tribo_q31_add(difference_q31(was, y), state->path.sensor, &state->path.saturated);
    (void)path_q31_step(&params->path, &state->path, moved, ahead);
    signals->error   = limit_q31(error, -FEEDFORWARD_Q31_FULL, FEEDFORWARD_Q31_FULL);
    signals->lin     = state->reached + ahead;
    signals->y       = y;
    signals->reached = state->reached;
    signals->way     = (int8_t)way;
    signals->turns   = way != before;
    signals->leaves  = false;
    signals->y_good  = !bad_y;
    signals->r_good  = !bad_r;

    // The other direction counts only while f is not at the end of the one that r goes.
    const uint32_t direction = feedforward_q31_direction(way);
    signals->place           = feedforward_q31_place(params, friction, state, direction);
    signals->ahead           = feedforward_q31_breakaway(params, state, direction, &signals->place);
    signals->behind          = (tribo_breakaway_learning_q31_signals_t){.L = 0};
    if (stands || state->sigma != way * FEEDFORWARD_Q31_FULL)
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
        const int32_t held = state->held[feedforward_q31_direction(signals->way)];
        b = (int64_t)(feedforward_q31_inside(v_q31) - held) * (INT64_C(1) << 32); // what v wound up while F stood
    }
    if (signals->leaves)
    {
        b = (int64_t)(wanted - state->u + feedforward_q31_inside(v_q31)) * (INT64_C(1) << 32);
    }
    if (state->entering)
    {
        b               = (int64_t)(wanted - feedforward_q31_inside(state->entry)) * (INT64_C(1) << 32);
        state->entering = !signals->r_good; // until there is one
    }
    const int64_t most = (int64_t)params->offset_max * (INT64_C(1) << 32);
    state->offset      = b > most ? most : b < -most ? -most : b;
    signals->b         = feedforward_q31_offset(state);
    signals->added     = feedforward_q31_outside(wanted - signals->b);
    return signals->added;
}

/// Whether r has come to the other side of 0; see the twin.
static inline bool feedforward_q31_crosses(const tribo_feedforward_q31_state_t *state)
{
    return tribo_q31_multiply(state->reversal.position, state->side) < 0;
}

/// How far the arm has slid in this tick, if something can be learned from it, else 0.
static inline uint32_t feedforward_q31_travel(const tribo_feedforward_q31_params_t  *params,
                                              tribo_feedforward_q31_state_t         *state,
                                              const tribo_feedforward_q31_signals_t *signals)
{
    const int32_t  before = state->slide.way;
    const uint32_t moved =
        tribo_q31_magnitude(play_q31_step(&state->slide, signals->meter.force, params->slide_half, params->slide_half));
    const int32_t  way      = state->slide.way;
    const uint32_t distance = (way == before ? state->distance : 0u) + moved; // up to 2 FS
    // Slides as asked: the friction fed forward is all of the way that F goes, and so does r; and F is where r is.
    const bool slides = state->sigma == way * FEEDFORWARD_Q31_FULL &&
                        tribo_q31_magnitude(state->error) <= (uint32_t)params->slide_error_max && state->limited == 0 &&
                        !feedforward_q31_crosses(state);
    state->distance   = slides ? distance : 0u;
    const bool steady = state->distance > params->slide_run_in &&
                        tribo_q31_magnitude(signals->meter.change) < (uint32_t)params->slide_change_max &&
                        signals->y_good;
    return steady ? moved : 0u;
}

/// The arm has slid by `travel` the way that r goes.
static inline void feedforward_q31_learn(const tribo_feedforward_q31_params_t  *params,
                                         const tribo_friction_q31_params_t     *friction,
                                         tribo_feedforward_q31_state_t         *state,
                                         int32_t                                v,
                                         uint32_t                               travel,
                                         const tribo_feedforward_q31_signals_t *signals)
{
    const bool     falls     = signals->way < 0;
    const uint32_t direction = feedforward_q31_direction(signals->way);
    const int32_t  z         = falls ? -signals->meter.friction : signals->meter.friction;
    const uint32_t prior     = feedforward_q31_prior(friction, direction, signals->meter.force);
    breakaway_learning_q31_step(&params->learning, &state->learning, direction, travel, prior, z);
    state->learning.slid = 1;

    const int32_t  held  = state->held[direction];
    const int32_t  holds = limit_q31(v - signals->b, -params->offset_max, params->offset_max);
    const uint32_t part  = 2u * ratio_q31(travel, travel + params->slide_run_in); // Q32

    state->held[direction] = first_order_q31_step(held, holds, part);
    hold_q31_learned(&params->hold, &state->hold, travel);
}

/// Learning changes to the other side of 0 when r has come there. Not while f goes from one direction's L to the other's, nor
/// where r jumps: such a tick has enough to do. Returns whether f moves by it; in a hold it does not.
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

/// What f will move by, b moves by as well: another L does not move u.
static inline void feedforward_q31_keep(const tribo_feedforward_q31_params_t  *params,
                                        tribo_feedforward_q31_state_t         *state,
                                        const tribo_feedforward_q31_signals_t *signals)
{
    const uint32_t                               direction = feedforward_q31_direction(signals->way);
    const tribo_breakaway_learning_q31_signals_t now =
        feedforward_q31_breakaway(params, state, direction, &signals->place);
    const int32_t moved = signals->way * ((int32_t)now.weighted - (int32_t)signals->ahead.weighted);
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
    friction_meter_q31_step(&params->meter, &state->meter, state->u, signals->y, &signals->meter);
    state->error    = first_order_q31_step(state->error, signals->error, params->meter.filter_part);
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
