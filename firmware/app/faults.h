/// Detects faults of the rig that a single tick cannot reveal: conditions that last longer than their bound. A bound of 0
/// disables its fault.
///
/// Most conditions have a level: a tick with the condition raises it by some steps, a tick without lowers it by one step. An
/// intermittent contact therefore reaches the bound as well. A start within FAULTS_REST_MS of a stop leaves the levels as
/// they are.

#ifndef DRIVE_FAULTS_H
#define DRIVE_FAULTS_H

#include "app/config.h"
#include "app/loop.h"
#include "app/scaling.h"

#include <stdbool.h>
#include <stdint.h>

// Steps by which a level rises in a tick with the condition. The level reaches its bound if the condition holds in more than
// one tick of ...
#define FAULTS_RISE_RESIDUAL 4u ///< ... five
#define FAULTS_RISE_MEASURED 2u ///< ... three
#define FAULTS_RISE_LOOP                                                                                               \
    1u ///< ... two: for tracking and command limit, whose conditions a fast reference causes as well
#define FAULTS_RISE_BAD     8u ///< ... nine: for the bad readings that the debounce bridges
#define FAULTS_RISE_LIMITED 6  ///< rise of the level of y's swings in a tick with u at a limit
#define FAULTS_SWING_STEPS  2  ///< steps of a swing's level that correspond to a tick; the level loses one step a tick
#define FAULTS_BAD_LEVEL    (FAULTS_RISE_BAD * 32u)

#define FAULTS_REST_MS 1000u
#define FAULTS_KICKS   2 ///< credit that moves of r give to swings of u, for each tick of credit to swings of y

/// How swings fill a level.
typedef struct
{
    scaling_rise_t least; ///< size of the smallest swing that counts
    scaling_rise_t gain;  ///< steps for a swing of 1 N; in Q31, for one of twice the full scale
} faults_swings_t;

/// The bounds of drive_config_t as forces of the arithmetic and as ticks.
typedef struct
{
    loop_force_t   residual;       ///< at y = 0
    scaling_gain_t residual_slope; ///< growth of the residual's bound with |y|
    loop_force_t   tracking;
    loop_force_t   tare_max;            ///< 0: off
    int32_t        travel;              ///< largest in speed_ticks, in units of the position; 0: off
    uint32_t debounce_n, debounce_mask; ///< number of bad readings that are a fault, and the ticks in which they count
    uint32_t residual_level, tracking_level, command_limit_level;
    uint32_t speed_ticks, reference_ticks, ready_ticks, rest_ticks;

    faults_swings_t swings_of_u, swings_of_y, moves_of_r;
    scaling_gain_t  follow; ///< part of the distance to r that a loop covers in a tick
    int32_t         swing_level, credit_max;

    loop_force_t ramp;           ///< change of r a tick without a host; 0: a fault instead
    loop_force_t safe_reference; ///< where the ramp ends
    int32_t      over_current_ma, bus_low_mv, bus_high_mv, temperature_max_mc; ///< 0: off
    bool         is_measured; ///< one of these four bounds, or that of travel, is on
    uint32_t     over_current_level, bus_voltage_level, temperature_level;
} faults_bounds_t;

/// The present swing of a signal, and the level that its earlier swings have filled.
typedef struct
{
    loop_force_t begin, end;
    bool         falls;
    int32_t      level; ///< steps; negative: credit for swings that moves of r explain
} faults_turns_t;

/// Levels that change only in RUN.
typedef struct
{
    uint32_t       residual, tracking, command_limit;
    faults_turns_t u, y;
    loop_force_t   followed; ///< r behind a low pass, as far as a loop follows it
    scaling_rise_t travel;   ///< of `followed`, not yet credited
} faults_loop_t;

typedef struct
{
    faults_loop_t loop;
    uint32_t      reference; ///< ticks in a row without a new reference
    uint32_t      starting;  ///< ticks of waiting for the power stage
    uint32_t      bad;       ///< level of bad readings
    uint32_t      speed;     ///< ticks since the arm was at `position`; 0: no position yet
    int32_t       position;
    uint32_t      over_current, bus_voltage, temperature;
} faults_state_t;

void faults_init(faults_bounds_t *bounds, const drive_config_t *config, const loop_params_t *params);

/// Raises the level by `rise` if the condition holds, or lowers it by one step. Returns true while the level is above
/// `bound`, where it stops rising.
static inline bool faults_last(uint32_t *level, bool condition, uint32_t rise, uint32_t bound)
{
    const uint32_t was = *level;
    *level             = !condition ? was - (was > 0u) : was <= bound ? was + rise : was;
    return bound > 0u && *level > bound;
}

