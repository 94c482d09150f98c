/// A scenario as the program holds it: every key of a scenario file as a field, in physical units.
///
/// Values come from three places, the later over the earlier: the defaults, a file, --set. Each is checked for its key,
/// its type and its range as it is read, and every complaint names the place it came from. Keys, units, ranges and
/// defaults: keys.c, and the tables of scenarios/README.md that are made of it.

#ifndef SIM_CONFIG_H
#define SIM_CONFIG_H

#include "plant/plant.h"
#include "plant/sensor.h"
#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

#define SIM_DESCRIPTION_MAX 200  ///< bytes
#define SIM_PATH_MAX        4096 ///< bytes
#define SIM_SECTIONS_MAX    4

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
    sim_truth_number_t    model;
    double                step_s;
    double                actuator_pole_rad_per_s;
    sim_friction_config_t friction;
    sim_arm_config_t      arm;
    sim_drive_error_t     drive_error;
    double                own[SIM_TRUTH_COUNT][SIM_TRUTH_DOUBLES_MAX]; ///< the models' own parameters, each a struct
} sim_plant_keys_t;

typedef struct
{
    double              pole_rad_per_s;
    sim_sensor_config_t sampling;
} sim_sensor_keys_t;

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
    double stiffness_n_per_deg;
    double bristle_damping_n_s_per_deg;
    double viscous_n_s_per_deg;
} sim_bristles_config_t;

typedef struct
{
    double spread_scale, spread_offset_n;
    double correlation, correlation_faded;
    double trust, doubt;
    double weight_n;
    double forgetting_per_n;
    double scale_min, scale_max;
} sim_learning_config_t;

typedef struct
{
    double gain;
    double still_time_s;
    double margin;
    double quick_time_s;
    double caution_travel_n;
    double deadband_time_s;
} sim_hold_config_t;

typedef struct
{
    double                actuator_pole_rad_per_s, sensor_pole_rad_per_s;
    double                reversal_n;
    double                jump_time_s;
    double                lead;
    double                noise_gain, noise_time_s;
    double                rate_time_s, rate_max_n_per_s;
    double                offset_time_s;
    double                slide_width_n, slide_filter_time_s, slide_rate_max_n_per_s, slide_run_in_n, slide_error_max_n;
    sim_learning_config_t learning;
    sim_hold_config_t     hold;
} sim_feedforward_config_t;

typedef struct
{
    int    on; ///< 1: yes
    double turn_n, quick_time_s, stray_n, fade_time_s;
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
    double u_min_n, u_max_n;
    double input_max_n;
    double full_scale_n; ///< of Q31
} sim_limits_config_t;

typedef struct
{
    double         start_s;
    sim_optional_t end_s; ///< left out: the end of the run
} sim_metrics_config_t;

typedef struct
{
    char                     description[SIM_DESCRIPTION_MAX + 1];
    double                   duration_s; ///< 0: not given yet
    double                   sample_time_s;
    sim_reference_config_t   reference;
    sim_plant_keys_t         plant;
    sim_sensor_keys_t        sensor;
    sim_controller_config_t  controller;
    sim_compensator_config_t compensator;
    sim_limits_config_t      limits;
    sim_metrics_config_t     metrics;
} sim_config_t;

/// A scenario under construction: the values and where each of them was written.
typedef struct sim_scenario sim_scenario_t;

/// All defaults: the paper's loop and plant. Null if there is no memory.
sim_scenario_t *sim_scenario_create(void);
void            sim_scenario_destroy(sim_scenario_t *scenario);

const sim_config_t *sim_scenario_config(const sim_scenario_t *scenario);

/// Takes the keys of a scenario file, or of a file with the keys of `compensator` alone. After a failure, here and in
/// sim_scenario_set, the scenario is only to be destroyed.
bool sim_scenario_load(sim_scenario_t *scenario, const char *path, sim_error_t *error);
bool sim_scenario_load_compensator(sim_scenario_t *scenario, const char *path, sim_error_t *error);

/// Takes one "key=value", e.g. "plant.friction.breakaway.slope=0.36" or "controller.sections[0].b0=1.5".
bool sim_scenario_set(sim_scenario_t *scenario, const char *assignment, sim_error_t *error);

/// The same from text of a scenario file; `name` stands for the file in messages.
bool sim_scenario_load_text(sim_scenario_t *scenario, const char *text, const char *name, sim_error_t *error);

/// Checks what belongs together and what is missing.
bool sim_scenario_check(const sim_scenario_t *scenario, sim_error_t *error);

/// Where `key` was written ("FILE:LINE" or "--set key=value"), or else its parent, or else the file as a whole.
const char *sim_scenario_source(const sim_scenario_t *scenario, const char *key);

/// Whether `key` itself has been written; whether a --set wrote it or a part of it last.
bool sim_scenario_has(const sim_scenario_t *scenario, const char *key);
bool sim_scenario_is_set(const sim_scenario_t *scenario, const char *key);

/// The path of the file that `reference.file` names: from the scenario file's folder, or from the current one if the
/// key came from --set. To be freed; null if there is no memory.
char *sim_scenario_reference_path(const sim_scenario_t *scenario);

#endif
