/// Judges the friction params by a replayed log, and whether the log suffices for it.
///
/// While the arm slides slowly, n = u - F + g is +L in a rise of F and -L in a fall, whatever the compensator did. A least
/// squares fit over these ticks,
///
///     n = scale_error F + bias + ratio (+-L(F)),
///
/// separates a wrong scale of u (equal in both directions, grows with F), a bias (equal, constant) and a wrong L (differs by
/// direction). An L that is too large leaves no residual while f = n; here it shows as a ratio below 1.
/// Slides are found from F alone: a play wider than the noise must have moved by more than a run-in.
/// The line ignores lag and creep. Where the model's own path (path.h) fits F in the slides better than the line fits n, it
/// supplies scale, bias and ratio.

#ifndef SIM_VERDICT_H
#define SIM_VERDICT_H

#include "log/log.h"
#include "log/path.h"

#include <stdio.h>

/// The replay's results by row of the log.
typedef struct
{
    float         *n, *L, *f; ///< L for the sign of n
    unsigned char *q;
    bool           is_measured; ///< F was the log's, whose noise switches Q: no fault of the params
} sim_replayed_t;

typedef struct
{
    size_t ticks;
    bool   has_force;

    double net_rms_n, net_peak_n;           ///< of n: u - F + g
    double residual_rms_n, residual_peak_n; ///< of n - f
    double limit_share;                     ///< of ticks with f at +-L
    double q_per_s;                         ///< switches of Q

    size_t moving;        ///< ticks of slow sliding, the only ones that reveal L
    size_t rising;        ///< of these, with F rising
    double low_n, high_n; ///< of F in them
    size_t against;       ///< of these, where friction opposes the motion
    size_t has_motion;    ///< of these, with speed or position known; `against` counts those, or all if none

    bool   is_fitted;
    bool   is_by_path; ///< else by the line through the slides
    double scale_error, bias_n;
    double ratio;           ///< of friction in newtons of F over L
    bool   scale_is_fitted; ///< the forces differ enough

    size_t fault_count;
    char   words[8][192];
} sim_verdict_t;

/// Makes the verdict; a log without force allows little. `model` is that of the params.
bool sim_verdict_make(sim_verdict_t        *verdict,
                      const sim_log_t      *log,
                      const sim_replayed_t *replayed,
                      const sim_model_t    *model,
                      common_error_t       *error);

void sim_verdict_write(const sim_verdict_t *verdict, const sim_log_t *log, FILE *file);

/// The direction of a slow slide for each row, +1, -1 or 0, in `ways` of log->rows.
bool sim_verdict_find_slides(const sim_log_t *log, const float *n, signed char *ways, common_error_t *error);

#endif
