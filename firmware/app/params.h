/// All that a drive can be told without a rebuild, as one set: its config (config.h), and the loop's in physical units and
/// single precision. A set is 32-bit words, so that a bus or a store needs no notion of its fields, and is checked as a whole.

#ifndef DRIVE_PARAMS_H
#define DRIVE_PARAMS_H

#include "app/drive.h"
#include "app/loop_setup.h"

#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

/// FIELD(type, symbol, member, name, unit, low, high, default, status, text): the loop's fields. `member` is of
/// tribo_force_loop_f32_config_t, `name` is a key of a scenario (host_sim/scenarios) or an extension of one, `status` is the
/// library's refusal of it. The list is the only place that knows them; new ones go to its end, so that registers stay.
// clang-format off: one row a field
#define PARAMS_LOOP_FIELDS(FIELD) \
    FIELD(float, sample_time, sample_time_s, "sample_time_s", "s", 1e-6f, 0.1f, 1e-3f, SAMPLE_TIME, "of every tick; that of drive.period_us") \
    FIELD(float, input_max, input_max_n, "limits.input_max_N", "N", 1e-6f, 1e6f, 2.0f, INPUT_MAX, "largest credible reference and measurement") \
    FIELD(float, u_min, controller.u_min_n, "limits.u_min_N", "N", -1e6f, 0.0f, -2.0f, U_MIN, "limit of u") \
    FIELD(float, u_max, controller.u_max_n, "limits.u_max_N", "N", 0.0f, 1e6f, 2.0f, U_MAX, "limit of u, over u_min_N") \
    FIELD(float, gain, gain, "compensator.gain", "", 0.0f, 2.0f, 0.85f, GAIN, "how much of the estimated friction is fed back; 0: none") \
    FIELD(float, k_min, compensator.friction.k_min, "compensator.friction.k_min", "", 1.01f, 1000.0f, 6.0f, K_MIN, "k at high net-force rates, at most k_max") \
    FIELD(float, k_max, compensator.friction.k_max, "compensator.friction.k_max", "", 1.01f, 1000.0f, 20.0f, K_MAX, "k at low net-force rates") \
    FIELD(float, m, compensator.friction.m, "compensator.friction.m", "", 0.0f, 100.0f, 3.0f, M, "steepness of k(v)") \
    FIELD(float, v0, compensator.friction.v0_n_per_s, "compensator.friction.v0_N_per_s", "N/s", 1e-6f, 1e6f, 0.007f, V0, "centre of k(v)") \
    FIELD(float, set_level, compensator.friction.set_level, "compensator.friction.set_level", "", 1e-6f, 1.0f, 0.75f, SET_LEVEL, "where the relays set, as a fraction of L") \
    FIELD(float, reset_level, compensator.friction.reset_level, "compensator.friction.reset_level", "", 1e-6f, 1.0f, 0.8f, RESET_LEVEL, "where the relays reset, as a fraction of L") \
    FIELD(float, pulse_width, compensator.friction.pulse_width_s, "compensator.friction.pulse_width_s", "s", 1e-6f, 6.3f, 0.003f, PULSE_WIDTH, "of the edge detectors, 1 to 63 samples") \
    FIELD(float, gravity, compensator.friction.gravity_n, "compensator.friction.gravity_N", "N", -1e6f, 1e6f, 0.0f, GRAVITY, "on the arm, as end-point force") \
    FIELD(float, offset_up, compensator.friction.positive.offset_n, "compensator.friction.breakaway.offset_N", "N", 1e-6f, 1e6f, 0.007f, BREAKAWAY_OFFSET, "L(F) = offset + slope |F|, in the positive direction") \
    FIELD(float, slope_up, compensator.friction.positive.slope, "compensator.friction.breakaway.slope", "", 0.0f, 10.0f, 0.3f, BREAKAWAY_SLOPE, "likewise") \
    FIELD(float, offset_down, compensator.friction.negative.offset_n, "compensator.friction.breakaway.negative_offset_N", "N", 1e-6f, 1e6f, 0.007f, BREAKAWAY_OFFSET, "in the negative direction") \
    FIELD(float, slope_down, compensator.friction.negative.slope, "compensator.friction.breakaway.negative_slope", "", 0.0f, 10.0f, 0.3f, BREAKAWAY_SLOPE, "likewise") \
    FIELD(float, inertia, compensator.arm.inertia, "compensator.arm.inertia_N_s2_per_deg", "N s2/deg", 1e-12f, 1e12f, 1.2e-4f, INERTIA, "of the arm") \
    FIELD(float, damping, compensator.arm.damping, "compensator.arm.damping_N_s_per_deg", "N s/deg", 0.0f, 1e12f, 0.0288f, DAMPING, "of the arm") \
    FIELD(float, stiffness, compensator.arm.stiffness, "compensator.arm.stiffness_N_per_deg", "N/deg", 1e-12f, 1e12f, 3.84f, STIFFNESS, "of the arm") \
    FIELD(uint32_t, section_count, controller.section_count, "controller.section_count", "", 1, 4, 2, SECTION_COUNT, "second-order sections of the controller") \
    FIELD(uint32_t, table_length, compensator.friction.table_length, "compensator.friction.breakaway.table_length", "", 0, 32, 0, TABLE_LENGTH, "points of the breakaway table; 0: offset and slope")

