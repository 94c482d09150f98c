#include "keys/source.h"

#include "keys/table.h"
#include "support/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool common_sources_add(common_sources_t *sources,
                        const char       *key,
                        const char       *name,
                        size_t            line,
                        common_error_t   *error)
{
    common_source_t *larger = realloc(sources->entry, (sources->count + 1) * sizeof *larger);
    if (larger == NULL)
    {
        return common_error_set(error, "out of memory");
    }
    sources->entry         = larger;
    common_source_t *added = &sources->entry[sources->count++];
    added->is_option       = line == 0;
    added->key             = strdup(key);
    added->place           = added->is_option ? strdup(name) : common_text_format("%s:%zu", name, line);
    return (added->key != NULL && added->place != NULL) || common_error_set(error, "out of memory");
}

void common_sources_free(common_sources_t *sources)
{
    for (size_t i = 0; i < sources->count; i++)
    {
        free(sources->entry[i].key);
        free(sources->entry[i].place);
    }
    free(sources->entry);
    *sources = (common_sources_t){0};
}

/// Returns the last entry for the path in the first `length` characters of `key`; with `part_by_option` that of a --set below it.
static const common_source_t *find(const common_sources_t *sources, const char *key, size_t length, bool part_by_option)
{
    for (size_t i = sources->count; i-- > 0;)
    {
        const common_source_t *entry = &sources->entry[i];
        const char             next  = strncmp(entry->key, key, length) == 0 ? entry->key[length] : '?';
        if (part_by_option ? entry->is_option && (next == '.' || next == '[') : next == '\0')
        {
            return entry;
        }
    }
    return NULL;
}

bool common_sources_has(const common_sources_t *sources, const char *key)
{
    return find(sources, key, strlen(key), false) != NULL;
}

bool common_sources_has_part(const common_sources_t *sources, const char *key)
{
    const size_t length = strlen(key);
    for (size_t i = 0; i < sources->count; i++)
    {
        const char *written = sources->entry[i].key;
        if (strncmp(written, key, length) == 0 && strchr(".[", written[length]) != NULL)
        {
            return true;
        }
    }
    return false;
}

const common_source_t *common_sources_find(const common_sources_t *sources, const char *key)
{
    size_t                 length = strlen(key);
    const common_source_t *source = find(sources, key, length, true);
    while (source == NULL && length > 0)
    {
        source = find(sources, key, length, false);
        do
        {
            length--;
        } while (length > 0 && key[length] != '.' && key[length] != '[');
    }
    return source;
}