static inline bool faults_apart(loop_force_t a, loop_force_t b, loop_force_t bound)
{
    return scaling_size((scaling_sum_t)a - b) > bound;
}

/// Counts ticks in a row with the condition. Returns true beyond `bound`.
static inline bool faults_in_a_row(uint32_t *ticks, bool condition, uint32_t bound)
{
    *ticks = condition ? *ticks + (*ticks != UINT32_MAX) : 0u;
    return bound > 0u && *ticks > bound;
}

/// Records whether this tick's reading is bad in `history`, a bit a tick, and in `level`. Returns true if it is bad and enough of
/// the last ones were.
static inline bool faults_readings(const faults_bounds_t *bounds, uint32_t *history, uint32_t *level, bool bad)
{
    *history         = *history << 1 | (bad ? 1u : 0u);
    const bool many  = faults_last(level, bad, FAULTS_RISE_BAD, FAULTS_BAD_LEVEL);
    uint32_t   count = 0;
    for (uint32_t left = bad ? *history & bounds->debounce_mask : 0u; left != 0u; left &= left - 1u)
    {
        count++;
    }
    return bad && (many || count >= bounds->debounce_n);
}

// Each of the following processes a tick and returns true once its bound is exceeded.

/// `expected` is the reading that u leads to (expected.h). A healthy rig follows it within its friction and the model's error. A
/// sensor that is detached, frozen, reversed or reads half, an open motor or an arm that touches nothing do not.
static inline bool faults_residual(const faults_bounds_t *bounds,
                                   faults_loop_t         *state,
                                   loop_force_t           y,
                                   loop_force_t           expected)
{
    const loop_force_t bound =
        scaling_sum(bounds->residual, scaling_times(&bounds->residual_slope, (loop_force_t)scaling_size(y)));
    return faults_last(&state->residual,
                       faults_apart(y, expected, bound),
                       FAULTS_RISE_RESIDUAL,
                       bounds->residual_level);
}

/// y is away from r, as far as a loop follows r.
static inline bool faults_tracking(const faults_bounds_t *bounds, faults_loop_t *state, loop_force_t y)
{
    const bool away = faults_apart(state->followed, y, bounds->tracking);
    return faults_last(&state->tracking, away, FAULTS_RISE_LOOP, bounds->tracking_level);
}

/// Compares the travel since a position that is renewed every speed_ticks. A jump counts at once, a speed after at most two such
/// times. The position may wrap at 2^32.
static inline bool faults_speed(const faults_bounds_t *bounds, faults_state_t *state, int32_t position)
{
    if (state->speed == 0u)
    {
        state->position = position;
    }
    const int32_t travel = (int32_t)((uint32_t)position - (uint32_t)state->position);
    if (state->speed++ >= bounds->speed_ticks)
    {
        state->position = position;
        state->speed    = 1;
    }
    return bounds->travel > 0 && (travel > bounds->travel || travel < -bounds->travel);
}

static inline bool faults_command_limit(const faults_bounds_t *bounds, faults_loop_t *state, bool limited)
{
    return faults_last(&state->command_limit, limited, FAULTS_RISE_LOOP, bounds->command_limit_level);
}

#define FAULTS_CHARGE_MOST 1000000

/// Returns the steps of a swing of this size. The limit matters only if the range of u is tiny.
static inline int32_t faults_charge(const faults_swings_t *swings, scaling_rise_t size)
{
    const scaling_rise_t charge = TRIBO_EITHER(size * swings->gain, (uint32_t)((uint64_t)size * swings->gain >> 32));
    return charge < (scaling_rise_t)FAULTS_CHARGE_MOST ? (int32_t)charge : FAULTS_CHARGE_MOST;
}

/// Returns the size of the swing that ends once the signal has turned back by more than `least`; otherwise 0.
static inline scaling_rise_t faults_turn(faults_turns_t *turns, loop_force_t x, scaling_rise_t least)
{
    if (turns->falls ? x <= turns->end : x >= turns->end)
    {
        turns->end = x;
        return 0;
    }
    if ((turns->falls ? scaling_rise(turns->end, x) : scaling_rise(x, turns->end)) <= least)
    {
        return 0;
    }
    const scaling_rise_t size =
        turns->falls ? scaling_rise(turns->end, turns->begin) : scaling_rise(turns->begin, turns->end);
    turns->begin = turns->end;
    turns->end   = x;
    turns->falls = !turns->falls;
    return size;
}

