// The C functions that tribo-identify calls. They simulate the library's compensator behind an actuator and in front of a
// sensor, and find the slides of a log as replay does.

#include "native.h"

#include "log/verdict.h"
#include "loop/compensator_config.h"
#include "plant/plant.h"
#include "tribo/friction_f32.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static common_friction_config_t friction_of(const identify_params_t *p)
{
    return (common_friction_config_t){.k_min         = p->k_min,
                                      .k_max         = p->k_max,
                                      .m             = p->m,
                                      .v0_n_per_s    = p->v0,
                                      .set_level     = p->set_level,
                                      .reset_level   = p->reset_level,
                                      .pulse_width_s = p->pulse_width,
                                      .gravity_n     = p->gravity,
                                      .breakaway     = {.offset_n          = p->offset_positive,
                                                        .slope             = p->slope_positive,
                                                        .negative_offset_n = {true, p->offset_negative},
                                                        .negative_slope    = {true, p->slope_negative}}};
}

static common_arm_config_t arm_of(const identify_params_t *p)
{
    return (common_arm_config_t){.inertia = p->inertia, .damping = p->damping, .stiffness = p->stiffness};
}

/// One set of parameters and its state.
typedef struct
{
    tribo_breakaway_point_f32_t    table[TRIBO_BREAKAWAY_POINTS_MAX];
    tribo_compensator_f32_params_t params;
    tribo_compensator_f32_state_t  state;
    double                         scale, actuator, sensor;
    double                         u_a, y;
} model_t;

static tribo_status_t start(model_t                 *model,
                            const identify_params_t *p,
                            const double            *table,
                            int                      points,
                            double                   h,
                            double                   u,
                            double                   start_n)
{
    common_friction_config_t       friction = friction_of(p);
    const common_arm_config_t      arm      = arm_of(p);
    tribo_compensator_f32_config_t config   = {0};
    friction.breakaway.table_count          = (unsigned)points;
    for (int i = 0; i < points; i++)
    {
        friction.breakaway.table[i] = (common_breakaway_point_t){table[3 * i], table[3 * i + 1], table[3 * i + 2]};
    }
    common_friction_config_fill(&config.friction, model->table, &friction);
    common_arm_config_fill(&config.arm, &arm);
    const tribo_status_t status = tribo_compensator_f32_init(&model->params, &config, (float)h);
    tribo_compensator_f32_reset(&model->state);
    model->scale              = p->scale;
    model->actuator           = p->actuator > 0.0 ? -expm1(-p->actuator * h) : 1.0;
    model->sensor             = p->sensor > 0.0 ? -expm1(-p->sensor * h) : 1.0;
    model->u_a                = p->scale * u;
    model->y                  = start_n;
    model->state.arm.force_n  = (float)start_n;
    model->state.friction.n_n = (float)(model->u_a - start_n + p->gravity);
    return status;
}

/// Computes y of a segment from its u. Each u is held for one interval, which is divided into `substeps`. Simulates `sets`
/// parameter sets side by side, because each step waits for the last. F begins at `start_n`. `table` has three numbers
/// per point. Returns the status of the library, 0 for success.
int identify_simulate(const identify_params_t *p,
                      const double            *table,
                      int                      points,
                      int                      sets,
                      const double            *u,
                      size_t                   rows,
                      double                   interval_s,
                      int                      substeps,
                      double                   start_n,
                      double                  *y)
{
    model_t models[IDENTIFY_SETS_MAX];
    for (int m = 0; m < sets; m++)
    {
        const tribo_status_t status = start(&models[m],
                                            &p[m],
                                            &table[(size_t)m * 3 * (size_t)points],
                                            points,
                                            interval_s / substeps,
                                            u[0],
                                            start_n);
        if (status != TRIBO_OK)
        {
            return (int)status;
        }
    }
    for (size_t k = 0; k < rows; k++)
    {
        for (int m = 0; m < sets; m++)
        {
            y[(size_t)m * rows + k] = models[m].y;
        }
        for (int i = 0; i < substeps; i++)
        {
            for (int m = 0; m < sets; m++)
            {
                tribo_compensator_f32_signals_t signals;
                model_t *const                  model = &models[m];
                // As in the plant, the arm sees the actuator's force at the end of the step.
                model->u_a += model->actuator * (model->scale * u[k] - model->u_a);
                (void)tribo_compensator_f32_step(&model->params, &model->state, (float)model->u_a, &signals);
                model->y += model->sensor * ((double)model->state.arm.force_n - model->y);
            }
        }
    }
    return 0;
}

