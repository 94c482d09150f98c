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

enum
{
#define PARAMS_PLACE(type, symbol, member, name, unit, low, high, normal, status, text) PARAMS_##symbol,
    PARAMS_LOOP_FIELDS(PARAMS_PLACE)
#undef PARAMS_PLACE
        PARAMS_LOOP_COUNT
};

/// Words in this order.
typedef struct
{
    drive_config_t              drive;
    params_loop_t               loop;
    tribo_biquad_f32_section_t  sections[TRIBO_BIQUAD_SECTIONS_MAX];
    tribo_breakaway_point_f32_t table[TRIBO_BREAKAWAY_POINTS_MAX];
} params_set_t;

enum
{
    PARAMS_LOOP_AT     = (int)DRIVE_CONFIG_COUNT, ///< word of the set
    PARAMS_SECTIONS_AT = (int)PARAMS_LOOP_AT + (int)PARAMS_LOOP_COUNT,
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
    params_set_t  set;
    loop_setup_t  loop;
    drive_setup_t drive;
} params_t;

/// The default of every field: the paper's loop.
params_set_t params_default(void);

/// Makes params of params->set, checked as a whole by the library and by the drive. False with `error` for the first field
/// that is refused: then `params` are not to be used. Not for the tick.
bool params_make(params_t *params, const port_t *port, params_error_t *error);

/// Changes when the words of a set mean something else.
uint32_t params_layout(void);

#endif
