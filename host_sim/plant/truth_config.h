/// What a plant is made of, in physical units and double precision. Ranges and defaults: scenario/keys.c.

#ifndef SIM_TRUTH_CONFIG_H
#define SIM_TRUTH_CONFIG_H

#include "support/key.h"

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
    double                 k_min, k_max;
    double                 m;
    double                 v0_n_per_s;
    sim_breakaway_config_t breakaway;
    double                 set_level, reset_level;
    double                 pulse_width_s;
    double                 gravity_n;
} sim_friction_config_t;

/// Eq. (2), in degrees as in the paper.
typedef struct
{
    double inertia_n_s2_per_deg;
    double damping_n_s_per_deg;
    double stiffness_n_per_deg;
} sim_arm_config_t;

typedef struct
{
    sim_friction_config_t friction;
    sim_arm_config_t      arm;
    const void *own; ///< the model's own parameters, see sim_truth_ops_t; a model without any does not read it
} sim_truth_config_t;

#endif
