/// An axis and a joint, in either arithmetic, in physical units.

#include "native.h"

#include "error.h"

#include "loop/joint_inputs.h"
#include "scope.h"
#include "tribo_arithmetic.h"

#include "tribo/axis_q31.h"
#include "tribo/joint_q31.h"

#include <stdlib.h>
#include <string.h>

// --- axis ------------------------------------------------------------------------------------------------------------------------

struct native_axis
{
    bool                q31;
    double              full_scale_n;
    tribo_axis_f32_t    f32;
    tribo_axis_q31_t    fixed;
    tribo_axis_report_t report;

    tribo_axis_f32_params_t f32_made[3]; ///< params of changes: the active ones, those of the last tick, and room
    tribo_axis_q31_params_t fixed_made[3];
};

static tribo_axis_controller_t controller_of(const char                       *kind,
                                             const float                      *numbers,
                                             const tribo_biquad_f32_section_t *sections,
                                             unsigned                          count)
{
    if (strcmp(kind, "pi") == 0)
    {
        return tribo_pi(numbers[14], numbers[15]);
    }
    if (strcmp(kind, "sections") == 0)
    {
        return tribo_sections(sections, count);
    }
    if (strcmp(kind, "paper") == 0)
    {
        return tribo_paper();
    }
    return strcmp(kind, "own") == 0 ? tribo_own() : (tribo_axis_controller_t){.kind = TRIBO_CONTROLLER_NONE};
}

/// `own` is room for the sections.
static tribo_axis_f32_config_t config_of(const float                numbers[19],
                                         const char                *kind,
                                         const float               *sections,
                                         unsigned                   count,
                                         tribo_biquad_f32_section_t own[TRIBO_BIQUAD_SECTIONS_MAX])
{
    const unsigned known = count < TRIBO_BIQUAD_SECTIONS_MAX ? count : TRIBO_BIQUAD_SECTIONS_MAX;
    for (unsigned i = 0; i < known; i++)
    {
        const float *const x = &sections[5u * i];
        own[i]               = (tribo_biquad_f32_section_t){x[0], x[1], x[2], x[3], x[4]};
    }
    tribo_axis_f32_config_t config             = tribo_axis_f32_config();
    config.sample_time_s                       = numbers[0];
    config.u_min_n                             = numbers[1];
    config.u_max_n                             = numbers[2];
    config.input_max_n                         = numbers[3];
    config.usual_force_n                       = numbers[4];
    config.positive                            = (tribo_breakaway_f32_t){numbers[5], numbers[6]};
    config.negative                            = (tribo_breakaway_f32_t){numbers[7], numbers[8]};
    config.gravity_n                           = numbers[9];
    config.arm_lag_s                           = numbers[10];
    config.noise_n                             = numbers[11];
    config.feedforward.actuator_pole_rad_per_s = numbers[12];
    config.feedforward.sensor_pole_rad_per_s   = numbers[13];
    config.feedforward.presliding_n            = numbers[17];
    config.feedforward.still_time_s            = numbers[18];
    config.controller                          = controller_of(kind, numbers, own, count);
    return config;
}

native_axis_t *native_axis_new(bool            q31,
                               const float     numbers[19],
                               const char     *kind,
                               const float    *sections,
                               unsigned        count,
                               native_error_t *error)
{
    native_axis_t *const axis = calloc(1, sizeof *axis);
    if (axis == NULL)
    {
        native_error_say(error, "", "no memory");
        return NULL;
    }
    tribo_biquad_f32_section_t    own[TRIBO_BIQUAD_SECTIONS_MAX] = {{0}};
    const tribo_axis_f32_config_t config                         = config_of(numbers, kind, sections, count, own);
    axis->q31                                                    = q31;
    axis->full_scale_n                                           = (double)numbers[16];
    const tribo_status_t status =
        q31 ? tribo_axis_q31_init(&axis->fixed, &config, numbers[16]) : tribo_axis_f32_init(&axis->f32, &config);
    if (!native_accepted(status, error))
    {
        free(axis);
        return NULL;
    }
    return axis;
}

