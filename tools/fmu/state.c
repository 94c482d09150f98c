#include "state.h"

#include <stdlib.h>
#include <string.h>

typedef struct
{
    size_t size;
    char   bytes[];
} saved_t;

/// Room for `size` bytes in `*state`; null if there is no memory.
static saved_t *make(void **state, size_t size)
{
    saved_t *saved = *state;
    if (saved == NULL || saved->size != size)
    {
        free(saved);
        saved  = malloc(sizeof *saved + size);
        *state = saved;
    }
    if (saved != NULL)
    {
        saved->size = size;
    }
    return saved;
}

bool fmu_state_save(const fmu_model_t *model, void **state)
{
    saved_t *saved = make(state, fmu_model_size(model));
    if (saved == NULL)
    {
        return false;
    }
    fmu_model_save(model, saved->bytes);
    return true;
}

bool fmu_state_load(fmu_model_t *model, const void *state)
{
    const saved_t *saved = state;
    return fmu_model_load(model, saved->bytes, saved->size);
}

void fmu_state_free(void **state)
{
    free(*state);
    *state = NULL;
}

size_t fmu_state_size(const void *state)
{
    return ((const saved_t *)state)->size;
}

bool fmu_state_to_bytes(const void *state, void *bytes, size_t size)
{
    const saved_t *saved = state;
    if (size < saved->size)
    {
        return false;
    }
    memcpy(bytes, saved->bytes, saved->size);
    return true;
}

bool fmu_state_from_bytes(const void *bytes, size_t size, void **state)
{
    saved_t *saved = make(state, size);
    if (saved == NULL)
    {
        return false;
    }
    memcpy(saved->bytes, bytes, size);
    return true;
}
