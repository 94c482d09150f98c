// model.h for a door: parameters with their ranges, inputs and outputs, a state of bytes.

#include "door.h"

#include "model.h"
#include "support/error.h"

#include <fenv.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct
{
    const char *name;
    double      low, high, start;
    bool        is_tunable;
} field_t;

#define FIELD(symbol, ...) {__VA_ARGS__},
static const field_t fields[] = {FMU_FIELDS};
#undef FIELD

const char *const fmu_token = FMU_TOKEN;

typedef struct
{
    bool   is_started, was_restored;
    bool   is_stale; ///< outputs are of other values or inputs
    double values[FIELD_COUNT];
    double signals[SIGNAL_COUNT];
} state_t;

struct fmu_model
{
    state_t        now;
    void          *door;
    void          *ahead; ///< room for one more
    common_error_t error;
};

static bool refused(fmu_model_t *model, tribo_status_t status)
{
    return status == TRIBO_OK || common_error_set(&model->error, "%s", tribo_status_text(status));
}

void fmu_model_reset(fmu_model_t *model)
{
    model->now           = (state_t){.is_started = false};
    model->error.text[0] = '\0';
    for (unsigned i = 0; i < FIELD_COUNT; i++)
    {
        model->now.values[i] = fields[i].start;
    }
}

fmu_model_t *fmu_model_create(void)
{
    fmu_model_t *model = calloc(1, sizeof *model);
    if (model == NULL)
    {
        return NULL;
    }
    model->door  = calloc(1, fmu_door_size);
    model->ahead = calloc(1, fmu_door_size);
    if (model->door == NULL || model->ahead == NULL)
    {
        fmu_model_destroy(model);
        return NULL;
    }
    fmu_model_reset(model);
    return model;
}

void fmu_model_destroy(fmu_model_t *model)
{
    free(model->door);
    free(model->ahead);
    free(model);
}

const char *fmu_model_error(const fmu_model_t *model)
{
    return model->error.text;
}

void fmu_model_forget_error(fmu_model_t *model)
{
    model->error.text[0] = '\0';
}

/// As a program starts, whatever rounding or traps the importer has: the same bits in each of them.
static fenv_t enter(void)
{
    fenv_t before;
    (void)fegetenv(&before);
    (void)fesetenv(FE_DFL_ENV);
    return before;
}

bool fmu_model_start(fmu_model_t *model)
{
    const fenv_t before   = enter();
    model->now.is_started = refused(model, fmu_door_start(model->door, model->now.values));
    model->now.is_stale   = model->now.is_started;
    (void)fesetenv(&before);
    return model->now.is_started;
}

static bool is_input(unsigned variable)
{
    return variable > FMU_COLUMNS && variable <= FMU_COLUMNS + FMU_INPUTS;
}

static bool check(fmu_model_t *model, unsigned variable, double value)
{
    if (is_input(variable))
    {
        return true; // a door takes anything and counts what is bad
    }
    if (variable >= FIELD_COUNT)
    {
        return common_error_set(&model->error, "variable %u cannot be set", variable);
    }
    const field_t *const field = &fields[variable];
    if (model->now.is_started && !field->is_tunable)
    {
        return common_error_set(&model->error, "%s: cannot be set once it has started", field->name);
    }
    return (value >= field->low && value <= field->high) ||
           common_error_set(&model->error, "%s: %g is outside %g to %g", field->name, value, field->low, field->high);
}

static bool set(fmu_model_t *model, const unsigned *variables, size_t count, const double *numbers)
{
    state_t next      = model->now;
    bool    is_change = false;
    for (size_t i = 0; i < count; i++)
    {
        if (!check(model, variables[i], numbers[i]))
        {
            return false;
        }
        if (is_input(variables[i]))
        {
            next.signals[variables[i] - FMU_COLUMNS] = numbers[i];
        }
        else
        {
            next.values[variables[i]] = numbers[i];
            is_change                 = true;
        }
    }
    if (is_change && next.is_started && !refused(model, fmu_door_change(model->door, next.values)))
    {
        return false;
    }
    next.is_stale = next.is_started;
    model->now    = next;
    return true;
}

bool fmu_model_set(fmu_model_t *model, const unsigned *variables, size_t count, const double *numbers)
{
    const fenv_t before = enter();
    const bool   ok     = set(model, variables, count, numbers);
    (void)fesetenv(&before);
    return ok;
}

/// Opens latches as `restore` rises.
static void restore(const state_t *now, void *door)
{
    if (now->signals[SIGNAL_restore] > 0.5 && !now->was_restored)
    {
        fmu_door_restore(door);
    }
}

/// Outputs of the tick that a step would play now.
static void look_ahead(fmu_model_t *model)
{
    const fenv_t before = enter();
    memcpy(model->ahead, model->door, fmu_door_size);
    restore(&model->now, model->ahead);
    fmu_door_tick(model->ahead, model->now.signals);
    model->now.is_stale = false;
    (void)fesetenv(&before);
}

bool fmu_model_get(fmu_model_t *model, unsigned variable, double *value)
{
    if (FMU_DIRECT && model->now.is_stale && variable >= FMU_COLUMNS)
    {
        look_ahead(model);
    }
    if (variable < FIELD_COUNT)
    {
        *value = model->now.values[variable];
    }
    else if (variable >= FMU_COLUMNS && variable < FMU_COLUMNS + SIGNAL_COUNT)
    {
        *value = model->now.signals[variable - FMU_COLUMNS];
    }
    else
    {
        return common_error_set(&model->error, "there is no variable %u", variable);
    }
    return true;
}

void fmu_model_set_time(fmu_model_t *model, double t_s)
{
    model->now.signals[SIGNAL_t_s] = t_s;
}

bool fmu_model_step(fmu_model_t *model, double t_s, double step_s)
{
    state_t *const now   = &model->now;
    const double   h     = now->values[FIELD_sample_time_s];
    const double   ticks = round(step_s / h);
    if (!now->is_started)
    {
        return common_error_set(&model->error,
                                "it has not started: its parameters were refused, or there was no start");
    }
    if (!(ticks >= 1.0 && fabs(step_s - ticks * h) <= 1e-6 * h))
    {
        return common_error_set(&model->error,
                                "communication step: %g s is not a multiple of sample_time_s, %g s",
                                step_s,
                                h);
    }
    const fenv_t before = enter();
    restore(now, model->door);
    now->was_restored = now->signals[SIGNAL_restore] > 0.5;
    now->is_stale     = false;
    for (double i = 0.0; i < ticks; i += 1.0)
    {
        fmu_door_tick(model->door, now->signals);
    }
    fmu_door_report(model->door, now->signals);
    (void)fesetenv(&before);
    fmu_model_set_time(model, t_s + step_s);
    return true;
}

size_t fmu_model_size(const fmu_model_t *model)
{
    (void)model;
    return sizeof(state_t) + fmu_door_size;
}

void fmu_model_save(const fmu_model_t *model, void *bytes)
{
    memcpy(bytes, &model->now, sizeof model->now);
    memcpy((char *)bytes + sizeof model->now, model->door, fmu_door_size);
}

bool fmu_model_load(fmu_model_t *model, const void *bytes, size_t size)
{
    if (size != fmu_model_size(model))
    {
        return common_error_set(&model->error, "state: %zu bytes, not %zu", size, fmu_model_size(model));
    }
    memcpy(&model->now, bytes, sizeof model->now);
    memcpy(model->door, (const char *)bytes + sizeof model->now, fmu_door_size);
    return true;
}
