/// A truth model: the arm with its friction, driven by the actuator's force. The actuator and the sensor around it are the
/// same for all (plant.h).
///
/// A model is advanced by fixed steps of the plant. One that needs finer steps makes them inside its own step.
///
/// A new model is its file in truth/ (README.md there) and one row in SIM_TRUTH_MODELS. Scenarios choose it by `plant.model: NAME`. Keys
/// that only it has are rows in its file; scenarios write them as `plant.NAME.KEY`.

#ifndef SIM_TRUTH_H
#define SIM_TRUTH_H

#include "plant/truth_config.h"

#include <stdbool.h>
#include <stddef.h>

/// All of them; the first is the default. NAME stands for sim_NAME_truth.
#define SIM_TRUTH_MODELS(MODEL)                                                                                        \
    MODEL(paper)                                                                                                       \
    MODEL(torque)                                                                                                      \
    MODEL(coulomb)                                                                                                     \
    MODEL(karnopp)                                                                                                     \
    MODEL(armstrong)                                                                                                   \
    MODEL(dahl)                                                                                                        \
    MODEL(bristle)                                                                                                     \
    MODEL(reset_integrator)                                                                                            \
    MODEL(bliman_sorine)                                                                                               \
    MODEL(lubricated)                                                                                                  \
    MODEL(lugre)                                                                                                       \
    MODEL(elasto_plastic)                                                                                              \
    MODEL(leuven)                                                                                                      \
    MODEL(maxwell_slip)                                                                                                \
    MODEL(servo_mx106)                                                                                                 \
    MODEL(servo_mx64)                                                                                                  \
    MODEL(servo_xl330)                                                                                                 \
    MODEL(servo_erob80)

/// What a step saw at its start, for logging. A model without a meaning for a field leaves it 0.
typedef struct
{
    double n_n;       ///< net force
    double L_n;       ///< breakaway on the side of n
    double v_n_per_s; ///< net-force rate
    double f_n;       ///< friction
    bool   q1, q2, q; ///< relays and Eq. (8)
} sim_truth_signals_t;

typedef struct sim_truth_ops
{
    const char *name;

    /// A model at rest, null if there is no memory. Values are checked by the caller, see scenario/keys.c.
    void *(*create)(const sim_truth_config_t *config, double step_s);

    /// Back to rest at F = 0.
    void (*reset)(void *model);

    /// Advances one plant step with `u_n` held and returns the end-point force F at its end.
    double (*step)(void *model, double u_n, sim_truth_signals_t *signals);

    void (*destroy)(void *model);

    /// The model's own keys, each made by SIM_TRUTH_KEY, ended by a row of zeros; null if it has none.
    const sim_key_t *keys;

    const char           *text; ///< what it is, one line
    const struct sim_law *law;  ///< the same model as differential equations (truth/law.h)
} sim_truth_ops_t;

#define SIM_TRUTH_KEYS_MAX 16

/// The row of a model's own number: `index` is where create finds it in config->own.
#define SIM_TRUTH_KEY(index, name_, unit_, min_, max_, standard_, text_)                                               \
    {.name     = (name_),                                                                                              \
     .type     = SIM_KEY_NUMBER,                                                                                       \
     .offset   = (index) * sizeof(double),                                                                             \
     .unit     = (unit_),                                                                                              \
     .min      = (min_),                                                                                               \
     .max      = (max_),                                                                                               \
     .standard = (standard_),                                                                                          \
     .text     = (text_)}

#define SIM_TRUTH_DECLARE(name)   extern const sim_truth_ops_t sim_##name##_truth;
#define SIM_TRUTH_NUMBER_OF(name) SIM_TRUTH_##name,
SIM_TRUTH_MODELS(SIM_TRUTH_DECLARE)

/// The models by number.
typedef enum
{
    SIM_TRUTH_MODELS(SIM_TRUTH_NUMBER_OF) SIM_TRUTH_COUNT
} sim_truth_number_t;

extern const sim_truth_ops_t *const sim_truth_models[SIM_TRUTH_COUNT];

/// Null if there is no model of that name.
const sim_truth_ops_t *sim_truth_find(const char *name);

/// How many keys of its own a model has; they take as many doubles in config->own.
size_t sim_truth_key_count(const sim_truth_ops_t *truth);

/// Writes the values of the model's own keys, or their defaults where `own` is null, to `numbers`.
void sim_truth_numbers(const sim_truth_ops_t *truth, const double *own, double numbers[]);

#endif
