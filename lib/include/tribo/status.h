/// What a set-up function found: TRIBO_OK or the field that is wrong.
///
/// Set-up functions check every field, return the first status that applies and write nothing unless it is TRIBO_OK. Ranges are written so that
/// NaN is outside each of them. Steps return values, never a status.

#ifndef TRIBO_STATUS_H
#define TRIBO_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum
{
    TRIBO_OK = 0,
    TRIBO_ERR_NULL,                ///< a pointer argument is null
    TRIBO_ERR_SAMPLE_TIME,         ///< sample_time_s
    TRIBO_ERR_K_MIN,               ///< friction k_min
    TRIBO_ERR_K_MAX,               ///< friction k_max
    TRIBO_ERR_M,                   ///< friction m
    TRIBO_ERR_V0,                  ///< friction v0_n_per_s
    TRIBO_ERR_BREAKAWAY_OFFSET,    ///< a breakaway law's offset_n
    TRIBO_ERR_BREAKAWAY_SLOPE,     ///< a breakaway law's slope
    TRIBO_ERR_TABLE_LENGTH,        ///< breakaway table: number of points
    TRIBO_ERR_TABLE_FORCE,         ///< breakaway table: |F| not finite, negative or not strictly rising
    TRIBO_ERR_TABLE_BREAKAWAY,     ///< breakaway table: L not positive or too large
    TRIBO_ERR_SET_LEVEL,           ///< friction set_level, c1 of Eq. (9)
    TRIBO_ERR_RESET_LEVEL,         ///< friction reset_level, c2 of Eq. (9)
    TRIBO_ERR_PULSE_WIDTH,         ///< friction pulse_width_s
    TRIBO_ERR_GRAVITY,             ///< friction gravity_n
    TRIBO_ERR_INERTIA,             ///< arm inertia
    TRIBO_ERR_DAMPING,             ///< arm damping
    TRIBO_ERR_STIFFNESS,           ///< arm stiffness
    TRIBO_ERR_ARM_TOO_FAST,        ///< arm: sample_time_s too long for its stiffness or damping
    TRIBO_ERR_SECTION_COUNT,       ///< biquad cascade: number of sections
    TRIBO_ERR_SECTION_COEFFICIENT, ///< biquad cascade: a coefficient is not finite or too large
    TRIBO_ERR_SECTION_FEEDTHROUGH, ///< biquad cascade: b0 of a section is zero or too small (not biproper)
    TRIBO_ERR_SECTION_UNSTABLE,    ///< biquad cascade: a pole outside the unit circle, or two at z = 1
    TRIBO_ERR_ANTI_WINDUP,       ///< controller: no stable anti-windup (an integrator or a slow pole that a zero hides)
    TRIBO_ERR_U_MIN,             ///< controller u_min_n
    TRIBO_ERR_U_MAX,             ///< controller u_max_n
    TRIBO_ERR_GAIN,              ///< force loop gain
    TRIBO_ERR_INPUT_MAX,         ///< force loop input_max_n
    TRIBO_ERR_FULL_SCALE,        ///< q31 full_scale_n
    TRIBO_ERR_HEADROOM,          ///< q31 cascade: a node's worst-case peak has no bound or is 2^24 full scales or more
    TRIBO_ERR_BRISTLE_STIFFNESS, ///< lugre stiffness
    TRIBO_ERR_BRISTLE_DAMPING,   ///< lugre damping
    TRIBO_ERR_BRISTLE_VISCOUS,   ///< lugre viscous
    TRIBO_ERR_ACTUATOR_POLE,     ///< path actuator_pole_rad_per_s
    TRIBO_ERR_SENSOR_POLE,       ///< path sensor_pole_rad_per_s
    TRIBO_ERR_REVERSAL_WIDTH,    ///< feedforward reversal_n
    TRIBO_ERR_JUMP_TIME,         ///< feedforward jump_time_s
    TRIBO_ERR_LEAD,              ///< feedforward lead
    TRIBO_ERR_REFERENCE_NOISE,   ///< feedforward noise_gain or noise_time_s
    TRIBO_ERR_REFERENCE_RATE,    ///< feedforward rate_time_s or rate_max_n_per_s
    TRIBO_ERR_OFFSET_TIME,       ///< feedforward offset_time_s
    TRIBO_ERR_SLIDE_WIDTH,       ///< feedforward slide_width_n
    TRIBO_ERR_SLIDE_FILTER,      ///< feedforward slide_filter_time_s
    TRIBO_ERR_SLIDE_RATE,        ///< feedforward slide_rate_max_n_per_s
    TRIBO_ERR_SLIDE_RUN_IN,      ///< feedforward slide_run_in_n
    TRIBO_ERR_SLIDE_ERROR,       ///< feedforward slide_error_max_n
    TRIBO_ERR_LEARNING_SPREAD,   ///< learning spread_scale or spread_offset_n
    TRIBO_ERR_LEARNING_CORRELATION, ///< learning correlation or correlation_faded
    TRIBO_ERR_LEARNING_TRUST,       ///< learning trust or doubt
    TRIBO_ERR_LEARNING_WEIGHT,      ///< learning weight_n
    TRIBO_ERR_LEARNING_FORGETTING,  ///< learning forgetting_per_n
    TRIBO_ERR_LEARNING_BOUNDS,      ///< learning scale_min or scale_max
    TRIBO_ERR_HOLD_GAIN,            ///< hold gain
    TRIBO_ERR_HOLD_TIME,            ///< hold still_time_s or quick_time_s
    TRIBO_ERR_HOLD_MARGIN,          ///< hold margin
    TRIBO_ERR_HOLD_CAUTION,         ///< hold caution_travel_n
    TRIBO_ERR_HOLD_DEADBAND,        ///< hold deadband_time_s
    TRIBO_ERR_GUARD_TURN,           ///< guard turn_n
    TRIBO_ERR_GUARD_TIME,           ///< guard quick_time_s or fade_time_s
    TRIBO_ERR_GUARD_STRAY           ///< guard stray_n
} tribo_status_t;

/// The field that a status names and its allowed range, as one line of English, e.g.
/// "sample_time_s: 1e-6 to 0.1 s". Never null; points to constant storage.
const char *tribo_status_text(tribo_status_t status);

#ifdef __cplusplus
}
#endif

#endif
