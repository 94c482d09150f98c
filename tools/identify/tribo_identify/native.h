/// The interface of native.c for the Python package. All of native.c computes in double.

#ifndef IDENTIFY_NATIVE_H
#define IDENTIFY_NATIVE_H

#include <stddef.h>

typedef struct
{
    double k_min, k_max, m, v0, offset_positive, slope_positive, offset_negative, slope_negative;
    double set_level, reset_level, pulse_width, gravity, inertia, damping, stiffness;
    double scale;            ///< scale of the command
    double actuator, sensor; ///< poles, rad/s
} identify_params_t;

enum
{
    IDENTIFY_SETS_MAX = 4 ///< parameter sets in one simulation
};

int identify_simulate(const identify_params_t *p,
                      const double            *table,
                      int                      points,
                      int                      sets,
                      const double            *u,
                      size_t                   rows,
                      double                   interval_s,
                      int                      substeps,
                      double                   start_n,
                      double                  *y);

int identify_play(const char              *truth,
                  const identify_params_t *p,
                  const double            *given,
                  const double            *u,
                  size_t                   rows,
                  double                   interval_s,
                  int                      substeps,
                  double                  *y);

const char *identify_status_text(int status);

int identify_slides(const double *u, double *force, size_t rows, double interval_s, signed char *ways);

#endif
