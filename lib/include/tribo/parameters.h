/// The list of the library's parameters, one row each. These rows define:
///
///     the library   defaults, range checks, tribo_status_t and its texts
///     tribo-sim     keys of scenarios with their defaults and ranges, `list --keys`, the tables of the docs
///     the drive     registers, what is stored, what crosses the wire to an emulated drive
///
/// ROW(group, symbol, member, key, unit, low, high, standard, change, number, condition, sentence)
///
///     symbol      TRIBO_ERR_<symbol> refuses it
///     member      of the group's config, a float or a uint32_t
///     key         in a scenario, behind TRIBO_KEY_<group>
///     low, high   range, inclusive; a NaN is outside. standard is the default, which is the paper's
///     change      TUNES: a drive accepts it while it runs; PROTECTS: only at rest, and once it is unlocked
///     number      register in a set of params, 0: none. tests/golden/registers.txt pins it; a new row takes the next free number
///     condition   further conditions, "" if there are none: ranges that depend on other parameters, on the sample time
///                 or, in Q31, on the full scale. The init checks them next to the list, with the same status
///
/// A new friction parameter is a row here, its use in both arithmetics and a test (CONTRIBUTING.md).

#ifndef TRIBO_PARAMETERS_H
#define TRIBO_PARAMETERS_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// clang-format off: one row a parameter

/// Members of tribo_force_loop_f32_config_t. There are three lists because a scenario has them in three groups.
#define TRIBO_SAMPLE_PARAMETERS(ROW) \
    ROW(SAMPLE, SAMPLE_TIME, sample_time_s, "sample_time_s", "s", 1e-6, 0.1, 1e-3, PROTECTS, 0x100, "", "of every tick of the control loop")

#define TRIBO_INPUT_PARAMETERS(ROW) \
    ROW(INPUT, INPUT_MAX, input_max_n, "input_max_N", "N", 1e-6, 1e6, 2.0, PROTECTS, 0x102, "q31: 1e-6 to 1 full_scale_n", "largest credible reference and measurement; beyond it an input is bad")

#define TRIBO_GAIN_PARAMETERS(ROW) \
    ROW(GAIN, GAIN, gain, "gain", "-", 0, 2, 0.85, TUNES, 0x108, "", "η of `paper`: how much of the estimated friction is fed back; 0 turns the compensation off") \
    ROW(GAIN, USUAL_FORCE, usual_force_n, "usual_force_N", "N", 0, 1e6, 0, TUNES, 0x12c, "q31: an axis' up to full_scale_n", "|F| around which the rig usually works: breakaway there sets the widths of `feedforward`; 0: a quarter of the larger |limit| of u")

/// Members of tribo_controller_f32_config_t.
#define TRIBO_LIMIT_PARAMETERS(ROW) \
    ROW(LIMIT, U_MIN, u_min_n, "u_min_N", "N", -1e6, 0, -2.0, PROTECTS, 0x104, "q31: from -full_scale_n", "lower limit of u") \
    ROW(LIMIT, U_MAX, u_max_n, "u_max_N", "N", 0, 1e6, 2.0, PROTECTS, 0x106, "over u_min_n; q31: by 1e-6 full_scale_n, up to full_scale_n", "upper limit of u, over u_min_N")

#define TRIBO_CASCADE_PARAMETERS(ROW) \
    ROW(CASCADE, SECTION_COUNT, section_count, "section_count", "-", 1, 4, 2, TUNES, 0x128, "", "second-order sections of the controller")

