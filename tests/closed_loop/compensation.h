// A closed-loop run with one compensation method on the paper's plant with deviations, and its results.

#ifndef TESTS_CLOSED_LOOP_COMPENSATION_H
#define TESTS_CLOSED_LOOP_COMPENSATION_H

#include ARITH_HEADER

#include <stdint.h>

typedef enum
{
    COMPENSATION_OFF,
    COMPENSATION_FEEDFORWARD
} compensation_t;

/// Differences of the truth from the model; see compensation_nominal.
typedef struct
{
    double   breakaway_positive, breakaway_negative; // times the model's
    double   actuator_gain;
    double   noise_n;
    uint64_t noise_seed;
    double   environment_n, environment_hz; // amplitude of its movement times the stiffness, and frequency
    double   push_n, push_s, push_time_s;   // a force on the arm, from when and for how long
    double   settle_s;                      // start from rest: this part of the run does not count
} compensation_truth_t;

/// The reference in N at time t in s.
typedef double (*compensation_reference_t)(const void *context, double t);

typedef struct
{
    double rms, peak, variation; // of r - F, of r - F, total variation of u, over the second part of the run
    double first_rms;            // of r - F, over the first part
} compensation_result_t;

compensation_truth_t compensation_nominal(void);

/// Runs for `first_s` + `second_s` seconds. `config` is the feed-forward's; null: the defaults.
compensation_result_t compensation_run(compensation_t                        method,
                                       const tribo_feedforward_f32_config_t *config,
                                       const compensation_truth_t           *truth,
                                       compensation_reference_t              reference,
                                       const void                           *context,
                                       double                                first_s,
                                       double                                second_s);

typedef struct
{
    double low, high, slope; // N, N, N/s
} compensation_triangle_t;

/// From its low end.
double compensation_triangle(const void *context, double t);

/// Three periods of a triangle; the first one is the first part.
compensation_result_t compensation_run_triangle(compensation_t                        method,
                                                const tribo_feedforward_f32_config_t *config,
                                                const compensation_truth_t           *truth,
                                                compensation_triangle_t               triangle);

#endif