/// Swings fill the level; credit for moves of r and time empty it.
static inline void faults_swing(const faults_bounds_t *bounds,
                                const faults_swings_t *swings,
                                faults_turns_t        *turns,
                                loop_force_t           x,
                                int32_t                credit)
{
    const scaling_rise_t size  = faults_turn(turns, x, swings->least);
    int32_t              level = turns->level - (turns->level > 0) + (turns->level < 0) - credit;
    if (size > 0)
    {
        level += faults_charge(swings, size);
    }
    turns->level = level < -bounds->credit_max ? -bounds->credit_max : level;
}

/// Returns the steps of the swing that has not turned yet.
static inline int32_t faults_unfinished_swing(const faults_swings_t *swings, const faults_turns_t *turns)
{
    return faults_charge(swings,
                         turns->falls ? scaling_rise(turns->end, turns->begin)
                                      : scaling_rise(turns->begin, turns->end));
}

/// Returns the steps of swings that moves of r explain, as far as a loop follows them.
static inline int32_t faults_credit(const faults_bounds_t *bounds, faults_loop_t *state, loop_force_t r)
{
    const loop_force_t before = state->followed;
    state->followed           = scaling_sum(before, scaling_times(&bounds->follow, scaling_difference(r, before)));
    state->travel +=
        state->followed > before ? scaling_rise(before, state->followed) : scaling_rise(state->followed, before);
    if (state->travel < bounds->moves_of_r.least)
    {
        return 0;
    }
    const int32_t credit = faults_charge(&bounds->moves_of_r, state->travel);
    state->travel        = 0;
    return credit;
}

/// The loop swings by itself, as a badly tuned one does.
static inline bool faults_swinging(const faults_bounds_t *bounds,
                                   faults_loop_t         *state,
                                   loop_force_t           r,
                                   loop_force_t           y,
                                   loop_force_t           u,
                                   bool                   limited)
{
    const int32_t credit = faults_credit(bounds, state, r);
    if (bounds->swing_level == 0)
    {
        return false;
    }
    faults_swing(bounds, &bounds->swings_of_u, &state->u, u, FAULTS_KICKS * credit);
    faults_swing(bounds, &bounds->swings_of_y, &state->y, y, credit);
    if (limited && state->y.level > 0)
    {
        state->y.level += FAULTS_RISE_LIMITED;
    }
    const int32_t level_of_y = state->y.level;
    return state->u.level > bounds->swing_level ||
           (level_of_y > 0 &&
            level_of_y + faults_unfinished_swing(&bounds->swings_of_y, &state->y) > bounds->swing_level);
}

static inline bool faults_reference(const faults_bounds_t *bounds, faults_state_t *state, bool renewed)
{
    return faults_in_a_row(&state->reference, !renewed, bounds->reference_ticks);
}

static inline bool faults_over_current(const faults_bounds_t *bounds, faults_state_t *state, int32_t current_ma)
{
    const int32_t most   = bounds->over_current_ma;
    const bool    beyond = most > 0 && (current_ma > most || current_ma < -most);
    return faults_last(&state->over_current, beyond, FAULTS_RISE_MEASURED, bounds->over_current_level);
}

/// A supply that cannot be measured, INT32_MAX, is beyond both bounds.
static inline bool faults_bus_voltage(const faults_bounds_t *bounds, faults_state_t *state, int32_t bus_mv)
{
    const int32_t low    = bounds->bus_low_mv;
    const int32_t high   = bounds->bus_high_mv;
    const bool    beyond = (low > 0 && (bus_mv < low || bus_mv == INT32_MAX)) || (high > 0 && bus_mv > high);
    return faults_last(&state->bus_voltage, beyond, FAULTS_RISE_MEASURED, bounds->bus_voltage_level);
}

static inline bool faults_temperature(const faults_bounds_t *bounds, faults_state_t *state, int32_t temperature_mc)
{
    const bool beyond = bounds->temperature_max_mc > 0 && temperature_mc > bounds->temperature_max_mc;
    return faults_last(&state->temperature, beyond, FAULTS_RISE_MEASURED, bounds->temperature_level);
}

/// The power stage is on but not ready.
static inline bool faults_starting(const faults_bounds_t *bounds, faults_state_t *state)
{
    return faults_in_a_row(&state->starting, true, bounds->ready_ticks);
}

#endif
