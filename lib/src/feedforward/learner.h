// The learner: steps 9 to 11 of docs/feedforward.md. It runs outside the tick, in float32 for both arithmetics.
//
// Measured friction z, less the configured load D, is the configured breakaway L times the stop X_0, plus a correction.
// The correction is a sum of regressors k with weights a, each in units of its standard deviation S before learning:
//
//     z - D = L X_0 + L k a       k = (S_0 X_0; S_j (X_j - X_(j-1)); S_3/L; S_4 yf/L)
//
// The measured force moves the stops X_j. A Kalman filter that steps with travel instead of time finds a and its
// covariance P. So an arm at rest neither learns nor forgets.

#ifndef TRIBO_FEEDFORWARD_LEARNER_H
#define TRIBO_FEEDFORWARD_LEARNER_H

#include "tribo/feedforward_f32.h"

/// A sample of the tick. Forces are in N.
typedef struct
{
    float    travelled_n, force_n, friction_n, noise_n, effort_n; ///< m, yf, z, n_y, LP(v)
    float    need_n;                                              ///< v + f - b at the last reversal
    float    L_n, load_n;                                         ///< configured breakaway L and load D at the force yf
    uint32_t flips, turns, chatter; ///< since the last sample: reversals, those while r moved, chatter of a hold
    bool     learns;                ///< the arm may slide, u is not limited and y is good
    bool     moves;                 ///< f follows r
    bool     starts;                ///< first sample of a run
} learner_sample_t;

/// Sets everything learned to the prior.
void tribo_learner_forget(tribo_feedforward_learner_t *x);

/// Learns from `sample` and writes the weights for the tick to `result`.
void tribo_learner_step(const tribo_feedforward_learning_t *p,
                        tribo_feedforward_learner_t        *x,
                        const learner_sample_t             *sample,
                        tribo_feedforward_f32_weights_t    *result);

/// Learns from two slides of a loop without a force sensor: moves V_0 towards `sliding` and c_0 towards `constant_n` by
/// the part `gain`. `both_n` is the travel of the shorter slide, `slid_n` that of the last one.
void tribo_learner_take(const tribo_feedforward_learning_t *p,
                        tribo_feedforward_learner_t        *x,
                        float                               sliding,
                        float                               constant_n,
                        float                               gain,
                        float                               both_n,
                        float                               slid_n);

/// Forgets everything learned, and the monitor's judgement, if the checksum does not fit, which is counted, or if it was
/// learned with params of another rig. The learned load stays if only the usual force differs. Every step and take
/// does so, too.
void tribo_learner_check(const tribo_feedforward_learning_t *p, tribo_feedforward_learner_t *x);

/// V_0, breakaway as a multiple of the configured one.
float tribo_learner_sliding(const tribo_feedforward_learning_t *p, const tribo_feedforward_learner_t *x);

/// c(F), the learned part of the force that does not reverse with the motion, at `force_n`.
float tribo_learner_load(const tribo_feedforward_learning_t *p, const tribo_feedforward_learner_t *x, float force_n);

/// Direction and force at which breakaway is requested, and the counters of the tick.
typedef struct
{
    float    sign, force_n;   ///< 1 or -1 for the direction; N
    float    L_n, load_n;     ///< configured there, without gravity, N
    uint32_t late, forgotten; ///< late results, corrupt states
} learner_place_t;

/// What tribo_feedforward_f32_learned returns.
tribo_feedforward_learned_t tribo_learner_readout(const tribo_feedforward_learning_t *p,
                                                  const tribo_feedforward_learner_t  *x,
                                                  const learner_place_t              *place);

/// 1/xi, the factor by which friction fed forward reduces the controller's work at a reversal, up to 100. 0 while it is
/// not known. Not for the tick.
float tribo_learner_times_less(const tribo_feedforward_learner_t *x);

/// Does the learner's part of tribo_feedforward_f32_restore: unlatches at_bound and harms, and ends feedback of
/// friction.
void tribo_learner_restore(tribo_feedforward_learner_t *x);

#endif