/// Members of tribo_friction_f32_config_t.
#define TRIBO_FRICTION_PARAMETERS(ROW) \
    ROW(FRICTION, K_MIN, k_min, "k_min", "-", 1.01, 1000, 6.0, TUNES, 0x10a, "at most k_max", "k of Eq. (5) at high net-force rates, where hysteresis is widest; at most `k_max`") \
    ROW(FRICTION, K_MAX, k_max, "k_max", "-", 1.01, 1000, 20.0, TUNES, 0x10c, "", "k of Eq. (5) at low net-force rates") \
    ROW(FRICTION, V0, v0_n_per_s, "v0_N_per_s", "N/s", 1e-6, 1e6, 0.007, TUNES, 0x110, "q31: over m full_scale_n/(6 2^31 h)", "centre of k(v)") \
    ROW(FRICTION, M, m, "m", "-", 0, 100, 3.0, TUNES, 0x10e, "", "steepness of k(v)") \
    ROW(FRICTION, SET_LEVEL, set_level, "set_level", "-", 1e-6, 1, 0.75, TUNES, 0x112, "q31: at least 2^-32 of the smallest L", "c1 of Eq. (9): where the relays set, as a fraction of L") \
    ROW(FRICTION, RESET_LEVEL, reset_level, "reset_level", "-", 1e-6, 1, 0.8, TUNES, 0x114, "", "c2 of Eq. (9): where the relays reset, as a fraction of L") \
    ROW(FRICTION, PULSE_WIDTH, pulse_width_s, "pulse_width_s", "s", 1e-6, 6.3, 0.003, TUNES, 0x116, "1 to 63 sample times", "pulse of the edge detectors; in the compensator 1 to 63 samples") \
    ROW(FRICTION, GRAVITY, gravity_n, "gravity_N", "N", -1e6, 1e6, 0, PROTECTS, 0x118, "q31: within full_scale_n", "gravity on the arm, as end-point force")

/// L(F) in each direction, in tribo_friction_f32_config_t; ignored if there is a table.
#define TRIBO_BREAKAWAY_PARAMETERS(ROW) \
    ROW(BREAKAWAY, BREAKAWAY_OFFSET, positive.offset_n, "offset_N", "N", 1e-6, 1e6, 0.007, TUNES, 0x11a, "q31: 1e-6 to under 1 full_scale_n", "L(F) = offset + slope |F|, in the positive direction") \
    ROW(BREAKAWAY, BREAKAWAY_SLOPE, positive.slope, "slope", "-", 0, 10, 0.3, TUNES, 0x11c, "", "slope of L(F) in the positive direction") \
    ROW(BREAKAWAY, BREAKAWAY_NEGATIVE_OFFSET, negative.offset_n, "negative_offset_N", "N", 1e-6, 1e6, 0.007, TUNES, 0x11e, "q31: 1e-6 to under 1 full_scale_n", "in the negative direction; in a scenario as the positive one if left out") \
    ROW(BREAKAWAY, BREAKAWAY_NEGATIVE_SLOPE, negative.slope, "negative_slope", "-", 0, 10, 0.3, TUNES, 0x120, "", "slope of L(F) in the negative direction")

#define TRIBO_TABLE_PARAMETERS(ROW) \
    ROW(TABLE, TABLE_LENGTH, table_length, "table_length", "-", 0, 32, 0, TUNES, 0x12a, "with a table at least 1, without one 0", "points of the breakaway table; 0: offset and slope")

/// Members of tribo_arm_f32_config_t.
#define TRIBO_ARM_PARAMETERS(ROW) \
    ROW(ARM, STIFFNESS, stiffness, "stiffness_N_per_deg", "N/deg", 1e-12, 1e12, 3.84, PROTECTS, 0x126, "", "K of Eq. (2)") \
    ROW(ARM, DAMPING, damping, "damping_N_s_per_deg", "N s/deg", 0, 1e12, 0.0288, PROTECTS, 0x124, "q31: enough for quantised poles inside the unit circle", "b of Eq. (2)") \
    ROW(ARM, INERTIA, inertia, "inertia_N_s2_per_deg", "N s²/deg", 1e-12, 1e12, 1.2e-4, PROTECTS, 0x122, "", "I of Eq. (2)")

