#include "scenario/source.h"

#include "scenario/schema.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool sim_sources_add(sim_sources_t *sources, const char *key, const char *place, sim_error_t *error)
{
    void *larger = realloc(sources->entry, (sources->count + 1) * sizeof *sources->entry);
    if (larger == NULL)
    {
        return sim_error_set(error, "out of memory");
    }
    sources->entry                       = larger;
    sources->entry[sources->count].key   = strdup(key);
    sources->entry[sources->count].place = strdup(place);
    sources->count++;
    if (sources->entry[sources->count - 1].key == NULL || sources->entry[sources->count - 1].place == NULL)
    {
        return sim_error_set(error, "out of memory");
    }
    return true;
}

void sim_sources_free(sim_sources_t *sources)
{
    for (size_t i = 0; i < sources->count; i++)
    {
        free(sources->entry[i].key);
        free(sources->entry[i].place);
    }
    free(sources->entry);
    *sources = (sim_sources_t){0};
}

static const char *find_exactly(const sim_sources_t *sources, const char *key)
{
    for (size_t i = sources->count; i-- > 0;)
    {
        if (strcmp(sources->entry[i].key, key) == 0)
        {
            return sources->entry[i].place;
        }
    }
    return NULL;
}

bool sim_sources_has(const sim_sources_t *sources, const char *key)
{
    return find_exactly(sources, key) != NULL;
}

bool sim_source_is_set(const char *place)
{
    return strncmp(place, "--set ", 6) == 0;
}

/// The last --set of a part of what `key` names.
static const char *find_set_below(const sim_sources_t *sources, const char *key)
{
    const size_t length = strlen(key);
    for (size_t i = sources->count; i-- > 0;)
    {
        const char *found = sources->entry[i].key;
        if (strncmp(found, key, length) == 0 && (found[length] == '.' || found[length] == '[') &&
            sim_source_is_set(sources->entry[i].place))
        {
            return sources->entry[i].place;
        }
    }
    return NULL;
}

const char *sim_sources_find(const sim_sources_t *sources, const char *key)
{
    char path[SIM_KEY_MAX];
    (void)snprintf(path, sizeof path, "%s", key);
    const char *place = find_set_below(sources, path);
    place             = place != NULL ? place : find_exactly(sources, path);
    while (place == NULL)
    {
        char *const dot     = strrchr(path, '.');
        char *const bracket = strrchr(path, '[');
        char *const cut     = (bracket != NULL && (dot == NULL || bracket > dot)) ? bracket : dot;
        if (cut == NULL)
        {
            return NULL;
        }
        *cut  = '\0';
        place = find_exactly(sources, path);
    }
    return place;
}
