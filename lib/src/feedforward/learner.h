// The learner: steps 9 to 11 of docs/feedforward.md, in float32 for both arithmetics, outside the tick.
//
// Friction and load are a sum of regressors with weights a, each over the prior's deviation:
//
//     z - D = L X_0 + L k a       k = (S_0 X_0; S_j (X_j - X_(j-1)); S_3/L; S_4 yf/L)
//
// X_j are stops that the measured force moves. A Kalman filter over travel finds a and its covariance P.

#ifndef TRIBO_FEEDFORWARD_LEARNER_H
#define TRIBO_FEEDFORWARD_LEARNER_H

#include "tribo/feedforward_f32.h"

/// A sample, in N.
typedef struct
{
    float    travelled_n, force_n, friction_n, noise_n, effort_n; ///< m, yf, z, n_y, LP(v)
    float    need_n;                                              ///< v + f - b at the last reversal
    float    L_n, load_n;                                         ///< of the model, at yf
    uint32_t flips, turns, chatter; ///< reversals, those where r did not stand, chatter of a hold
    bool     learns, moves, starts;
} learner_sample_t;

/// Nothing learned.
void tribo_learner_forget(tribo_feedforward_learner_t *x);

/// Learns from `sample`, and says what the tick shall use.
void tribo_learner_step(const tribo_feedforward_learning_t *p,
                        tribo_feedforward_learner_t        *x,
                        const learner_sample_t             *sample,
                        tribo_feedforward_f32_weights_t    *result);

/// Of two slides of a loop without a sensor: V_0 goes to `sliding` and c_0 to `constant_n` by `gain`. Both have moved by `both_n`, the last
/// one by `slid_n`.
void tribo_learner_take(const tribo_feedforward_learning_t *p,
                        tribo_feedforward_learner_t        *x,
                        float                               sliding,
                        float                               constant_n,
                        float                               gain,
                        float                               both_n,
                        float                               slid_n);

/// V_0.
float tribo_learner_sliding(const tribo_feedforward_learning_t *p, const tribo_feedforward_learner_t *x);

/// The learned load at a force.
float tribo_learner_load(const tribo_feedforward_learning_t *p, const tribo_feedforward_learner_t *x, float force_n);

/// Where breakaway is asked for, in N, and what the tick has counted.
typedef struct
{
    float    sign, force_n; ///< of the direction
    float    L_n, load_n;   ///< of the model there, without gravity
    uint32_t late, forgotten;
} learner_place_t;

tribo_feedforward_learned_t tribo_learner_readout(const tribo_feedforward_learning_t *p,
                                                  const tribo_feedforward_learner_t  *x,
                                                  const learner_place_t              *place);

void tribo_learner_restore(tribo_feedforward_learner_t *x);

#endif