/// Members of tribo_feedforward_f32_config_t. docs/feedforward.md explains how a derived value follows from the rig.
#define TRIBO_FEEDFORWARD_PARAMETERS(ROW) \
    ROW(FEEDFORWARD, ACTUATOR_POLE, actuator_pole_rad_per_s, "actuator_pole_rad_per_s", "rad/s", 1e-3, 1e6, 200.0, TUNES, 0x200, "times sample time 1e-9 to 50; q31: with the arm's lag under 65536 sample times", "pole of the actuator") \
    ROW(FEEDFORWARD, SENSOR_POLE, sensor_pole_rad_per_s, "sensor_pole_rad_per_s", "rad/s", 1e-3, 1e6, 55.0, TUNES, 0x202, "times sample time 1e-9 to 50", "pole of the sensor") \
    ROW(FEEDFORWARD, REVERSAL_WIDTH, reversal_n, "reversal_N", "N", 0, 1e6, 0, TUNES, 0x204, "0 or at least 1e-9; q31: 1e-6 to 0.25 full_scale_n", "w: r has reversed once it has come back by w; the error at a reversal is at least about w; 0: derived, 1/314 of the breakaway") \
    ROW(FEEDFORWARD, PRESLIDING, presliding_n, "presliding_N", "N", 0, 1e6, 0, TUNES, 0x206, "0 or at least 1e-9; q31: 1e-4 to 0.25 full_scale_n", "travel of F over which friction builds up, at most a quarter of the swing of r; 0: derived, 1/11 of the breakaway") \
    ROW(FEEDFORWARD, JUMP_TIME, jump_time_s, "jump_time_s", "s", 0, 1e3, 0, TUNES, 0x208, "", "time in which friction changes its sign at a reversal; 0: derived, 2.1 times the lag from u to F") \
    ROW(FEEDFORWARD, JUMP_LEAD, jump_lead, "jump_lead", "-", 0, 1, 0.7, TUNES, 0x20a, "", "part of the actuator's lag by which a jump of friction leads; 0.9 would err where the actuator is faster than configured") \
    ROW(FEEDFORWARD, TRUST, trust, "trust", "-", 0, 1, 0.5, TUNES, 0x20c, "", "part of the configured breakaway that is fed forward before anything is learned") \
    ROW(FEEDFORWARD, FORGETTING, forgetting_per_n, "forgetting_per_N", "1/N", 0, 1e6, 0, TUNES, 0x20e, "", "part of the prior variance that returns per newton travelled; ten times the derived one for friction that drifts; 0: derived, 0.0157 divided by the breakaway") \
    ROW(FEEDFORWARD, STILL_TIME, still_time_s, "still_time_s", "s", 0, 1e3, 0.2, TUNES, 0x210, "", "r is at rest once it has not moved for that long; 0: never, without feedback of friction at rest")

/// Members of tribo_sensorless_f32_config_t.
#define TRIBO_SENSORLESS_PARAMETERS(ROW) \
    ROW(SENSORLESS, BELIEF, belief, "belief", "-", 0, 1, 0.9, TUNES, 0x212, "", "part of the configured breakaway that is fed forward without a sensor: low, because too much can be worse than none")

/// Members of tribo_guard_f32_config_t.
#define TRIBO_GUARD_PARAMETERS(ROW) \
    ROW(GUARD, GUARD_TURN, turn_n, "turn_N", "N", 1e-9, 1e6, 0.05, TUNES, 0x2e2, "q31: 1e-6 to under 1 full_scale_n", "the added friction turns when it comes back by that much: about a third of the breakaway") \
    ROW(GUARD, GUARD_QUICK_TIME, quick_time_s, "quick_time_s", "s", 1e-6, 1e3, 0.2, TUNES, 0x2e4, "up to 1e5 samples", "turns closer than that may be hunting; up to 100,000 samples") \
    ROW(GUARD, GUARD_STRAY, stray_n, "stray_N", "N", 1e-9, 1e6, 0.01, TUNES, 0x2e6, "q31: 1e-6 to under 1 full_scale_n", "excess of an overshoot over the lag: about a fifteenth of the breakaway, and over twice the peaks of noise") \
    ROW(GUARD, GUARD_FADE_TIME, fade_time_s, "fade_time_s", "s", 1e-6, 1e3, 0.5, TUNES, 0x2e8, "up to 1e6 samples", "time in which the added friction fades out; up to 1,000,000 samples")

