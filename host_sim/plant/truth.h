/// A truth model is the arm with its friction, driven by the actuator's force. The actuator and the sensor around it are the
/// same for all models (plant.h).
///
/// Models advance by the plant's fixed step. A model that needs finer steps subdivides it.
///
/// A new model is one file, truth/NAME.c, and one row in SIM_TRUTH_MODELS. Scenarios choose it by `plant.model: NAME`. A
/// struct and rows in its file define its own parameters; in scenarios they are `plant.NAME.KEY`.

#ifndef SIM_TRUTH_H
#define SIM_TRUTH_H

#include "plant/truth_config.h"

#include <stdbool.h>

// clang-format off: one row a model
/// All models; the first is the default. NAME stands for sim_NAME_truth.
#define SIM_TRUTH_MODELS(MODEL) \
    MODEL(paper,            "breakaway of the load, hysteresis by relays") \
    MODEL(torque,           "only saturation of the net force (references 22 to 24)") \
    MODEL(coulomb,          "L(F) against the motion; stands exactly inside breakaway") \
    MODEL(karnopp,          "rest is a zone of speeds, in which the arm stands exactly") \
    MODEL(armstrong,        "seven parameters: spring, Stribeck, frictional memory, rising stiction") \
    MODEL(dahl,             "a spring that yields in space; drifts in presliding") \
    MODEL(bristle,          "20 bonds that snap at random places; noisy sliding") \
    MODEL(reset_integrator, "a bond that slips at a length, stronger while it holds") \
    MODEL(bliman_sorine,    "a peak of breakaway along the path; rate independent") \
    MODEL(lubricated,       "bearing on an oil film that lifts with a lag; frictional memory") \
    MODEL(lugre,            "bristle with damping, Eq. (12); drifts in presliding") \
    MODEL(elasto_plastic,   "bristle that yields beyond a deflection; no drift") \
    MODEL(leuven,           "bristle with hysteresis of non-local memory") \
    MODEL(maxwell_slip,     "elements that stick or slip; non-local memory") \
    MODEL(servo_mx106,      "load-dependent servo, MX-106") \
    MODEL(servo_mx64,       "load-dependent servo, MX-64") \
    MODEL(servo_xl330,      "load-dependent servo, XL-330") \
    MODEL(servo_erob80,     "load-dependent servo, eRob80:100")
// clang-format on

/// The signals at the start of a step, for logging. Fields that mean nothing in a model stay 0.
typedef struct
{
    double n_n;       ///< net force
    double L_n;       ///< breakaway for the sign of n
    double v_n_per_s; ///< net-force rate
    double f_n;       ///< friction
    bool   q1, q2, q; ///< relays and Eq. (8)
} sim_truth_signals_t;

/// A block of memory.
typedef struct
{
    void  *at;
    size_t size;
} sim_truth_part_t;

enum
{
    SIM_TRUTH_PARTS = 2
};

typedef struct
{
    const char *name;

    /// Creates a model at rest; null if there is no memory. The caller has checked the values, see scenario/keys.c.
    void *(*create)(const sim_truth_config_t *config, double step_s);

    /// Advances one plant step with `u_n` held and returns the end-point force F at its end.
    double (*step)(void *model, double u_n, sim_truth_signals_t *signals);

    void (*destroy)(void *model);

    /// Returns everything that a step changes, without pointers, so that it can be copied to a model with the same config.
    void (*parts)(void *model, sim_truth_part_t parts[SIM_TRUTH_PARTS]);

    /// The rows of the model's own parameters, ended by SIM_TRUTH_END; null if it has none. Their offsets are in the struct
    /// to which config->own points.
    const common_key_t *keys;

    const struct sim_law *law; ///< the same model as differential equations (truth/law.h)
} sim_truth_ops_t;

/// Room for a model's struct of parameters.
#define SIM_TRUTH_DOUBLES_MAX 16

#define SIM_TRUTH_NUMBER(type_, member, name_, unit_, min_, max_, standard_, text_)                                    \
    {.name     = (name_),                                                                                              \
     .type     = COMMON_KEY_NUMBER,                                                                                    \
     .offset   = offsetof(type_, member),                                                                              \
     .unit     = (unit_),                                                                                              \
     .min      = (min_),                                                                                               \
     .max      = (max_),                                                                                               \
     .standard = (standard_),                                                                                          \
     .text     = (text_)}
/// A row for a uint64_t.
#define SIM_TRUTH_WHOLE(type_, member, name_, min_, max_, standard_, text_)                                            \
    {.name     = (name_),                                                                                              \
     .type     = COMMON_KEY_WHOLE,                                                                                     \
     .offset   = offsetof(type_, member),                                                                              \
     .unit     = "-",                                                                                                  \
     .min      = (min_),                                                                                               \
     .max      = (max_),                                                                                               \
     .standard = (standard_),                                                                                          \
     .text     = (text_)}
/// A row for an int or an enum, the index of a word.
#define SIM_TRUTH_CHOICE(type_, member, name_, words_, standard_, text_)                                               \
    {.name     = (name_),                                                                                              \
     .type     = COMMON_KEY_CHOICE,                                                                                    \
     .offset   = offsetof(type_, member),                                                                              \
     .unit     = "-",                                                                                                  \
     .words    = (words_),                                                                                             \
     .standard = (standard_),                                                                                          \
     .text     = (text_)}
#define SIM_TRUTH_END {.name = NULL}

#define SIM_TRUTH_DECLARE(name, text)   extern const sim_truth_ops_t sim_##name##_truth;
#define SIM_TRUTH_NUMBER_OF(name, text) SIM_TRUTH_##name,
SIM_TRUTH_MODELS(SIM_TRUTH_DECLARE)

/// The models by number.
typedef enum
{
    SIM_TRUTH_MODELS(SIM_TRUTH_NUMBER_OF) SIM_TRUTH_COUNT
} sim_truth_number_t;

extern const sim_truth_ops_t *const sim_truth_models[SIM_TRUTH_COUNT];

#endif