// clang-format on

/// The same of tribo_feedforward_f32_config_t, of a loop whose compensator.method is 1. None in a drive without it.
// clang-format off: one row a field
#if DRIVE_FEEDFORWARD
#define PARAMS_FEED_FIELDS(FIELD) \
    FIELD(float, actuator_pole, actuator_pole_rad_per_s, "compensator.feedforward.actuator_pole_rad_per_s", "rad/s", 1e-3f, 1e6f, 200.0f, ACTUATOR_POLE, "what the loop believes of the actuator") \
    FIELD(float, sensor_pole, sensor_pole_rad_per_s, "compensator.feedforward.sensor_pole_rad_per_s", "rad/s", 1e-3f, 1e6f, 55.0f, SENSOR_POLE, "and of the sensor") \
    FIELD(float, reversal, reversal_n, "compensator.feedforward.reversal_N", "N", 1e-9f, 1e6f, 0.5e-3f, REVERSAL_WIDTH, "w: r has turned when it has come back by that much; the error at a reversal is at least about w") \
    FIELD(float, jump_time, jump_time_s, "compensator.feedforward.jump_time_s", "s", 1e-6f, 1e3f, 0.02f, JUMP_TIME, "over which friction changes sign at a reversal") \
    FIELD(float, lead, lead, "compensator.feedforward.lead", "", 0.0f, 1.0f, 1.0f, LEAD, "share of the lag from u to F that the rate of r makes up for; 0: no rate is used") \
    FIELD(float, noise_gain, noise_gain, "compensator.feedforward.noise_gain", "", 0.0f, 8.0f, 4.0f, REFERENCE_NOISE, "widens reversal_N by the noise of r; 0 for a clean r") \
    FIELD(float, noise_time, noise_time_s, "compensator.feedforward.noise_time_s", "s", 1e-6f, 1e3f, 0.25f, REFERENCE_NOISE, "over which the noise of r is averaged") \
    FIELD(float, rate_time, rate_time_s, "compensator.feedforward.rate_time_s", "s", 1e-6f, 1e3f, 0.01f, REFERENCE_RATE, "filter of the rate of r") \
    FIELD(float, rate_max, rate_max_n_per_s, "compensator.feedforward.rate_max_N_per_s", "N/s", 1e-6f, 1e9f, 2.0f, REFERENCE_RATE, "a faster r is a step") \
    FIELD(float, offset_time, offset_time_s, "compensator.feedforward.offset_time_s", "s", 1e-6f, 1e3f, 5.0f, OFFSET_TIME, "with which the offset leaks away") \
    FIELD(float, slide_width, slide_width_n, "compensator.feedforward.slide_width_N", "N", 1e-9f, 1e6f, 3e-3f, SLIDE_WIDTH, "tells travel of y from its noise") \
    FIELD(float, slide_filter_time, slide_filter_time_s, "compensator.feedforward.slide_filter_time_s", "s", 1e-6f, 10.0f, 0.02f, SLIDE_FILTER, "of friction meter and slide detector") \
    FIELD(float, slide_rate_max, slide_rate_max_n_per_s, "compensator.feedforward.slide_rate_max_N_per_s", "N/s", 1e-6f, 1e9f, 0.5f, SLIDE_RATE, "nothing is learned from a faster y") \
    FIELD(float, slide_run_in, slide_run_in_n, "compensator.feedforward.slide_run_in_N", "N", 1e-9f, 1e6f, 5e-3f, SLIDE_RUN_IN, "travelled before learning begins") \
    FIELD(float, slide_error_max, slide_error_max_n, "compensator.feedforward.slide_error_max_N", "N", 1e-9f, 1e6f, 1e-3f, SLIDE_ERROR, "nothing is learned with a larger filtered error") \
    FIELD(float, learning_spread_scale, learning.spread_scale, "compensator.feedforward.learning.spread_scale", "", 1e-3f, 2.0f, 0.4f, LEARNING_SPREAD, "how far off the believed breakaway may be as a factor: standard deviation; in Q31 at most 1") \
    FIELD(float, learning_spread_offset, learning.spread_offset_n, "compensator.feedforward.learning.spread_offset_N", "N", 1e-9f, 1e6f, 0.01f, LEARNING_SPREAD, "and as an offset") \
    FIELD(float, learning_correlation, learning.correlation, "compensator.feedforward.learning.correlation", "", 0.0f, 0.99f, 0.7f, LEARNING_CORRELATION, "of the directions before anything is learned") \
    FIELD(float, learning_correlation_faded, learning.correlation_faded, "compensator.feedforward.learning.correlation_faded", "", 0.0f, 0.99f, 0.1f, LEARNING_CORRELATION, "and once forgotten") \
    FIELD(float, learning_trust, learning.trust, "compensator.feedforward.learning.trust", "", 0.0f, 1.0f, 0.5f, LEARNING_TRUST, "share of the believed breakaway that is fed forward before anything is learned") \
    FIELD(float, learning_doubt, learning.doubt, "compensator.feedforward.learning.doubt", "", 1e-3f, 1.0f, 1.0f, LEARNING_TRUST, "what is left of that doubt to begin with: 1, or less where the believed breakaway has itself been learned") \
    FIELD(float, learning_weight, learning.weight_n, "compensator.feedforward.learning.weight_N", "N", 1e-9f, 1e6f, 2e-4f, LEARNING_WEIGHT, "travel over which noise averages out; larger is slower") \
    FIELD(float, learning_forgetting, learning.forgetting_per_n, "compensator.feedforward.learning.forgetting_per_N", "1/N", 0.0f, 1e6f, 0.1f, LEARNING_FORGETTING, "share of the first doubt that comes back per newton; 1 for friction that drifts") \
    FIELD(float, learning_scale_min, learning.scale_min, "compensator.feedforward.learning.scale_min", "", 1e-3f, 1.0f, 0.2f, LEARNING_BOUNDS, "what is learned stays above this share of the believed breakaway") \
    FIELD(float, learning_scale_max, learning.scale_max, "compensator.feedforward.learning.scale_max", "", 1.0f, 10.0f, 3.0f, LEARNING_BOUNDS, "and below this multiple") \
    FIELD(float, hold_gain, hold.gain, "compensator.feedforward.hold.gain", "", 0.0f, 0.99f, 0.95f, HOLD_GAIN, "E: friction fed back while r stands; 0: never") \
    FIELD(float, hold_still_time, hold.still_time_s, "compensator.feedforward.hold.still_time_s", "s", 1e-6f, 1e3f, 1.5f, HOLD_TIME, "r stands when it has for that long") \
    FIELD(float, hold_margin, hold.margin, "compensator.feedforward.hold.margin", "", 0.1f, 1.0f, 0.85f, HOLD_MARGIN, "of the learned breakaway, that is fed back") \
    FIELD(float, hold_quick_time, hold.quick_time_s, "compensator.feedforward.hold.quick_time_s", "s", 1e-6f, 1e3f, 0.2f, HOLD_TIME, "changes of side within that time are chatter, and make it cautious") \
    FIELD(float, hold_caution_travel, hold.caution_travel_n, "compensator.feedforward.hold.caution_travel_N", "N", 1e-9f, 1e6f, 0.1f, HOLD_CAUTION, "learning over which caution fades") \
    FIELD(float, hold_deadband_time, hold.deadband_time_s, "compensator.feedforward.hold.deadband_time_s", "s", 1e-6f, 1e3f, 0.3f, HOLD_DEADBAND, "filters of the deadband that keeps noise of y from moving u")