/// An argument of every Q31 init.
#define TRIBO_SCALE_PARAMETERS(ROW) \
    ROW(SCALE, FULL_SCALE, full_scale_n, "full_scale_N", "N", 1e-3, 1e6, 2.0, PROTECTS, 0, "", "what 2^31 stands for in Q31: every force of the loop fits into it, better twice; in f32 only what chatter is measured by")

/// The numbers of an element of a list, tribo_biquad_f32_section_t or tribo_breakaway_point_f32_t:
/// ELEMENT(symbol, member, key, unit, low, high, sentence).
#define TRIBO_SECTION_ELEMENTS(ELEMENT) \
    ELEMENT(SECTION_COEFFICIENT, b0, "b0", "-", -1e6, 1e6, "numerator b0 d² + b1 d + b2 with d = z − 1; with a scenario's kind z alone b0 + b1 z⁻¹ + b2 z⁻²; b0 not 0") \
    ELEMENT(SECTION_COEFFICIENT, b1, "b1", "-", -1e6, 1e6, "numerator") \
    ELEMENT(SECTION_COEFFICIENT, b2, "b2", "-", -1e6, 1e6, "numerator") \
    ELEMENT(SECTION_COEFFICIENT, a1, "a1", "-", -4, 4, "denominator d² + a1 d + a2; with a scenario's kind z alone 1 + a1 z⁻¹ + a2 z⁻²; stable") \
    ELEMENT(SECTION_COEFFICIENT, a2, "a2", "-", -4, 4, "denominator")

#define TRIBO_POINT_ELEMENTS(ELEMENT) \
    ELEMENT(TABLE_FORCE, force_n, "force_N", "N", 0, 1e6, "a point's applied force |F|, strictly rising from point to point") \
    ELEMENT(TABLE_POSITIVE, positive_n, "positive_N", "N", 1e-6, 1e6, "L in the positive direction there") \
    ELEMENT(TABLE_NEGATIVE, negative_n, "negative_N", "N", 1e-6, 1e6, "L in the negative direction there")

