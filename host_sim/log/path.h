/// How the friction model itself would have moved on the log's u, beside the F that was recorded.
///
/// A slide tells L only where the arm neither creeps nor lags: the paper's arm creeps from a half of L on, more one way than the
/// other, which looks like a wrong scale. The model's own path has both. Played with u behind scale and bias, with L times a
/// ratio and in front of one lag for actuator and sensor, it must give F; the four are found by least squares.

#ifndef SIM_PATH_H
#define SIM_PATH_H

#include "log/log.h"

/// What is found: u = (1 + scale_error) u_true + bias, and the friction's L over that of the params.
typedef struct
{
    double scale_error, bias_n, ratio;
    double lag_s;
} sim_path_t;

/// The model to play: gives its F in each of the first `rows` rows of `log`.
typedef struct
{
    void (*play)(void *context, const sim_log_t *log, size_t rows, const sim_path_t *path, double *force_n);
    void *context;
} sim_model_t;

/// Goes down from `path` and from params that fit; with `is_scale_free` false scale_error stays 0. `left_n` is F less the path's,
/// a number for each row of the log, NAN where none is compared: beyond the rows played, and before the model can have forgotten
/// an unknown start.
bool sim_path_fit(sim_path_t        *path,
                  double            *left_n,
                  const sim_log_t   *log,
                  const sim_model_t *model,
                  const signed char *ways,
                  bool               is_scale_free,
                  sim_error_t       *error);

#endif
