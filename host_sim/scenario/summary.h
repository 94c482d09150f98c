/// The results of a run. Errors, variation, chatter and switches cover the metrics window, the other counters the whole run.

#ifndef SIM_SUMMARY_H
#define SIM_SUMMARY_H

#include "scenario/activity.h"
#include "scenario/loop.h"
#include "target/target.h"

#include <stdbool.h>
#include <stdint.h>

/// Ticks of a run from which nothing can be learned, by the first reason that applies.
typedef struct
{
    uint64_t bad_inputs;
    uint64_t limited;  ///< u at a limit
    uint64_t standing; ///< r equal to that of the tick before
    double   travel_n; ///< travel of F in all ticks
} sim_idle_t;

/// One loop on its plant.
typedef struct
{
    double                    rms_error_n;          ///< rms of r - F
    double                    max_error_n;          ///< largest |r - F|
    double                    rms_measured_error_n; ///< rms of r - y
    sim_activity_t            activity;
    uint64_t                  limited_ticks;
    uint64_t                  bad_inputs;
    const char               *guard;  ///< why the guard has faded the compensation; null: there is no guard
    bool                      learns; ///< `learned` is valid, at the last r
    sim_learned_t             learned;
    sim_idle_t                idle;
    double                    usual_force_n; ///< force whose breakaway sets the widths of the feed-forward
    common_breakaway_config_t breakaway;     ///< learned breakaway at all forces
} sim_result_t;

/// The difference of two loops over the metrics window: Q31 minus f32.
typedef struct
{
    double max_u_n, rms_u_n;
    double max_force_n, rms_force_n;
} sim_difference_t;

typedef struct
{
    sim_result_t result;
    uint64_t     ticks;
    double       simulated_s;
    double       wall_s; ///< wall time of the loop, including output written meanwhile
    double       real_time_factor;

    const char         *target; ///< null: the loop ran only on this host
    bool                q31;    ///< arithmetic of the target
    sim_target_result_t lock_step;

    bool             both; ///< the members below are valid
    sim_result_t     result_q31;
    sim_difference_t difference;
} sim_summary_t;

/// Returns the summary as a JSON object, to be freed with free(); null if there is no memory. Keys carry their units:
///
///     always               rms_error_N, max_error_N, rms_measured_error_N, u_variation_N, variation_ratio (null if r is at rest),
///                          chatter_ticks, Q_switches, ticks, limited_ticks, bad_inputs, simulated_s, wall_s, real_time_factor
///     with a guard         guard: none, hunting or overshoot
///     with a feed-forward  learned: positive and negative, each breakaway_N at the last r, relative_variance, travel_N,
///                          at_bound and stays_at_bound; harms, forgotten (times), usual_force_N (breakaway there set the widths),
///                          not_learned (sim_summary_not_learned, or null)
///     with a target        target, arithmetic, different_ticks, lock_step_ticks_per_s
///     in both arithmetics  q31 (errors and counters once more), difference (max_u_N, rms_u_N, max_F_N, rms_F_N)
char *sim_summary_to_json(const sim_summary_t *summary);

#define SIM_NOT_LEARNED_SIZE 128

/// Writes why a run of `ticks` has learned too little, i.e. has a relative variance above 0.5 in a direction. Returns false
/// if it has learned enough.
bool sim_summary_not_learned(const sim_result_t *result, uint64_t ticks, char text[SIM_NOT_LEARNED_SIZE]);

#endif
