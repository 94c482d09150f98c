/// Shared by the tests of the truth models: the paper's arm, inputs made of ramps, a law under prescribed motion.

#ifndef TRUTH_RIG_H
#define TRUTH_RIG_H

#include "cvode.h"
#include "plant/drive_error.h"
#include "plant/truth.h"

#define RIG_STEP_S 1e-4

/// A model and its parameters, the defaults until rig_set changes them.
typedef struct
{
    const sim_truth_ops_t *truth;
    sim_truth_config_t     config;
    sim_drive_error_t      drive_error;                ///< none
    double                 own[SIM_TRUTH_DOUBLES_MAX]; ///< the model's parameters
} rig_t;

/// The paper's values. Do not move or copy the rig: its config points into it.
void rig_init(rig_t *rig, const sim_truth_ops_t *truth);

/// True if the model has a parameter of this name.
bool rig_has(const rig_t *rig, const char *name);

/// Changes a parameter; for a choice `value` is the word's index. Fails the test if the parameter is unknown or out of range.
void rig_set(rig_t *rig, const char *name, double value);

/// L(F) = level for all F, as in most published properties.
void rig_constant_breakaway(rig_t *rig, double level_n);

/// A ramp of u, from the end of the last one.
typedef struct
{
    double to_n, seconds;
} rig_ramp_t;

/// Runs ramps through the fixed steps or the reference. After each step (or sample, `every_s` apart) `see` is called.
typedef struct
{
    double time_s, u_n, force_n, f_n, speed_deg_per_s;
} rig_sample_t;
typedef void (*rig_see_t)(void *context, const rig_sample_t *sample);

void rig_run(const rig_t *rig, double step_s, const rig_ramp_t *ramps, unsigned count, rig_see_t see, void *context);
void rig_run_reference(const rig_t           *rig,
                       const cvode_options_t *options,
                       double                 every_s,
                       const rig_ramp_t      *ramps,
                       unsigned               count,
                       rig_see_t              see,
                       void                  *context,
                       cvode_cost_t          *cost);

/// F after each of `count` ramps.
void rig_forces(const rig_t *rig, const rig_ramp_t *ramps, unsigned count, double forces_n[]);

/// The change of F in a rise in `seconds`, up to u - F = 0.9 L at the old F, after a fall to `bottom_n` and a stop there.
double rig_lift(const rig_t *rig, double bottom_n, double seconds);

/// Presliding drift: slides up to u = 0.5 N, returns to zero net force, then swings u 50 times between net forces of 0.2 L
/// and 0.8 L, relative to F at the start. Returns the change of F from the end of the first swing to that of the last.
double rig_drift(const rig_t *rig, double swing_s);

/// The ramps for comparing models: deep and shallow falls, a small loop inside stiction, through zero.
extern const rig_ramp_t rig_compare_ramps[];
extern const unsigned   rig_compare_count;

/// Largest difference of F between fixed steps and reference, over the largest |F|.
typedef struct
{
    double difference; ///< of F, as a fraction of the largest |F|
    double largest_n;  ///< |F|
    double at_s;
} rig_comparison_t;
rig_comparison_t rig_compare(const rig_t      *rig,
                             double            step_s,
                             const rig_ramp_t *ramps,
                             unsigned          count,
                             cvode_cost_t     *cost);

/// A law under prescribed motion at constant F.
typedef struct
{
    const sim_law_t *law;
    void            *friction;
    sim_contact_t    contact;
    double           z[SIM_LAW_STATES_MAX];
    double           position_deg;
    double           f_n;
} rig_slide_t;

void rig_slide_start(rig_slide_t *slide, const rig_t *rig, double force_n);
void rig_slide_end(rig_slide_t *slide);

/// One step at this speed; returns friction at its end.
double rig_slide_step(rig_slide_t *slide, double speed_deg_per_s, double step_s);

/// Moves by `distance_deg` at `speed_deg_per_s` (unsigned), in whole steps of at most `step_s`; returns friction there.
double rig_slide_by(rig_slide_t *slide, double distance_deg, double speed_deg_per_s, double step_s);

/// Friction over L after `way_deg` from rest at a force.
double rig_part_after(const rig_t *rig, double way_deg, double force_n);

/// Presliding up, down, and up again to the first reversal, with and without a small inner loop: the difference of F.
double rig_inner_loop(const rig_t *rig);

#endif
