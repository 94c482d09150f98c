/// Compares the recorded F with the F of the friction model driven by the log's u.
///
/// A slide reveals L only where the arm neither creeps nor lags. The paper's arm creeps from half of L on, more in one
/// direction than in the other, which looks like a wrong scale. The model's own path contains creep and lag. Driven by u with
/// a scale and a bias, with L times a ratio and followed by one lag for actuator and sensor, it must reproduce F. Least squares
/// find these four.

#ifndef SIM_PATH_H
#define SIM_PATH_H

#include "log/log.h"

/// The result: u = (1 + scale_error) u_true + bias, and the ratio of the friction's L to that of the params.
typedef struct
{
    double scale_error, bias_n, ratio;
    double lag_s;
} sim_path_t;

/// Plays the model and writes its F in each of the first `rows` rows of `log`.
typedef struct
{
    void (*play)(void *context, const sim_log_t *log, size_t rows, const sim_path_t *path, double *force_n);
    void *context;
} sim_model_t;

/// Fits the path by least squares, starting from `path` and from correct params. If `is_scale_free` is false, scale_error
/// stays 0. `left_n` receives F minus the path's F for each row of the log. It is NAN beyond the rows played, and until the
/// model has surely forgotten its unknown start.
bool sim_path_fit(sim_path_t        *path,
                  double            *left_n,
                  const sim_log_t   *log,
                  const sim_model_t *model,
                  const signed char *ways,
                  bool               is_scale_free,
                  common_error_t    *error);

#endif
