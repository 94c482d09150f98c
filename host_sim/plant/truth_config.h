/// Parameters of a plant, in physical units and double precision. loop/loop_keys.c and scenario/keys.c have ranges and defaults.

#ifndef SIM_TRUTH_CONFIG_H
#define SIM_TRUTH_CONFIG_H

#include "loop/loop_keys.h"

typedef struct
{
    common_friction_config_t friction;
    common_arm_config_t      arm;
    const void              *own; ///< the model's own parameters, see sim_truth_ops_t; not read by a model without any
} sim_truth_config_t;

#endif
