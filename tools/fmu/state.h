/// A model's saved state, as fmi2FMUstate and fmi3FMUState point to one.

#ifndef FMU_STATE_H
#define FMU_STATE_H

#include "model.h"

/// Saves into `*state`, which is null or of an earlier call. False: there is no memory.
bool fmu_state_save(const fmu_model_t *model, void **state);

/// False: `fmu_model_error` says why.
bool fmu_state_load(fmu_model_t *model, const void *state);
void fmu_state_free(void **state);

/// The bytes of a serialised state. False: `bytes` has no room for them, or there is no memory.
size_t fmu_state_size(const void *state);
bool   fmu_state_to_bytes(const void *state, void *bytes, size_t size);
bool   fmu_state_from_bytes(const void *bytes, size_t size, void **state);

#endif
