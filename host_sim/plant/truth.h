/// A truth model: the arm with its friction, driven by the actuator's force. This is the seam behind which the
/// friction models fit (truths.h lists them); the actuator and the sensor around it are the same for all (plant.h).
///
/// A model is advanced by fixed steps of the plant. One that needs finer steps makes them inside its own step.

#ifndef SIM_TRUTH_H
#define SIM_TRUTH_H

#include "plant/truth_config.h"

#include <stdbool.h>
#include <stddef.h>

/// What a step saw at its start, for logging. A model without a meaning for a field leaves it 0.
typedef struct
{
    double n_n;       ///< net force
    double L_n;       ///< breakaway on the side of n
    double v_n_per_s; ///< net-force rate
    double f_n;       ///< friction
    bool   q1, q2, q; ///< relays and Eq. (8)
} sim_truth_signals_t;

/// A parameter of one model: a double in the model's parameter struct.
typedef struct
{
    const char *name; ///< as scenarios write it in plant.friction
    const char *unit; ///< "-" for a number without one
    double      min, max;
    double      initial; ///< the default
    const char *text;    ///< what it is, one line
    size_t      offset;  ///< in the parameter struct
} sim_truth_parameter_t;

typedef struct
{
    const char *name; ///< as scenarios write it in plant.model

    /// A model at rest, null if there is no memory. Values are checked by the caller, see scenario/config.h.
    void *(*create)(const sim_truth_config_t *config, double step_s);

    /// Back to rest at F = 0.
    void (*reset)(void *model);

    /// Advances one plant step with `u_n` held and returns the end-point force F at its end.
    double (*step)(void *model, double u_n, sim_truth_signals_t *signals);

    void (*destroy)(void *model);

    const char                  *text; ///< what it is, one line
    const sim_truth_parameter_t *parameters;
    size_t                       parameter_count;
    size_t parameters_size; ///< of the parameter struct, which config.friction.parameters points to

    const struct sim_law *law; ///< the same model as differential equations (truth/law.h)
} sim_truth_ops_t;

/// The paper's model (truth/paper.c).
extern const sim_truth_ops_t sim_paper_truth;

#endif