/// The same of tribo_guard_f32_config_t, after whether it is on.
#define PARAMS_GUARD_FIELDS(FIELD) \
    FIELD(float, turn, turn_n, "compensator.guard.turn_N", "N", 1e-9f, 1e6f, 0.05f, GUARD_TURN, "what is added turns when it comes back by that much: about a third of the breakaway") \
    FIELD(float, quick_time, quick_time_s, "compensator.guard.quick_time_s", "s", 1e-6f, 1e3f, 0.2f, GUARD_TIME, "turns that are closer may be hunting; up to 100,000 samples") \
    FIELD(float, stray, stray_n, "compensator.guard.stray_N", "N", 1e-9f, 1e6f, 0.01f, GUARD_STRAY, "of an overshoot: about a fifteenth of the breakaway, and over twice the peaks of noise") \
    FIELD(float, fade_time, fade_time_s, "compensator.guard.fade_time_s", "s", 1e-6f, 1e3f, 0.5f, GUARD_TIME, "within which it fades")
#else
#define PARAMS_FEED_FIELDS(FIELD)
#endif
// clang-format on

/// A member of each element of the two lists that follow: FIELD(member, name, unit, low, high, text).
#define PARAMS_SECTION_FIELDS(FIELD)                                                                                   \
    FIELD(b0, "b0", "", -1e6f, 1e6f, "numerator b0 d^2 + b1 d + b2 with d = z - 1; b0 not 0")                          \
    FIELD(b1, "b1", "", -1e6f, 1e6f, "likewise")                                                                       \
    FIELD(b2, "b2", "", -1e6f, 1e6f, "likewise")                                                                       \
    FIELD(a1, "a1", "", -4.0f, 4.0f, "denominator d^2 + a1 d + a2; stable")                                            \
    FIELD(a2, "a2", "", -4.0f, 4.0f, "likewise")

