/// The loop as a file has it, in physical units: reference, controller, compensator and limits, which the simulator and a drive both
/// read. Keys, units, ranges and defaults of what the library has: tribo/parameters.h; of the rest: loop_keys.c.

#ifndef SIM_LOOP_KEYS_H
#define SIM_LOOP_KEYS_H

#include "keys/key.h"
#include "tribo/status.h"

/// A parameter of the library, of whichever list.
#define SIM_MEMBER(group, symbol, member, ...) double member;

#define SIM_PATH_MAX     4096 ///< bytes
#define SIM_SECTIONS_MAX 4

#define SIM_BREAKAWAY_POINTS_MAX 32

/// One point of a breakaway table.
typedef struct
{
    double force_n;    ///< |F|
    double positive_n; ///< L+
    double negative_n; ///< L-
} sim_breakaway_point_t;

/// L(F) = offset + slope |F|, or a table. The negative direction is as the positive one unless it has its own values.
typedef struct
{
    double                offset_n;
    double                slope;
    sim_optional_t        negative_offset_n;
    sim_optional_t        negative_slope;
    sim_breakaway_point_t table[SIM_BREAKAWAY_POINTS_MAX];
    unsigned              table_count; ///< 0: the affine law
} sim_breakaway_config_t;

/// Eqs. (3) to (6), (8), (9).
typedef struct
{
    TRIBO_FRICTION_PARAMETERS(SIM_MEMBER)
    sim_breakaway_config_t breakaway;
} sim_friction_config_t;

/// Eq. (2), in degrees as in the paper.
typedef struct
{
    TRIBO_ARM_PARAMETERS(SIM_MEMBER)
} sim_arm_config_t;

typedef enum
{
    SIM_REFERENCE_TRIANGLE,
    SIM_REFERENCE_SINE,
    SIM_REFERENCE_STEP,
    SIM_REFERENCE_RAMP,
    SIM_REFERENCE_SAWTOOTH,
    SIM_REFERENCE_CHIRP,
    SIM_REFERENCE_CSV
} sim_reference_kind_t;

typedef struct
{
    sim_reference_kind_t kind;
    double               low_n, high_n;
    double               start_s;
    double               period_s;
    double               ramp_s;
    double               from_hz, to_hz, sweep_s;
    char                 file[SIM_PATH_MAX + 1]; ///< "": none
} sim_reference_config_t;

typedef struct
{
    double b0, b1, b2, a1, a2;
} sim_section_t;

typedef enum
{
    SIM_CONTROLLER_PAPER, ///< tribo/paper_controller.h
    SIM_CONTROLLER_Z,     ///< sections in z^-1
    SIM_CONTROLLER_DELTA, ///< sections in d = z - 1, as tribo/biquad_f32.h has them
    SIM_CONTROLLER_NONE   ///< open loop: u is r within the limits
} sim_controller_kind_t;

typedef struct
{
    sim_controller_kind_t kind;
    sim_section_t         sections[SIM_SECTIONS_MAX];
    unsigned              section_count;
} sim_controller_config_t;

typedef enum
{
    SIM_METHOD_PAPER,
    SIM_METHOD_FEEDFORWARD,
    SIM_METHOD_OFF
} sim_method_t;

/// Of friction, which the method `paper` believes in.
typedef enum
{
    SIM_MODEL_PAPER,
    SIM_MODEL_LUGRE
} sim_friction_model_t;

typedef struct
{
    TRIBO_LUGRE_PARAMETERS(SIM_MEMBER)
} sim_bristles_config_t;

typedef struct
{
    TRIBO_LEARNING_PARAMETERS(SIM_MEMBER)
} sim_learning_config_t;

typedef struct
{
    TRIBO_HOLD_PARAMETERS(SIM_MEMBER)
} sim_hold_config_t;

typedef struct
{
    TRIBO_FEEDFORWARD_PARAMETERS(SIM_MEMBER)
    sim_learning_config_t learning;
    sim_hold_config_t     hold;
} sim_feedforward_config_t;

typedef struct
{
    int on; ///< 1: yes
    TRIBO_GUARD_PARAMETERS(SIM_MEMBER)
} sim_guard_config_t;

typedef struct
{
    sim_method_t             method;
    sim_friction_model_t     model;
    double                   gain;
    sim_friction_config_t    friction;
    sim_arm_config_t         arm;
    sim_bristles_config_t    lugre;
    sim_feedforward_config_t feedforward;
    sim_guard_config_t       guard;
} sim_compensator_config_t;

typedef struct
{
    TRIBO_LIMIT_PARAMETERS(SIM_MEMBER)
    TRIBO_INPUT_PARAMETERS(SIM_MEMBER)
    TRIBO_SCALE_PARAMETERS(SIM_MEMBER)
} sim_limits_config_t;

typedef struct
{
    double                   sample_time_s;
    sim_reference_config_t   reference;
    sim_controller_config_t  controller;
    sim_compensator_config_t compensator;
    sim_limits_config_t      limits;
} sim_loop_keys_t;

extern const sim_key_t sim_friction_keys[];    ///< of sim_friction_config_t, a loop's or a plant's
extern const sim_key_t sim_arm_keys[];         ///< of sim_arm_config_t, likewise
extern const sim_key_t sim_reference_keys[];   ///< of sim_reference_config_t
extern const sim_key_t sim_controller_keys[];  ///< of sim_controller_config_t
extern const sim_key_t sim_compensator_keys[]; ///< of sim_compensator_config_t
extern const sim_key_t sim_limits_keys[];      ///< of sim_limits_config_t

/// The loop of a scenario alone, for a program without a plant: of sim_loop_keys_t. What is the simulator's is not looked at.
extern const sim_key_t sim_loop_keys[];

/// The negative direction's own offset and slope, or the positive one's.
static inline double sim_breakaway_negative_offset(const sim_breakaway_config_t *config)
{
    return config->negative_offset_n.is_given ? config->negative_offset_n.value : config->offset_n;
}

static inline double sim_breakaway_negative_slope(const sim_breakaway_config_t *config)
{
    return config->negative_slope.is_given ? config->negative_slope.value : config->slope;
}

/// The path of the key that a refusal of the library is about, "" if it is about none.
const char *sim_loop_key_of(tribo_status_t status);

#endif