/// Prepares params where neither the active ones are nor those of the last tick, so that a refusal leaves both as they are.
static tribo_status_t change_f32(native_axis_t *axis, const tribo_axis_f32_config_t *config)
{
    tribo_axis_f32_params_t *made = axis->f32_made;
    while (made == axis->f32.active || made == axis->f32.ran)
    {
        made++;
    }
    const tribo_status_t status = tribo_axis_f32_prepare(made, config);
    return status == TRIBO_OK ? tribo_axis_f32_change(&axis->f32, made) : status;
}

/// Does what change_f32 does.
static tribo_status_t change_q31(native_axis_t *axis, const tribo_axis_f32_config_t *config)
{
    tribo_axis_q31_params_t *made = axis->fixed_made;
    while (made == axis->fixed.active || made == axis->fixed.ran)
    {
        made++;
    }
    const tribo_status_t status = tribo_axis_q31_prepare(made, config, (float)axis->full_scale_n);
    return status == TRIBO_OK ? tribo_axis_q31_change(&axis->fixed, made) : status;
}

bool native_axis_change(native_axis_t  *axis,
                        const float     numbers[19],
                        const char     *kind,
                        const float    *sections,
                        unsigned        count,
                        native_error_t *error)
{
    tribo_biquad_f32_section_t    own[TRIBO_BIQUAD_SECTIONS_MAX] = {{0}};
    const tribo_axis_f32_config_t config                         = config_of(numbers, kind, sections, count, own);
    const tribo_status_t          status = axis->q31 ? change_q31(axis, &config) : change_f32(axis, &config);
    return native_accepted(status, error);
}

void native_axis_delete(native_axis_t *axis)
{
    free(axis);
}

/// A tick in Q31 leaves learning to the background, which is here.
static double learned_from(native_axis_t *axis, int32_t u)
{
    (void)tribo_axis_q31_learn(&axis->fixed);
    return tribo_n_of_q31(u, axis->full_scale_n);
}

static double axis_step(native_axis_t *axis, double r_n, double y_n)
{
    const double full = axis->full_scale_n;
    return axis->q31
               ? learned_from(axis,
                              tribo_axis_q31_step(&axis->fixed, tribo_q31_of_n(r_n, full), tribo_q31_of_n(y_n, full)))
               : (double)tribo_axis_f32_step(&axis->f32, (float)r_n, (float)y_n);
}

void native_axis_play(native_axis_t *axis, const double *r_n, const double *y_n, size_t count, double *u_n)
{
    const native_scope_t scope = native_enter();
    for (size_t i = 0; i < count; i++)
    {
        u_n[i] = axis_step(axis, r_n[i], y_n[i]);
    }
    native_leave(&scope);
}

double native_axis_error(native_axis_t *axis, double r_n, double y_n)
{
    const double         full  = axis->full_scale_n;
    const native_scope_t scope = native_enter();
    const double         e_n =
        axis->q31
                    ? tribo_n_of_q31(tribo_axis_q31_error(&axis->fixed, tribo_q31_of_n(r_n, full), tribo_q31_of_n(y_n, full)),
                             full)
                    : (double)tribo_axis_f32_error(&axis->f32, (float)r_n, (float)y_n);
    native_leave(&scope);
    return e_n;
}

double native_axis_command(native_axis_t *axis, double v_n)
{
    const double         full  = axis->full_scale_n;
    const double         v     = isfinite(v_n) ? v_n : 0.0;
    const native_scope_t scope = native_enter();
    common_count_bad(&axis->fixed.bad_inputs, axis->q31 && !isfinite(v_n));
    const double u_n = axis->q31 ? learned_from(axis, tribo_axis_q31_command(&axis->fixed, tribo_q31_of_n(v, full)))
                                 : (double)tribo_axis_f32_command(&axis->f32, (float)v_n);
    native_leave(&scope);
    return u_n;
}