#define PARAMS_POINT_FIELDS(FIELD)                                                                                     \
    FIELD(force_n, "force_N", "N", 0.0f, 1e6f, "applied force |F|, strictly rising from point to point")               \
    FIELD(positive_n, "positive_N", "N", 1e-6f, 1e6f, "L in the positive direction there")                             \
    FIELD(negative_n, "negative_N", "N", 1e-6f, 1e6f, "L in the negative direction there")

typedef struct
{
#define PARAMS_MEMBER(type, symbol, member, name, unit, low, high, normal, status, text) type symbol; ///< see the list
    PARAMS_LOOP_FIELDS(PARAMS_MEMBER)
#undef PARAMS_MEMBER
} params_loop_t;

#if DRIVE_FEEDFORWARD
typedef struct
{
#define PARAMS_MEMBER(type, symbol, member, name, unit, low, high, normal, status, text) type symbol; ///< see the list
    PARAMS_FEED_FIELDS(PARAMS_MEMBER)
#undef PARAMS_MEMBER
} params_feed_t;

typedef struct
{
    uint32_t on; ///< 1: there is a guard
#define PARAMS_MEMBER(type, symbol, member, name, unit, low, high, normal, status, text) type symbol; ///< see the list
    PARAMS_GUARD_FIELDS(PARAMS_MEMBER)
#undef PARAMS_MEMBER
} params_guard_t;
#endif

enum
{
#if DRIVE_FEEDFORWARD
    PARAMS_GUARD_on,
#define PARAMS_PLACE(type, symbol, member, name, unit, low, high, normal, status, text) PARAMS_GUARD_##symbol,
    PARAMS_GUARD_FIELDS(PARAMS_PLACE)
#undef PARAMS_PLACE
#endif
        PARAMS_GUARD_COUNT
};

#define PARAMS_GUARD_TEXT                                                                                              \
    "1: friction compensation that makes the loop hunt or overshoot is faded, until it is restored"

enum
{
#define PARAMS_PLACE(type, symbol, member, name, unit, low, high, normal, status, text) PARAMS_FEED_##symbol,
    PARAMS_FEED_FIELDS(PARAMS_PLACE)
#undef PARAMS_PLACE
        PARAMS_FEED_COUNT
};

