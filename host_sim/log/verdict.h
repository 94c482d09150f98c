/// Judges the friction params by a replayed log, and whether the log suffices to do so.
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
    float         *n, *L, *f; ///< L is the one for the sign of n
    unsigned char *q;
    bool           is_measured; ///< F came from the log; its noise switches Q, which is not a fault of the params
} sim_replayed_t;

typedef struct
{
    size_t ticks;
    bool   has_force;

    double net_rms_n, net_peak_n;           ///< rms and peak of n = u - F + g
    double residual_rms_n, residual_peak_n; ///< rms and peak of n - f
    double limit_share;                     ///< fraction of ticks with f at +-L
    double q_per_s;                         ///< switches of Q a second

    size_t moving;        ///< ticks of slow sliding, the only ones that reveal L
    size_t rising;        ///< those of them with F rising
    double low_n, high_n; ///< range of F in them
    size_t against;       ///< those of them in which friction opposes the motion
    /// Those of them with known speed or position; `against` counts only these, or all if there are none.
    size_t has_motion;

    bool   is_fitted;
    bool   is_by_path; ///< true: fitted by the path; false: by the line through the slides
    double scale_error, bias_n;
    double ratio;           ///< friction in newtons of F divided by L
    bool   scale_is_fitted; ///< the forces differ enough to fit a scale

    size_t fault_count;
    char   words[8][192];
} sim_verdict_t;

/// Makes the verdict, which says little if the log has no force. `model` is made from the params.
bool sim_verdict_make(sim_verdict_t        *verdict,
                      const sim_log_t      *log,
                      const sim_replayed_t *replayed,
                      const sim_model_t    *model,
                      common_error_t       *error);

void sim_verdict_write(const sim_verdict_t *verdict, const sim_log_t *log, FILE *file);

/// Writes the direction of slow sliding in each row, +1, -1 or 0, to `ways`, which has log->rows elements.
bool sim_verdict_find_slides(const sim_log_t *log, const float *n, signed char *ways, common_error_t *error);

#endif
