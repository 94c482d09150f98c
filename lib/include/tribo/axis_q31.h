/// A force axis in one struct, Q31: the twin of axis_f32.h. Config and report are the same, in N; forces of a tick are Q31 of the full
/// scale that the init is given. Not synchronized: one axis, one tick.

#ifndef TRIBO_AXIS_Q31_H
#define TRIBO_AXIS_Q31_H

#include "tribo/axis_f32.h"
#include "tribo/feedforward_q31.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_axis_q31_params tribo_axis_q31_params_t;
typedef struct tribo_axis_q31        tribo_axis_q31_t;

/// See the twin; the full scale is part of the rig.
typedef struct
{
    uint32_t version, rig;
    uint32_t learned[TRIBO_AXIS_LEARNED_WORDS];
    uint32_t checksum;
} tribo_axis_q31_blob_t;

#define TRIBO_AXIS_Q31_BLOB_VERSION UINT32_C(0x54413232)

/// See the twin, whose statuses these are, or TRIBO_ERR_FULL_SCALE. Forces, limits and breakaway fit into the full scale; better twice.
tribo_status_t tribo_axis_q31_init(tribo_axis_q31_t *axis, const tribo_axis_f32_config_t *config, float full_scale_n);

/// In the background, once in 10 ticks or more often: learns from the sample of the tick, in float32. True where there was one. Later costs time
/// to learn, and is counted in `late` of the report.
bool tribo_axis_q31_learn(tribo_axis_q31_t *axis);

/// One tick, which does not learn. 0 before the init.
int32_t tribo_axis_q31_step(tribo_axis_q31_t *axis, int32_t r, int32_t y);

/// See the twin.
int32_t tribo_axis_q31_error(tribo_axis_q31_t *axis, int32_t r, int32_t y);

/// See the twin.
int32_t tribo_axis_q31_command(tribo_axis_q31_t *axis, int32_t v);

/// See the twin.
int32_t tribo_axis_q31_excess(const tribo_axis_q31_t *axis);

/// See the twin; with float, so not for the tick.
void tribo_axis_q31_report(const tribo_axis_q31_t *axis, tribo_axis_report_t *report);

/// See the twin.
void tribo_axis_q31_restore(tribo_axis_q31_t *axis);

/// See the twin; another full scale is refused with TRIBO_ERR_FULL_SCALE.
tribo_status_t tribo_axis_q31_prepare(tribo_axis_q31_params_t       *next,
                                      const tribo_axis_f32_config_t *config,
                                      float                          full_scale_n);

/// Hands the prepared params over, between two ticks; see the twin.
tribo_status_t tribo_axis_q31_change(tribo_axis_q31_t *axis, const tribo_axis_q31_params_t *next);

/// See the twin.
void tribo_axis_q31_export(const tribo_axis_q31_t *axis, tribo_axis_q31_blob_t *blob);

/// See the twin.
tribo_status_t tribo_axis_q31_import(tribo_axis_q31_t *axis, const tribo_axis_q31_blob_t *blob);

// --- what they hold: give it room; write only what a comment says ------------------------------------------------------

/// See the twin.
struct tribo_axis_q31_params
{
    tribo_force_loop_q31_params_t  loop;
    tribo_feedforward_q31_params_t feedforward;
    tribo_guard_q31_params_t       guard;
    float                          sample_time_s, full_scale_n, usual_force_n, breakaway_n;
    uint32_t                       rig;
};

struct tribo_axis_q31
{
    const tribo_axis_q31_params_t *active; ///< null before the init
    tribo_axis_q31_params_t        params;
    tribo_force_loop_q31_state_t   loop;
    tribo_feedforward_q31_memory_t memory;
    int32_t                        excess;
};

#ifdef __cplusplus
}
#endif

#endif