/// Further refusals, which concern several parameters: REFUSAL(symbol, key, text).
#define TRIBO_REFUSALS(REFUSAL) \
    REFUSAL(ARM_TOO_FAST, "compensator.arm", "arm: stiffness h^2/inertia 1e-9 to 1e4 and damping h/inertia at most 1e4; q31: coefficients below 4") \
    REFUSAL(SECTION_COEFFICIENT, "controller.sections", "controller section coefficient: b0, b1 and b2 -1e6 to 1e6, a1 and a2 -4 to 4") \
    REFUSAL(SECTION_FEEDTHROUGH, "controller.sections", "controller section b0: magnitude 1e-6 to 1e6, so that the cascade is biproper") \
    REFUSAL(SECTION_UNSTABLE, "controller.sections", "controller section poles: inside the unit circle, or one of them at z = 1") \
    REFUSAL(ANTI_WINDUP, "controller.sections", "controller cascade: no pole at z = 1, nor a slow one, that a zero hides") \
    REFUSAL(HEADROOM, "controller.sections", "controller cascade: worst-case peak below 2^24 full scales at every node") \
    REFUSAL(TABLE_FORCE, "compensator.friction.breakaway.table", "friction table force_n: 0 to 1e6 N, strictly rising; q31: under full_scale_n") \
    REFUSAL(TABLE_POSITIVE, "compensator.friction.breakaway.table", "friction table positive_n: 1e-6 to 1e6 N; q31: 1e-6 to under 1 full_scale_n") \
    REFUSAL(TABLE_NEGATIVE, "compensator.friction.breakaway.table", "friction table negative_n: 1e-6 to 1e6 N; q31: 1e-6 to under 1 full_scale_n") \
    REFUSAL(PAPER_SAMPLE_TIME, "sample_time_s", "sample_time_s: 0.001 s with the sections of the paper's controller, which are made for it; another needs sections of its own") \
    REFUSAL(CONTROLLER, "controller", "controller: one of tribo_pi, tribo_sections, tribo_paper and tribo_own; of a loop one of pi and sections") \
    REFUSAL(PI, "controller", "controller kp, ki_per_s: kp 1e-6 to 1e5, ki_per_s 0 to 1e5 1/s and times sample_time_s at most 2 kp; if not 0, times sample_time_s over 1e-8 kp, q31: over 1.2e-7 kp") \
    REFUSAL(AXIS_LAG, "compensator.arm", "arm_lag_s: 0 to 1000 sample times") \
    REFUSAL(AXIS_NOISE, "", "noise_n: 0 to 1e6 N") \
    REFUSAL(AXIS_ORDER, "", "order of calls: the init comes first, and prepare before change, never of the params in use") \
    REFUSAL(BLOB_VERSION, "", "blob version: of another version or arithmetic of tribo") \
    REFUSAL(BLOB_CHECKSUM, "", "blob checksum: not of these bytes") \
    REFUSAL(BLOB_RIG, "", "blob rig: learned with another config, whose breakaway, gravity_n or presliding_n it refers to") \
    REFUSAL(JOINT_EFFORT, "", "joint effort_max: 1e-6 to 1e6") \
    REFUSAL(JOINT_TRAVEL, "", "joint travel: 1e-9 to 1e6; q31: 1 to 1e4 counts") \
    REFUSAL(JOINT_BREAKAWAY, "", "joint breakaway: 0 to effort_max") \
    REFUSAL(JOINT_POLE, "", "joint actuator_pole_rad_per_s: 1e-3 to 1e6 rad/s, or 0") \
    REFUSAL(JOINT_GAIN, "", "joint gain: 0 to 1, of the learned friction") \
    REFUSAL(JOINT_WRAP, "", "joint wrap: 0, or from 100 travel to 1e9; q31: whole counts") \
    REFUSAL(PART, "", "method, guard: of the other arithmetic; tribo_feedforward_q31_use and tribo_guard_q31_use for a loop in Q31") \
    REFUSAL(MEMORY, "", "state.memory: null, but the params name a method; the memory of that method, before the start") \
    REFUSAL(AXIS_BREAKAWAY, "", "breakaway at usual_force_n: q31: 0.0011 to 2.75 full_scale_n, or presliding_n and reversal_n given")

/// All rows.
#define TRIBO_PARAMETERS(ROW) \
    TRIBO_SAMPLE_PARAMETERS(ROW) \
    TRIBO_INPUT_PARAMETERS(ROW) \
    TRIBO_LIMIT_PARAMETERS(ROW) \
    TRIBO_SCALE_PARAMETERS(ROW) \
    TRIBO_CASCADE_PARAMETERS(ROW) \
    TRIBO_GAIN_PARAMETERS(ROW) \
    TRIBO_BREAKAWAY_PARAMETERS(ROW) \
    TRIBO_TABLE_PARAMETERS(ROW) \
    TRIBO_ARM_PARAMETERS(ROW) \
    TRIBO_FRICTION_PARAMETERS(ROW) \
    TRIBO_FEEDFORWARD_PARAMETERS(ROW) \
    TRIBO_GUARD_PARAMETERS(ROW) \
    TRIBO_SENSORLESS_PARAMETERS(ROW)
// clang-format on

