/// A simulated joint that sticks, under a position loop, with tribo's joint between loop and drive.

#ifndef PLAYGROUND_JOINT_H
#define PLAYGROUND_JOINT_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

/// As the page hands them over, in this order.
typedef struct
{
    double friction;  ///< while it slides, N m
    double extra;     ///< more of it at standstill, as a part
    double load;      ///< constant, N m
    double guess;     ///< friction as tribo's config has it, N m
    double stiffness; ///< of the position loop, N m/rad
    double gain;      ///< of tribo's config; 0: no compensation
    double counts;    ///< of the encoder, a turn
    double shape;     ///< of the reference: 0 sine, 1 triangle, 2 moves and stops
    double amplitude; ///< rad
    double period_s;
} joint_settings_t;

enum
{
    JOINT_SETTINGS = sizeof(joint_settings_t) / sizeof(double),
    JOINT_COLUMNS  = 8,
    JOINT_TICKS    = 20000, ///< of 1 ms
    JOINT_START    = 10000  ///< errors count from here on
};

extern const char *const joint_column_names[JOINT_COLUMNS];

typedef struct
{
    double      rms_error, max_error; ///< rad
    const char *cause;                ///< of the joint's guard
} joint_result_t;

/// Plays the joint; columns have JOINT_TICKS numbers each. False: tribo refuses the config, see `error`.
bool joint_play(const joint_settings_t *settings,
                double *const           columns[JOINT_COLUMNS],
                joint_result_t         *result,
                common_error_t         *error);

#endif
