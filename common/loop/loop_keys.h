/// The loop of a file, in physical units: reference, controller, compensator and limits, which the simulator and a drive
/// both read. tribo/parameters.h has the keys, units, ranges and defaults of the library's parameters; loop_keys.c has the
/// others.

#ifndef COMMON_LOOP_KEYS_H
#define COMMON_LOOP_KEYS_H

#include "keys/key.h"
#include "tribo/status.h"

/// A member for a parameter of any list of the library.
#define COMMON_MEMBER(group, symbol, member, ...) double member;

#define COMMON_PATH_MAX     4096 ///< bytes of a path
#define COMMON_SECTIONS_MAX 4

#define COMMON_BREAKAWAY_POINTS_MAX 32

/// One point of a breakaway table.
typedef struct
{
    double force_n;    ///< |F|
    double positive_n; ///< L+
    double negative_n; ///< L-
} common_breakaway_point_t;

/// L(F) = offset + slope |F|, or a table. The negative direction has the values of the positive one unless it has its own.
typedef struct
{
    double                   offset_n;
    double                   slope;
    common_optional_t        negative_offset_n;
    common_optional_t        negative_slope;
    common_breakaway_point_t table[COMMON_BREAKAWAY_POINTS_MAX];
    unsigned                 table_count; ///< 0: the affine law
} common_breakaway_config_t;

/// Parameters of Eqs. (3) to (6), (8) and (9).
typedef struct
{
    TRIBO_FRICTION_PARAMETERS(COMMON_MEMBER)
    common_breakaway_config_t breakaway;
} common_friction_config_t;

/// Parameters of Eq. (2), in degrees as in the paper.
typedef struct
{
    TRIBO_ARM_PARAMETERS(COMMON_MEMBER)
} common_arm_config_t;

typedef enum
{
    COMMON_REFERENCE_TRIANGLE,
    COMMON_REFERENCE_SINE,
    COMMON_REFERENCE_STEP,
    COMMON_REFERENCE_RAMP,
    COMMON_REFERENCE_SAWTOOTH,
    COMMON_REFERENCE_CHIRP,
    COMMON_REFERENCE_CSV
} common_reference_kind_t;

typedef struct
{
    common_reference_kind_t kind;
    double                  low_n, high_n;
    double                  start_s;
    double                  period_s;
    double                  ramp_s;
    double                  from_hz, to_hz, sweep_s;
    char                    file[COMMON_PATH_MAX + 1]; ///< "": none
} common_reference_config_t;

typedef struct
{
    double b0, b1, b2, a1, a2;
} common_section_t;

typedef enum
{
    COMMON_CONTROLLER_PAPER, ///< tribo/paper_controller.h
    COMMON_CONTROLLER_PI,    ///< kp and ki_per_s
    COMMON_CONTROLLER_Z,     ///< sections in z^-1
    COMMON_CONTROLLER_DELTA, ///< sections in d = z - 1, as in tribo/controller_f32.h
    COMMON_CONTROLLER_NONE   ///< open loop: u is r within the limits
} common_controller_kind_t;

typedef struct
{
    common_controller_kind_t kind;
    double                   kp, ki_per_s;
    common_section_t         sections[COMMON_SECTIONS_MAX];
    unsigned                 section_count;
} common_controller_config_t;

/// How friction is compensated: METHOD(symbol, word in `compensator.method`).
#define COMMON_METHODS(METHOD) METHOD(PAPER, "paper") METHOD(FEEDFORWARD, "feedforward") METHOD(OFF, "off")

typedef enum
{
#define COMMON_METHOD_SYMBOL(symbol, word) COMMON_METHOD_##symbol,
    COMMON_METHODS(COMMON_METHOD_SYMBOL)
#undef COMMON_METHOD_SYMBOL
} common_method_t;

/// The source of the end-point force for the method `feedforward`.
typedef enum
{
    COMMON_SENSOR_FORCE,
    COMMON_SENSOR_NONE
} common_loop_sensor_t;

typedef struct
{
    TRIBO_FEEDFORWARD_PARAMETERS(COMMON_MEMBER)
} common_feedforward_config_t;

typedef struct
{
    TRIBO_SENSORLESS_PARAMETERS(COMMON_MEMBER)
} common_sensorless_config_t;

typedef struct
{
    int on; ///< 1: yes
    TRIBO_GUARD_PARAMETERS(COMMON_MEMBER)
} common_guard_config_t;

typedef struct
{
    common_method_t      method;
    common_loop_sensor_t sensor;
    TRIBO_GAIN_PARAMETERS(COMMON_MEMBER)
    common_friction_config_t    friction;
    common_arm_config_t         arm;
    common_feedforward_config_t feedforward;
    common_sensorless_config_t  sensorless;
    common_guard_config_t       guard;
} common_compensator_config_t;

typedef struct
{
    TRIBO_LIMIT_PARAMETERS(COMMON_MEMBER)
    TRIBO_INPUT_PARAMETERS(COMMON_MEMBER)
    TRIBO_SCALE_PARAMETERS(COMMON_MEMBER)
} common_limits_config_t;

typedef struct
{
    double                      sample_time_s;
    common_reference_config_t   reference;
    common_controller_config_t  controller;
    common_compensator_config_t compensator;
    common_limits_config_t      limits;
} common_loop_keys_t;

extern const common_key_t common_friction_keys[];    ///< keys of common_friction_config_t, for a loop or a plant
extern const common_key_t common_arm_keys[];         ///< keys of common_arm_config_t, for a loop or a plant
extern const common_key_t common_reference_keys[];   ///< keys of common_reference_config_t
extern const common_key_t common_controller_keys[];  ///< keys of common_controller_config_t
extern const common_key_t common_compensator_keys[]; ///< keys of common_compensator_config_t
extern const common_key_t common_limits_keys[];      ///< keys of common_limits_config_t

/// Keys of common_loop_keys_t, the loop of a scenario, for a program without a plant. It skips the keys of the simulator.
extern const common_key_t common_loop_keys[];

/// Returns the negative direction's own offset or slope, or that of the positive direction.
static inline double common_breakaway_negative_offset(const common_breakaway_config_t *config)
{
    return config->negative_offset_n.is_given ? config->negative_offset_n.value : config->offset_n;
}

static inline double common_breakaway_negative_slope(const common_breakaway_config_t *config)
{
    return config->negative_slope.is_given ? config->negative_slope.value : config->slope;
}

/// Returns the path of the key that a refusal of the library is about, "" if it is about none.
const char *common_loop_key_of(tribo_status_t status);

#endif