double native_axis_excess(const native_axis_t *axis)
{
    return axis->q31 ? tribo_n_of_q31(tribo_axis_q31_excess(&axis->fixed), axis->full_scale_n)
                     : (double)tribo_axis_f32_excess(&axis->f32);
}

void native_axis_rest(native_axis_t *axis)
{
    if (axis->q31)
    {
        tribo_axis_q31_rest(&axis->fixed);
        return;
    }
    tribo_axis_f32_rest(&axis->f32);
}

void native_axis_restore(native_axis_t *axis)
{
    if (axis->q31)
    {
        tribo_axis_q31_restore(&axis->fixed);
        return;
    }
    tribo_axis_f32_restore(&axis->f32);
}

void native_axis_report(native_axis_t *axis, double numbers[13])
{
    tribo_axis_report_t *const report = &axis->report;
    if (axis->q31)
    {
        tribo_axis_q31_report(&axis->fixed, report);
    }
    else
    {
        tribo_axis_f32_report(&axis->f32, report);
    }
    for (int i = 0; i < 2; i++)
    {
        numbers[i]     = (double)report->breakaway_n[i];
        numbers[2 + i] = (double)report->low_n[i];
        numbers[4 + i] = (double)report->high_n[i];
    }
    numbers[6]  = (double)report->travel_n;
    numbers[7]  = (double)report->times_less;
    numbers[8]  = (double)report->share;
    numbers[9]  = report->bad_inputs;
    numbers[10] = report->limited_ticks;
    numbers[11] = report->forgotten;
    numbers[12] = (double)report->breakaway_factor;
}

const char *native_axis_warning(native_axis_t *axis)
{
    return tribo_axis_warning(&axis->report.warnings);
}

size_t native_axis_blob_size(const native_axis_t *axis)
{
    return axis->q31 ? sizeof(tribo_axis_q31_blob_t) : sizeof(tribo_axis_f32_blob_t);
}

void native_axis_export(const native_axis_t *axis, void *bytes)
{
    tribo_axis_f32_blob_t f32;
    tribo_axis_q31_blob_t fixed;
    if (axis->q31)
    {
        tribo_axis_q31_export(&axis->fixed, &fixed);
        memcpy(bytes, &fixed, sizeof fixed);
        return;
    }
    tribo_axis_f32_export(&axis->f32, &f32);
    memcpy(bytes, &f32, sizeof f32);
}

bool native_axis_import(native_axis_t *axis, const void *bytes, size_t size, native_error_t *error)
{
    tribo_axis_f32_blob_t f32;
    tribo_axis_q31_blob_t fixed;
    tribo_status_t        status = TRIBO_ERR_BLOB_VERSION;
    if (size == native_axis_blob_size(axis) && axis->q31)
    {
        memcpy(&fixed, bytes, sizeof fixed);
        status = tribo_axis_q31_import(&axis->fixed, &fixed);
    }
    else if (size == native_axis_blob_size(axis))
    {
        memcpy(&f32, bytes, sizeof f32);
        status = tribo_axis_f32_import(&axis->f32, &f32);
    }
    return native_accepted(status, error);
}

// --- joint -----------------------------------------------------------------------------------------------------------------------

struct native_joint
{
    bool              q31;
    double            effort_max;
    tribo_joint_f32_t f32;
    tribo_joint_q31_t fixed;
};

