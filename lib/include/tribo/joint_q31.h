/// A joint with a current measurement and an encoder, Q31. joint_f32.h explains each call. Effort is Q31 of the
/// config's effort_max. Positions are counts of the encoder, which may wrap at 32 bits. Config and report are the same,
/// in your units and counts. Not synchronized: one joint, one tick.

#ifndef TRIBO_JOINT_Q31_H
#define TRIBO_JOINT_Q31_H

#include "tribo/joint_f32.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_joint_q31 tribo_joint_q31_t;

/// Initialises a joint. Returns a status of tribo_joint_f32_init.
tribo_status_t tribo_joint_q31_init(tribo_joint_q31_t *joint, const tribo_joint_config_t *config);

/// Runs one tick: returns u. Every effort is credible.
int32_t tribo_joint_q31_step(tribo_joint_q31_t *joint, int32_t effort, int32_t q_ref, int32_t q);

/// Sets the load that your model of the arm computes.
void tribo_joint_q31_load(tribo_joint_q31_t *joint, int32_t load);

/// Puts the joint to rest, between two ticks.
void tribo_joint_q31_rest(tribo_joint_q31_t *joint);

/// Changes the gain. It computes in float32, so do not call it in the tick.
tribo_status_t tribo_joint_q31_gain(tribo_joint_q31_t *joint, float gain);

/// Clears the latched cause; the term rises again.
void tribo_joint_q31_restore(tribo_joint_q31_t *joint);

/// Returns the end-point force in the config's unit. It computes in float32.
tribo_joint_force_t tribo_joint_q31_force(const tribo_joint_q31_t *joint);

/// Writes the report. Not for the tick.
void tribo_joint_q31_report(const tribo_joint_q31_t *joint, tribo_joint_report_t *report);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

/// Constants of a tick; tribo_joint_f32_params_t explains them. Motion is Q12 of a count, parts are Q32.
typedef struct
{
    int32_t  effort_max, half, fastest;
    uint32_t gain, led, jump, level_part, observer_part, actuator_part, fade_step, rest_ticks;
    float    unit; ///< the effort of full scale
    int32_t  wrap; ///< counts of a turn; 0: positions wrap at 32 bits only
} tribo_joint_q31_params_t;

typedef struct
{
    int32_t  moved, effort, slack;
    int64_t  travel, asked[2], work, slow_travel, slow_work; ///< work: Q23 of full scale, times Q12 of a count
    int32_t  peak, knee, mean[2];
    uint32_t ticks;
    int8_t   side;
    uint8_t  follows, has[2], ended;
    int64_t  fast_travel, fast_work;
} tribo_joint_q31_slide_t;

/// tribo_joint_f32 explains the members.
struct tribo_joint_q31
{
    tribo_joint_q31_params_t params;
    uint8_t                  made, runs, learned, cause, against, turns, is_off;
    int8_t                   sign, intended;
    uint32_t                 still;
    uint32_t                 alive; ///< ticks until the term fades because the loop is off or the encoder fails
    int32_t                  q_ref, q, moved, slack, astray;
    uint32_t                 share; ///< Q32
    int32_t                  level, term, kept, load, lagged, friction, spread, offset;
    int32_t                  direction; ///< Q30
    uint32_t                 bad_inputs, limited_ticks;
    tribo_joint_q31_slide_t  slide;
};

#ifdef __cplusplus
}
#endif

#endif