enum
{
#define PARAMS_PLACE(type, symbol, member, name, unit, low, high, normal, status, text) PARAMS_##symbol,
    PARAMS_LOOP_FIELDS(PARAMS_PLACE)
#undef PARAMS_PLACE
        PARAMS_LOOP_COUNT
};

#define PARAMS_METHOD_PAPER       0u ///< fed back with compensator.gain; 0 turns it off
#define PARAMS_METHOD_FEEDFORWARD 1u
#define PARAMS_METHOD_OFF         2u // without the feed-forward: a gain of 0
#define PARAMS_METHOD_MAX         (DRIVE_FEEDFORWARD ? PARAMS_METHOD_OFF : PARAMS_METHOD_PAPER)
#define PARAMS_METHOD_TEXT        "0: fed back with compensator.gain, as the paper does; 1: fed forward; 2: off"

/// Words in this order.
typedef struct
{
    drive_config_t drive;
    params_loop_t  loop;
    uint32_t       method; ///< PARAMS_METHOD_: how friction is compensated
#if DRIVE_FEEDFORWARD
    params_feed_t  feed;
    params_guard_t guard;
#endif
    tribo_biquad_f32_section_t  sections[TRIBO_BIQUAD_SECTIONS_MAX];
    tribo_breakaway_point_f32_t table[TRIBO_BREAKAWAY_POINTS_MAX];
} params_set_t;

enum
{
    PARAMS_LOOP_AT     = DRIVE_CONFIG_COUNT, ///< word of the set
    PARAMS_METHOD_AT   = PARAMS_LOOP_AT + PARAMS_LOOP_COUNT,
    PARAMS_FEED_AT     = PARAMS_METHOD_AT + 1,
    PARAMS_GUARD_AT    = PARAMS_FEED_AT + PARAMS_FEED_COUNT,
    PARAMS_SECTIONS_AT = PARAMS_GUARD_AT + PARAMS_GUARD_COUNT,
    PARAMS_TABLE_AT    = PARAMS_SECTIONS_AT + 5 * (int)TRIBO_BIQUAD_SECTIONS_MAX,
    PARAMS_WORDS       = PARAMS_TABLE_AT + 3 * (int)TRIBO_BREAKAWAY_POINTS_MAX
};

_Static_assert(sizeof(params_set_t) == PARAMS_WORDS * sizeof(uint32_t), "a set is words without gaps");

/// Why a set is refused: the word of the field to change, its value and the range that is allowed.
typedef struct
{
    uint32_t       word;
    float          value, low, high;
    tribo_status_t status; ///< of the library, which says more than the range where fields depend on each other
} params_error_t;

/// A set and what a drive runs with. Not to be moved once made.
typedef struct
{
    union
    {
        params_set_t set;
        uint32_t     words[PARAMS_WORDS];
    };
    loop_setup_t  loop;
    drive_setup_t drive;
} params_t;

/// The default of every field: the paper's loop.
params_set_t params_default(void);

/// Takes over what `config` says of the loop, with its sections and its table, and `feedforward`; null: the paper's method.
void params_take_loop(params_set_t                         *set,
                      const tribo_force_loop_f32_config_t  *config,
                      const tribo_feedforward_f32_config_t *feedforward);

#if DRIVE_FEEDFORWARD
/// The guard of `config`; null: none.
void params_take_guard(params_set_t *set, const tribo_guard_f32_config_t *config);
#endif

/// Makes params of params->set, checked as a whole by the library and by the drive. False with `error` for the first field
/// that is refused: then `params` are not to be used. Not for the tick.
bool params_make(params_t *params, const port_t *port, params_error_t *error);

/// Differs if the words of a set mean something else: CRC-32 of all names of the lists, and one less without the feed-forward.
/// Names are not in an image, so test_registers.c computes it and fails if a list has changed.
#define PARAMS_LAYOUT_OF(feeds_forward) (0x68b7191fu - ((feeds_forward) ? 0u : 1u))
#define PARAMS_LAYOUT                   PARAMS_LAYOUT_OF(DRIVE_FEEDFORWARD)

#endif
