/// The model inside an FMU: loop, compensator or plant of one scenario, from the simulator's own source. fmi2.c and fmi3.c give it to
/// importers. A model has no globals but constants, so there may be several.
///
/// A variable is a number: below FMU_COLUMNS the index of a value in values.h, from there on a column of columns.h.

#ifndef FMU_MODEL_H
#define FMU_MODEL_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>

enum
{
    FMU_COLUMNS = 1000
};

typedef struct fmu_model fmu_model_t;

/// What an FMU must be called with: its modelDescription.xml's.
extern const char *const fmu_token;

/// With the scenario's values; null if there is no memory.
fmu_model_t *fmu_model_create(void);
void         fmu_model_destroy(fmu_model_t *model);

/// Back to the scenario's values, not started.
void fmu_model_reset(fmu_model_t *model);

/// Checks the values as the library does and comes to rest. False here and below: `fmu_model_error` says why.
bool        fmu_model_start(fmu_model_t *model);
const char *fmu_model_error(const fmu_model_t *model);

/// Once it has been said: the first error since then is kept.
void fmu_model_forget_error(fmu_model_t *model);

/// Sets values and inputs, all or none. Once started the values are checked as a whole, and the model goes on with them as a drive does.
bool fmu_model_set(fmu_model_t *model, const unsigned *variables, size_t count, const double *values);
bool fmu_model_get(fmu_model_t *model, unsigned variable, double *value);

/// The time from now on, in s.
void fmu_model_set_time(fmu_model_t *model, double t_s);

/// From `t_s` on as many ticks as `step_s` has, with the inputs held.
bool fmu_model_step(fmu_model_t *model, double t_s, double step_s);

/// All that a model is, for one of the same FMU on this kind of machine; state.h makes FMI's states of it.
size_t fmu_model_size(const fmu_model_t *model);
void   fmu_model_save(const fmu_model_t *model, void *bytes);
bool   fmu_model_load(fmu_model_t *model, const void *bytes, size_t size);

#endif
