// The guard against over-compensation fades the friction that is added to u when that friction does harm. This text
// serves both arithmetics and is included by guard_f32.h or guard_q31.h.
//
// Its inputs are r, y and the friction f that any compensation adds to u. A play (Krasnosel'skii & Pokrovskii, "Systems
// with Hysteresis", ch. 2) separates reversals of f from noise: a position that f drags along once it is `half` away,
//
//     position = min(f + half, max(f - half, position))
//
// so that its sign changes once f has returned by 2 half. Between two reversals the guard accumulates
//
//     W = sum of f (dy - 2 dr)     work of f on the force, less twice the work that the reference requires
//     the largest error e = r - y of each sign
//
// and judges at the reversal:
//
//     hunting      the last reversal was less than quick_time_s ago, and W exceeds turn_n stray_n: f drives y against r.
//                  The guard acts after 16 in succession.
//     overshoot    the largest error of the wrong sign (y beyond r in the direction of f) exceeds that of the right sign by
//                  stray_n: F broke away too early and too far. The guard acts after 4 in succession.
//
// An undercompensated arm breaks away late, with an error of the right sign. Its friction reverses with r, at most a
// few times more. Over the closed-loop tables of research/compensation.md no more than 8 reversals and 2 overshoots
// follow one another with the feed-forward; a hunting loop has 10 to 30 reversals a second.
//
// One good reversal sets a count back to 0. The guard counts reversals, each of which takes 0.1 s or more, and not
// ticks, of which a loose contact may make some good in between. Counting down by 1 after a good reversal was tried on
// 75 rigs that are not broken. It reported overshoot on 12 of 64 instead of 2, because every second or third break-away
// may be an overshoot, and hunting on about as many as before. At a loose contact it is the controller that drives u to
// its limit, even with friction faded: the drive's levels (firmware/app/faults.h) stop that.
//
// The cause is latched, and the fade of friction goes from 1 to 0 within fade_time_s. A restore undoes the fade as
// slowly. A tick has one product and no loops. Not synchronized: one state, one tick.

#define GUARD_TURNS  16u
#define GUARD_STRAYS 4u

typedef NAME(guard, params_t) guard_params_t;
typedef NAME(guard, state_t) guard_state_t;
typedef NAME(play, state_t) play_state_t;

/// Puts a play at `position`, not yet moved (sign 0). A corrupt position counts as the nearest limit of the range.
static inline void guard_play_reset(play_state_t *state, force_t position)
{
    state->OF(position) = within_of(position, -PLAY_MAX, PLAY_MAX);
    state->sign         = 0;
}

/// Takes one sample of the input `x`, which drags the position along once it is `half` away.
static inline void guard_play_step(play_state_t *state, force_t x, force_t half)
{
    const force_t before = state->OF(position);
    const force_t lower  = x - half;
    const force_t upper  = x + half;
    if (before < lower)
    {
        state->OF(position) = lower;
        state->sign         = 1;
    }
    else if (before > upper)
    {
        state->OF(position) = upper;
        state->sign         = -1;
    }
}

/// Counts events in succession up to `most`: `before` plus 1 if this reversal is one more, otherwise 0.
static inline uint8_t guard_count(uint8_t before, bool one_more, uint8_t most)
{
    const uint8_t after = before < most ? (uint8_t)(before + 1u) : most;
    return one_more ? after : 0u;
}

static inline tribo_guard_cause_t guard_judge(tribo_guard_cause_t latched, uint8_t turns, uint8_t strays)
{
    if (latched != TRIBO_GUARD_NONE)
    {
        return latched == TRIBO_GUARD_HUNTING ? latched : TRIBO_GUARD_OVERSHOOT; // a corrupt cause counts, too
    }
    if (turns >= GUARD_TURNS)
    {
        return TRIBO_GUARD_HUNTING;
    }
    return strays >= GUARD_STRAYS ? TRIBO_GUARD_OVERSHOOT : TRIBO_GUARD_NONE;
}

/// Restarts the sums between two reversals.
static inline void guard_begin(guard_state_t *state)
{
    state->since    = 0;
    state->work     = 0;
    state->OF(high) = 0;
    state->OF(low)  = 0;
}

/// Judges a reversal of f, which has moved with `sign`, -1 or 1. 0 is the first move, with nothing to judge.
static inline void guard_turn(const guard_params_t *params, guard_state_t *state, int32_t sign)
{
    if (sign != 0)
    {
        // high is 0 or more, low 0 or less: the largest error of the wrong sign less that of the right one.
        const wide_t high  = state->OF(high);
        const wide_t wrong = -(wide_t)sign * (high + state->OF(low)); // wide, because a corrupt sign may be INT32_MIN
        const bool   hunts = state->since < params->quick_ticks && state->work > params->work;
        state->turns       = guard_count(state->turns, hunts, GUARD_TURNS);
        state->strays      = guard_count(state->strays, wrong > params->OF(stray), GUARD_STRAYS);
        state->cause       = guard_judge(state->cause, state->turns, state->strays);
    }
    guard_begin(state);
}

/// Takes a tick of good inputs: the reference, the reading and the friction in u.
static inline void guard_watch(const guard_params_t *params,
                               guard_state_t        *state,
                               force_t               r_in,
                               force_t               y_in,
                               force_t               f_in)
{
    const force_t r = guard_signal(r_in);
    const force_t y = guard_signal(y_in);
    const force_t f = guard_friction(f_in);
    const force_t e = r - y;
    if (state->running == 0u || guard_is_corrupt(state))
    {
        state->running = 1;
        state->OF(r)   = r;
        state->OF(y)   = y;
        guard_play_reset(&state->play, f);
    }
    if (state->since < params->quick_ticks) // a later reversal is not quick, and W is not used
    {
        state->work = guard_work(state, r, y, f);
        state->since++;
    }
    state->OF(high) = e > state->OF(high) ? e : state->OF(high);
    state->OF(low)  = e < state->OF(low) ? e : state->OF(low);
    state->OF(r)    = r;
    state->OF(y)    = y;

    const int32_t before = state->play.sign;
    guard_play_step(&state->play, f, params->OF(half));
    if (state->play.sign != before)
    {
        guard_turn(params, state, before);
    }
}