native_joint_t *native_joint_new(bool q31, const float numbers[7], native_error_t *error)
{
    native_joint_t *const joint = calloc(1, sizeof *joint);
    if (joint == NULL)
    {
        native_error_say(error, "", "no memory");
        return NULL;
    }
    const tribo_joint_config_t config = {.sample_time_s           = numbers[0],
                                         .effort_max              = numbers[1],
                                         .travel                  = numbers[2],
                                         .breakaway               = numbers[3],
                                         .actuator_pole_rad_per_s = numbers[4],
                                         .gain                    = numbers[5],
                                         .wrap                    = numbers[6]};
    joint->q31                        = q31;
    joint->effort_max                 = (double)numbers[1];
    const tribo_status_t status =
        q31 ? tribo_joint_q31_init(&joint->fixed, &config) : tribo_joint_f32_init(&joint->f32, &config);
    if (!native_accepted(status, error))
    {
        free(joint);
        return NULL;
    }
    return joint;
}

void native_joint_delete(native_joint_t *joint)
{
    free(joint);
}

void native_joint_play(native_joint_t *joint,
                       const double   *effort,
                       const double   *q_ref,
                       const double   *q,
                       size_t          count,
                       double         *u)
{
    const double         full  = joint->effort_max;
    const native_scope_t scope = native_enter();
    for (size_t i = 0; i < count; i++)
    {
        if (joint->q31)
        {
            tribo_joint_q31_t *const x = &joint->fixed;
            common_count_bad(&x->bad_inputs, !isfinite(effort[i]) || !isfinite(q_ref[i]) || !isfinite(q[i]));
            const int32_t made = tribo_joint_q31_step(x,
                                                      common_joint_effort(effort[i], full, 0),
                                                      common_joint_counts(q_ref[i], x->q_ref),
                                                      common_joint_counts(q[i], x->q));
            u[i]               = tribo_n_of_q31(made, full);
        }
        else
        {
            u[i] = (double)tribo_joint_f32_step(&joint->f32, (float)effort[i], (float)q_ref[i], (float)q[i]);
        }
    }
    native_leave(&scope);
}

void native_joint_load(native_joint_t *joint, double load)
{
    if (joint->q31)
    {
        common_count_bad(&joint->fixed.bad_inputs, !isfinite(load));
        tribo_joint_q31_load(&joint->fixed, common_joint_effort(load, joint->effort_max, joint->fixed.load));
        return;
    }
    tribo_joint_f32_load(&joint->f32, (float)load);
}

bool native_joint_gain(native_joint_t *joint, double gain, native_error_t *error)
{
    const tribo_status_t status =
        joint->q31 ? tribo_joint_q31_gain(&joint->fixed, (float)gain) : tribo_joint_f32_gain(&joint->f32, (float)gain);
    return native_accepted(status, error);
}

void native_joint_rest(native_joint_t *joint)
{
    if (joint->q31)
    {
        tribo_joint_q31_rest(&joint->fixed);
        return;
    }
    tribo_joint_f32_rest(&joint->f32);
}

void native_joint_restore(native_joint_t *joint)
{
    if (joint->q31)
    {
        tribo_joint_q31_restore(&joint->fixed);
        return;
    }
    tribo_joint_f32_restore(&joint->f32);
}

void native_joint_force(const native_joint_t *joint, double force[3])
{
    const tribo_joint_force_t told =
        joint->q31 ? tribo_joint_q31_force(&joint->fixed) : tribo_joint_f32_force(&joint->f32);
    force[0] = (double)told.force;
    force[1] = (double)told.low;
    force[2] = (double)told.high;
}

const char *native_joint_report(const native_joint_t *joint, double numbers[8])
{
    tribo_joint_report_t report;
    if (joint->q31)
    {
        tribo_joint_q31_report(&joint->fixed, &report);
    }
    else
    {
        tribo_joint_f32_report(&joint->f32, &report);
    }
    numbers[0] = (double)report.friction;
    numbers[1] = (double)report.low;
    numbers[2] = (double)report.high;
    numbers[3] = (double)report.load;
    numbers[4] = (double)report.share;
    numbers[5] = report.is_learned ? 1.0 : 0.0;
    numbers[6] = report.bad_inputs;
    numbers[7] = report.limited_ticks;
    return tribo_joint_cause_text(report.cause);
}
