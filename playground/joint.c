#include "joint.h"

#include "tribo/joint_f32.h"

#include <math.h>

#define PI         3.14159265358979323846
#define TICK_S     1e-3
#define SUBSTEPS   10
#define INERTIA    0.0126 // kg m^2
#define EFFORT_MAX 3.0    // N m
#define SLOW       0.05   // rad/s; at this speed half of the extra friction is left
#define DAMPING    0.7    // of the position loop

const char *const joint_column_names[JOINT_COLUMNS] = {"t_s", "q_ref", "q", "error", "u", "friction", "low", "high"};

typedef struct
{
    double angle, speed;
} plant_t;

/// Advances the plant by one tick. It has Coulomb friction plus extra friction at standstill.
static void plant_step(plant_t *plant, const joint_settings_t *settings, double u)
{
    const double step = TICK_S / SUBSTEPS;
    for (int i = 0; i < SUBSTEPS; i++)
    {
        const double slow     = plant->speed / SLOW;
        const double friction = settings->friction * (1.0 + settings->extra / (1.0 + slow * slow));
        const double push =
            u - settings->load + INERTIA * plant->speed / step; // the force that would stop it in one step
        plant->speed = fabs(push) <= friction ? 0.0 : (push - copysign(friction, push)) * step / INERTIA;
        plant->angle += step * plant->speed;
    }
}

/// Returns the reference, -1 to 1, at `phase`, 0 to 1. The sine is a polynomial with an error of 2e-4, because the last bit
/// of libm's sine differs between platforms.
static double shape_of(double shape, double phase)
{
    const double triangle = phase < 0.25 ? 4.0 * phase : phase < 0.75 ? 2.0 - 4.0 * phase : 4.0 * phase - 4.0;
    if (shape == 1.0)
    {
        return triangle;
    }
    if (shape == 2.0)
    {
        return fmin(fmax(2.0 * triangle, -1.0), 1.0);
    }
    const double x = triangle * triangle;
    return triangle * (1.5706268 + x * (-0.6432292 + x * 0.0727102));
}

bool joint_play(const joint_settings_t *settings,
                double *const           columns[JOINT_COLUMNS],
                joint_result_t         *result,
                common_error_t         *error)
{
    const double         count   = 2.0 * PI / settings->counts;
    const double         damping = 2.0 * DAMPING * sqrt(settings->stiffness * INERTIA);
    plant_t              plant   = {0.0, 0.0};
    double               last    = 0.0;
    tribo_joint_f32_t    joint;
    tribo_joint_report_t report;
    tribo_joint_config_t config = tribo_joint_config();
    config.sample_time_s        = (float)TICK_S;
    config.effort_max           = (float)EFFORT_MAX;
    config.travel               = (float)(4.0 * count);
    config.breakaway            = (float)settings->guess;
    config.gain                 = (float)settings->gain;
    const tribo_status_t status = tribo_joint_f32_init(&joint, &config);
    if (status != TRIBO_OK)
    {
        return common_error_set(error, "%s", tribo_status_text(status));
    }
    *result = (joint_result_t){.rms_error = 0.0};
    for (int tick = 0; tick < JOINT_TICKS; tick++)
    {
        const double periods = tick * TICK_S / settings->period_s;
        const double q_ref   = settings->amplitude * shape_of(settings->shape, periods - floor(periods));
        const double q       = count * floor(plant.angle / count);
        const double off     = q_ref - q;
        const double effort  = settings->stiffness * off + damping * (off - last) / TICK_S;
        const double u       = (double)tribo_joint_f32_step(&joint, (float)effort, (float)q_ref, (float)q);
        tribo_joint_f32_report(&joint, &report);
        last = off;

        const double row[JOINT_COLUMNS] = {tick * TICK_S,
                                           q_ref,
                                           plant.angle,
                                           q_ref - plant.angle,
                                           u,
                                           (double)report.friction,
                                           (double)report.low,
                                           (double)report.high};
        for (int i = 0; i < JOINT_COLUMNS; i++)
        {
            columns[i][tick] = row[i];
        }
        if (tick >= JOINT_START)
        {
            result->rms_error += row[3] * row[3];
            result->max_error = fmax(result->max_error, fabs(row[3]));
        }
        plant_step(&plant, settings, u);
    }
    result->rms_error = sqrt(result->rms_error / (JOINT_TICKS - JOINT_START));
    result->cause     = tribo_joint_cause_text(report.cause);
    return true;
}