/// For each group, the prefix of its keys in a scenario and the prefix of its members in a text.
#define TRIBO_KEY_SAMPLE        ""
#define TRIBO_KEY_INPUT         "limits."
#define TRIBO_KEY_LIMIT         "limits."
#define TRIBO_KEY_SCALE         "limits."
#define TRIBO_KEY_CASCADE       "controller."
#define TRIBO_KEY_GAIN          "compensator."
#define TRIBO_KEY_BREAKAWAY     "compensator.friction.breakaway."
#define TRIBO_KEY_TABLE         "compensator.friction.breakaway."
#define TRIBO_KEY_ARM           "compensator.arm."
#define TRIBO_KEY_FRICTION      "compensator.friction."
#define TRIBO_KEY_FEEDFORWARD   "compensator.feedforward."
#define TRIBO_KEY_GUARD         "compensator.guard."
#define TRIBO_KEY_SENSORLESS    "compensator.sensorless."
#define TRIBO_TITLE_SAMPLE      ""
#define TRIBO_TITLE_INPUT       "force loop "
#define TRIBO_TITLE_LIMIT       "controller "
#define TRIBO_TITLE_SCALE       ""
#define TRIBO_TITLE_CASCADE     "controller "
#define TRIBO_TITLE_GAIN        "force loop "
#define TRIBO_TITLE_BREAKAWAY   "friction breakaway "
#define TRIBO_TITLE_TABLE       "friction breakaway "
#define TRIBO_TITLE_ARM         "arm "
#define TRIBO_TITLE_FRICTION    "friction "
#define TRIBO_TITLE_FEEDFORWARD "feedforward "
#define TRIBO_TITLE_GUARD       "guard "
#define TRIBO_TITLE_SENSORLESS  "sensorless "

/// The values of `change`.
#define TRIBO_TUNES    0
#define TRIBO_PROTECTS 1

/// The part of a row that a program needs to check and convert a value, without the texts.
typedef struct
{
    float    low, high, standard;
    uint16_t at;       ///< offset of the member in its config
    uint16_t number;   ///< register, 0: none
    uint8_t  status;   ///< tribo_status_t
    uint8_t  is_whole; ///< 1: a uint32_t, else a float
    uint8_t  protects; ///< 1: PROTECTS
} tribo_parameter_t;

/// A member of a config for each row.
#define TRIBO_FLOAT_MEMBER(group, symbol, member, ...) float member;

// NOLINTNEXTLINE(bugprone-macro-parentheses): a summand
#define TRIBO_PARAMETER_ONE(...)    +1
#define TRIBO_PARAMETER_COUNT(list) (0 list(TRIBO_PARAMETER_ONE))

/// One table for each config. Breakaway has its own, which is ignored if there is a breakaway table.
extern const tribo_parameter_t tribo_loop_parameters[4]; ///< sample_time_s, input_max_n, gain, usual_force_n
extern const tribo_parameter_t tribo_limit_parameters[TRIBO_PARAMETER_COUNT(TRIBO_LIMIT_PARAMETERS)];
extern const tribo_parameter_t tribo_cascade_parameters[TRIBO_PARAMETER_COUNT(TRIBO_CASCADE_PARAMETERS)];
extern const tribo_parameter_t tribo_friction_parameters[TRIBO_PARAMETER_COUNT(TRIBO_FRICTION_PARAMETERS)];
extern const tribo_parameter_t tribo_breakaway_parameters[TRIBO_PARAMETER_COUNT(TRIBO_BREAKAWAY_PARAMETERS)];
extern const tribo_parameter_t tribo_table_parameters[TRIBO_PARAMETER_COUNT(TRIBO_TABLE_PARAMETERS)];
extern const tribo_parameter_t tribo_arm_parameters[TRIBO_PARAMETER_COUNT(TRIBO_ARM_PARAMETERS)];
extern const tribo_parameter_t tribo_feedforward_parameters[TRIBO_PARAMETER_COUNT(TRIBO_FEEDFORWARD_PARAMETERS)];
extern const tribo_parameter_t tribo_guard_parameters[TRIBO_PARAMETER_COUNT(TRIBO_GUARD_PARAMETERS)];
extern const tribo_parameter_t tribo_sensorless_parameters[TRIBO_PARAMETER_COUNT(TRIBO_SENSORLESS_PARAMETERS)];

#ifdef __cplusplus
}
#endif

#endif
