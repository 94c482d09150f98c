/// native.c, for the Python package: the whole of it in double.

#ifndef IDENTIFY_NATIVE_H
#define IDENTIFY_NATIVE_H

#include <stddef.h>

extern const int identify_parameters;
extern const int identify_sets_max;

int identify_simulate(const double *p,
                      const double *table,
                      int           points,
                      int           sets,
                      const double *u,
                      size_t        rows,
                      double        interval_s,
                      int           substeps,
                      double        start_n,
                      double       *y);

int identify_play(const char   *truth,
                  const double *p,
                  const double *given,
                  const double *u,
                  size_t        rows,
                  double        interval_s,
                  int           substeps,
                  double       *y);

const char *identify_status_text(int status);

int identify_slides(const double *u, double *force, size_t rows, double interval_s, signed char *ways);

#endif
