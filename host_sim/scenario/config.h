/// A scenario in the simulator: every key of a scenario file as a field, in physical units. loop/loop_keys.c and keys.c have
/// the keys, units, ranges and defaults; `tribo-sim list --keys` prints them.

#ifndef SIM_CONFIG_H
#define SIM_CONFIG_H

#include "loop/scenario.h"
#include "plant/plant.h"
#include "plant/sensor.h"

#include <stdbool.h>
#include <stddef.h>

#define SIM_DESCRIPTION_MAX 200 ///< bytes of a description

typedef struct
{
    sim_truth_number_t       model;
    double                   step_s;
    double                   actuator_pole_rad_per_s;
    common_friction_config_t friction;
    common_arm_config_t      arm;
    sim_drive_error_t        drive_error;
    double own[SIM_TRUTH_COUNT][SIM_TRUTH_DOUBLES_MAX]; ///< the models' own parameters, a struct for each
} sim_plant_keys_t;

typedef struct
{
    double              pole_rad_per_s;
    sim_sensor_config_t sampling;
} sim_sensor_keys_t;

typedef struct
{
    double            start_s;
    common_optional_t end_s; ///< missing: the end of the run
} sim_metrics_config_t;

typedef enum
{
    SIM_F32,
    SIM_Q31,
    SIM_BOTH
} sim_arithmetic_t;

typedef struct
{
    common_loop_keys_t   loop; ///< must stand first, see common_scenario_create_of
    char                 description[SIM_DESCRIPTION_MAX + 1];
    sim_arithmetic_t     arithmetic;
    double               duration_s; ///< 0: not given yet
    sim_plant_keys_t     plant;
    sim_sensor_keys_t    sensor;
    sim_metrics_config_t metrics;
} sim_config_t;

/// Creates a scenario with all defaults: the paper's loop and plant. Null if there is no memory.
common_scenario_t *sim_scenario_create(void);

const sim_config_t *sim_scenario_config(const common_scenario_t *scenario);

/// Checks keys against each other, and that no required key is missing.
bool sim_scenario_check(const common_scenario_t *scenario, common_error_t *error);

#endif
