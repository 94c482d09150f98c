/// Plays a scenario: the library's force loop at every sample, the plant between samples.
///
///     at t = k h:   read y  ->  force loop(r, y)  ->  u, held until (k + 1) h
///                   sample_time_s / step_s plant steps
///
/// On a target the step is the drive's firmware in an emulator, in lock-step.

#ifndef SIM_RUNNER_H
#define SIM_RUNNER_H

#include "plant/plant.h"
#include "scenario/config.h"
#include "scenario/loop.h"
#include "scenario/summary.h"

/// One tick, everything as it is at its time t.
typedef struct sim_row
{
    double                         t_s;
    double                         r_n;
    double                         y_n;     ///< as the sensor gave it
    double                         force_n; ///< F, the plant's
    double                         u_n;     ///< the loop's, exact
    tribo_force_loop_f32_signals_t loop;
    const sim_learned_t           *learned; ///< at r; null if nothing learns
    sim_plant_signals_t            plant;
    const struct sim_row          *q31; ///< with sim_run_options_t.both: the same tick of the other loop; else null
} sim_row_t;

/// What to do at each tick; null is nothing. Returning false ends the run with the error filled in.
typedef bool (*sim_row_handler_t)(void *context, const sim_row_t *row, double part_done, common_error_t *error);

/// Where the loop runs.
typedef struct
{
    const char *target; ///< an emulated microcontroller (target/target.h); null: here
    bool        q31;    ///< the loop's arithmetic, also if the scenario says so
    bool        both;   ///< here only: f32 and Q31, each on a plant of its own
} sim_run_options_t;

/// Whether the scenario's loop learns, so that rows and results say what.
bool sim_run_learns(const sim_config_t *config);

/// Runs a checked scenario (sim_scenario_check) to its end; `options` may be null. A target that differs from the host is in the summary.
bool sim_run(const common_scenario_t *scenario,
             const sim_run_options_t *options,
             sim_row_handler_t        handler,
             void                    *context,
             sim_summary_t           *summary,
             common_error_t          *error);

/// False with a reason if more than nine in ten of a run's ticks had a bad input: the loop coasted, and the run's figures say nothing.
bool sim_run_was_controlled(const common_scenario_t *scenario, const sim_summary_t *summary, common_error_t *error);

#endif
