/// Plays a scenario: the library's force loop at every sample, the plant between samples.
///
///     at t = k h:   read y  ->  force loop(r, y)  ->  u, held until (k + 1) h
///                   sample_time_s / step_s plant steps
///
/// On a target the drive's firmware in an emulator takes the step, in lock-step.

#ifndef SIM_RUNNER_H
#define SIM_RUNNER_H

#include "plant/plant.h"
#include "scenario/config.h"
#include "scenario/loop.h"
#include "scenario/summary.h"

/// One tick, with all values at its time t.
typedef struct sim_row
{
    double                         t_s;
    double                         r_n;
    double                         y_n;     ///< the sensor's reading
    double                         force_n; ///< F of the plant
    double                         u_n;     ///< u of the loop, exact
    tribo_force_loop_f32_signals_t loop;
    const sim_learned_t           *learned; ///< learned values at r; null if nothing learns
    sim_plant_signals_t            plant;
    const struct sim_row          *q31; ///< with sim_run_options_t.both: the same tick of the Q31 loop; otherwise null
} sim_row_t;

/// Called at each tick unless null. It returns false, with the error filled in, to end the run.
typedef bool (*sim_row_handler_t)(void *context, const sim_row_t *row, double part_done, common_error_t *error);

/// Where the loop runs, and in which arithmetic.
typedef struct
{
    const char *target; ///< an emulated microcontroller (target/target.h); null: this host
    bool        q31;    ///< the loop computes in Q31; the scenario may also choose this
    bool        both;   ///< only on this host: f32 and Q31, each on a plant of its own
} sim_run_options_t;

/// Returns whether the scenario's loop learns, so that rows and results have learned values.
bool sim_run_learns(const sim_config_t *config);

/// Runs a checked scenario (sim_scenario_check) to its end; `options` may be null. The summary reports a target that differs
/// from the host.
bool sim_run(const common_scenario_t *scenario,
             const sim_run_options_t *options,
             sim_row_handler_t        handler,
             void                    *context,
             sim_summary_t           *summary,
             common_error_t          *error);

/// Returns false with a reason if more than nine in ten ticks of a run had a bad input, where e counts as 0: the run's
/// figures mean nothing.
bool sim_run_was_controlled(const common_scenario_t *scenario, const sim_summary_t *summary, common_error_t *error);

#endif
