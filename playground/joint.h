/// A simulated joint with stiction under a position loop, with tribo's joint between the loop and the drive.

#ifndef PLAYGROUND_JOINT_H
#define PLAYGROUND_JOINT_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

/// The settings in the order in which the page passes them.
typedef struct
{
    double friction;  ///< while it slides, N m
    double extra;     ///< extra friction at standstill, as a fraction
    double load;      ///< constant, N m
    double guess;     ///< friction in tribo's config, N m
    double stiffness; ///< of the position loop, N m/rad
    double gain;      ///< gain in tribo's config; 0: no compensation
    double counts;    ///< encoder counts per turn
    double shape;     ///< of the reference: 0 sine, 1 triangle, 2 moves and stops
    double amplitude; ///< rad
    double period_s;
} joint_settings_t;

enum
{
    JOINT_SETTINGS = sizeof(joint_settings_t) / sizeof(double),
    JOINT_COLUMNS  = 8,
    JOINT_TICKS    = 20000, ///< of 1 ms
    JOINT_START    = 10000  ///< first tick whose error counts
};

extern const char *const joint_column_names[JOINT_COLUMNS];

typedef struct
{
    double      rms_error, max_error; ///< rad
    const char *cause;                ///< reported by the joint's guard
} joint_result_t;

/// Runs the joint; columns have JOINT_TICKS numbers each. Returns false if tribo refuses the config; then `error` says why.
bool joint_play(const joint_settings_t *settings,
                double *const           columns[JOINT_COLUMNS],
                joint_result_t         *result,
                common_error_t         *error);

#endif