/// Returns a model's own parameters in the order of its keys: the values of `given`, or the default for each NaN.
static void own_of(const common_key_t *key, const double *given, void *own)
{
    for (; key != NULL && key->name != NULL; key++, given++)
    {
        char *const  at    = (char *)own + key->offset;
        const double value = isnan(*given) ? key->standard : *given;
        const int    word  = (int)value;
        memcpy(at,
               key->type == COMMON_KEY_CHOICE ? (const void *)&word : &value,
               key->type == COMMON_KEY_CHOICE ? sizeof word : sizeof value);
    }
}

/// Computes y of tribo-sim's plant from u. Each u is held for one interval, which is divided into `substeps`. The plant
/// begins at rest, at F = 0. `truth` is the model of the arm's friction; `given` has SIM_TRUTH_DOUBLES_MAX of its own
/// parameters in the order of own_of, without whole numbers. Returns 0, or -1 for an unknown model or without memory.
int identify_play(const char              *truth,
                  const identify_params_t *p,
                  const double            *given,
                  const double            *u,
                  size_t                   rows,
                  double                   interval_s,
                  int                      substeps,
                  double                  *y)
{
    double own[SIM_TRUTH_DOUBLES_MAX];
    int    model = 0;
    while (model < SIM_TRUTH_COUNT && strcmp(sim_truth_models[model]->name, truth) != 0)
    {
        model++;
    }
    if (model == SIM_TRUTH_COUNT)
    {
        return -1;
    }
    own_of(sim_truth_models[model]->keys, given, own);
    const sim_plant_config_t config = {.step_s                  = interval_s / substeps,
                                       .actuator_pole_rad_per_s = p->actuator,
                                       .sensor_pole_rad_per_s   = p->sensor,
                                       .truth = {.friction = friction_of(p), .arm = arm_of(p), .own = own}};
    sim_plant_t *const       plant  = sim_plant_create(&config, sim_truth_models[model]);
    if (plant == NULL)
    {
        return -1;
    }
    for (size_t k = 0; k < rows; k++)
    {
        y[k] = sim_plant_filtered_force(plant);
        for (int i = 0; i < substeps; i++)
        {
            sim_plant_signals_t signals;
            sim_plant_step(plant, p->scale * u[k], &signals);
        }
    }
    sim_plant_destroy(plant);
    return 0;
}

const char *identify_status_text(int status)
{
    return tribo_status_text((tribo_status_t)status);
}

/// Finds the directions of slow slides in a segment as replay's verdict does. Returns 0, or -1 without memory.
int identify_slides(const double *u, double *force, size_t rows, double interval_s, signed char *ways)
{
    common_error_t error    = {""};
    size_t         starts[] = {0, rows};
    float         *n        = malloc(rows * sizeof *n);
    sim_log_t      log      = {.rows = rows, .segments = 1, .sample_time_s = interval_s, .starts = starts};
    log.values[SIM_LOG_F]   = force;
    for (size_t k = 0; n != NULL && k < rows; k++)
    {
        n[k] = (float)(u[k] - force[k]);
    }
    const int status = n != NULL && sim_verdict_find_slides(&log, n, ways, &error) ? 0 : -1;
    free(n);
    return status;
}
