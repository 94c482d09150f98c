/// A force axis in one struct, Q31. axis_f32.h explains each call. Config and report are the same, in N; the forces of
/// a tick are Q31 of the full scale that you pass to the init. Not synchronized: one axis, one tick.

#ifndef TRIBO_AXIS_Q31_H
#define TRIBO_AXIS_Q31_H

#include "tribo/axis_f32.h"
#include "tribo/feedforward_q31.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_axis_q31_params tribo_axis_q31_params_t;
typedef struct tribo_axis_q31        tribo_axis_q31_t;

/// The learned values; tribo_axis_f32_blob_t explains the members.
typedef struct
{
    uint32_t version;
    uint32_t learned[TRIBO_AXIS_LEARNED_WORDS];
    uint32_t checksum;
} tribo_axis_q31_blob_t;

#define TRIBO_AXIS_Q31_BLOB_VERSION UINT32_C(0x54413234)

/// Initialises an axis. Returns a status of tribo_axis_f32_init, TRIBO_ERR_FULL_SCALE, or TRIBO_ERR_AXIS_BREAKAWAY for a
/// breakaway too small for the scale. Choose a full scale that holds every force, limit and breakaway, or twice as much.
tribo_status_t tribo_axis_q31_init(tribo_axis_q31_t *axis, const tribo_axis_f32_config_t *config, float full_scale_n);

/// Learns from the last sample in float32, and returns whether there was one. Call it in the background once in 10
/// ticks or more often, on the core of the tick (on another one under a lock). A late call slows learning down, and
/// `late` of the report counts it.
bool tribo_axis_q31_learn(tribo_axis_q31_t *axis);

/// Runs one tick, which does not learn: returns u, or 0 before the init.
int32_t tribo_axis_q31_step(tribo_axis_q31_t *axis, int32_t r, int32_t y);

/// The first half of a tick: returns the error for your own controller.
int32_t tribo_axis_q31_error(tribo_axis_q31_t *axis, int32_t r, int32_t y);

/// The second half of a tick: returns u for the output `v` of your controller.
int32_t tribo_axis_q31_command(tribo_axis_q31_t *axis, int32_t v);

/// Returns what the limit cut off in the last command: u minus the unlimited sum, 0 within the limits.
int32_t tribo_axis_q31_excess(const tribo_axis_q31_t *axis);

/// Writes the report, as tribo_axis_f32_report does. It computes in float32, so do not call it in the tick.
void tribo_axis_q31_report(const tribo_axis_q31_t *axis, tribo_axis_report_t *report);

/// Puts the axis to rest, between two ticks: the next tick is the first one. Learned values stay.
void tribo_axis_q31_rest(tribo_axis_q31_t *axis);

/// Clears what guard and learner have latched, and lets all friction through again. This call, a change, an export and
/// an import must be made where tribo_axis_q31_learn is called, and no tick may interrupt them.
void tribo_axis_q31_restore(tribo_axis_q31_t *axis);

/// Prepares params for a change of config while the axis runs. Returns the statuses of tribo_axis_q31_init.
tribo_status_t tribo_axis_q31_prepare(tribo_axis_q31_params_t       *next,
                                      const tribo_axis_f32_config_t *config,
                                      float                          full_scale_n);

/// Makes the axis use the prepared params from the next tick on. Returns a status of tribo_axis_f32_change, or
/// TRIBO_ERR_FULL_SCALE if `next` is for another full scale.
tribo_status_t tribo_axis_q31_change(tribo_axis_q31_t *axis, const tribo_axis_q31_params_t *next);

/// Copies the learned values to `blob`. Call it between two ticks.
void tribo_axis_q31_export(const tribo_axis_q31_t *axis, tribo_axis_q31_blob_t *blob);

/// Takes over learned values from `blob`, between two ticks. Returns a status of tribo_axis_f32_import.
tribo_status_t tribo_axis_q31_import(tribo_axis_q31_t *axis, const tribo_axis_q31_blob_t *blob);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

/// Constants of an axis, computed from its config; tribo_axis_f32_params explains them.
struct tribo_axis_q31_params
{
    tribo_force_loop_q31_params_t  loop;
    tribo_feedforward_q31_params_t feedforward;
    tribo_guard_q31_params_t       guard;
    float                          sample_time_s, full_scale_n, usual_force_n;
    uint8_t                        is_own;
};

/// tribo_axis_f32 explains the members.
struct tribo_axis_q31
{
    const tribo_axis_q31_params_t *active, *ran;
    tribo_axis_q31_params_t        params;
    tribo_controller_q31_state_t   controller;
    uint32_t                       bad_inputs;
    uint8_t                        is_far_below, is_miscalled, is_half_done;
    int32_t                        excess;
    tribo_guard_q31_state_t        guard;       ///< before `feedforward`, which so is aligned as its memory
    tribo_feedforward_q31_state_t  feedforward; ///< the last member
};

#ifdef __cplusplus
}
#endif

#endif
