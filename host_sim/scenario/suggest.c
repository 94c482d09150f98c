#include "scenario/suggest.h"

#include "scenario/schema.h"

#include <stdio.h>
#include <string.h>

typedef struct
{
    const char *wanted;
    size_t      best;
    char        key[SIM_KEY_MAX];
} search_t;

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

/// Levenshtein's distance, one row at a time.
static size_t distance(const char *a, const char *b)
{
    size_t       row[SIM_KEY_MAX + 1];
    const size_t width = smaller(strlen(b), SIM_KEY_MAX);
    for (size_t j = 0; j <= width; j++)
    {
        row[j] = j;
    }
    for (size_t i = 1; a[i - 1] != '\0'; i++)
    {
        size_t diagonal = row[0];
        row[0]          = i;
        for (size_t j = 1; j <= width; j++)
        {
            const size_t above = row[j];
            const size_t swap  = diagonal + (a[i - 1] == b[j - 1] ? 0u : 1u);
            row[j]             = smaller(swap, smaller(above, row[j - 1]) + 1);
            diagonal           = above;
        }
    }
    return row[width];
}

static const char *last_part(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot != NULL ? dot + 1 : path;
}

static bool same_first_part(const char *a, const char *b)
{
    const size_t length = strcspn(a, ".");
    return length == strcspn(b, ".") && strncmp(a, b, length) == 0;
}

static void compare(void *context, const char *path, const cyaml_schema_field_t *field)
{
    (void)field;
    search_t *search = context;
    size_t    found  = distance(search->wanted, path);
    if (strcmp(last_part(search->wanted), last_part(path)) == 0)
    {
        found = smaller(found, same_first_part(search->wanted, path) ? 1 : 2);
    }
    if (found < search->best)
    {
        search->best = found;
        (void)snprintf(search->key, sizeof search->key, "%s", path);
    }
}

bool sim_suggest(const cyaml_schema_value_t *root, const char *path, char *suggestion, size_t size)
{
    // A third of the letters of the last part may differ, and two at least.
    const size_t third  = strlen(last_part(path)) / 3;
    search_t     search = {.wanted = path, .best = (third > 2 ? third : 2) + 1};
    sim_schema_visit(root, compare, &search);
    (void)snprintf(suggestion, size, "%s", search.key);
    return search.key[0] != '\0';
}
