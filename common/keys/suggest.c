#include "keys/suggest.h"

#include "support/text.h"

#include <stdio.h>
#include <string.h>

typedef struct
{
    const char *path;
    size_t      best;
    char       *key;
} search_t;

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
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

/// Keys that an earlier version called otherwise: the last part of the old and of the new name.
static const char *const renamed[][2] = {{"lead", "jump_lead"}};

/// Returns whether `path` is the old name of the key `now`.
static bool is_renamed(const char *path, const char *now)
{
    const size_t group = (size_t)(last_part(path) - path);
    for (size_t i = 0; i < sizeof renamed / sizeof renamed[0]; i++)
    {
        if (strcmp(path + group, renamed[i][0]) == 0 && strncmp(path, now, group) == 0 &&
            strcmp(now + group, renamed[i][1]) == 0)
        {
            return true;
        }
    }
    return false;
}

static void compare(void *context, const char *path, const common_key_t *key)
{
    (void)key;
    search_t *search = context;
    size_t    found  = common_text_distance(search->path, path);
    if (strcmp(last_part(search->path), last_part(path)) == 0)
    {
        found = smaller(found, same_first_part(search->path, path) ? 1 : 2);
    }
    found = is_renamed(search->path, path) ? 0 : found;
    if (found < search->best)
    {
        search->best = found;
        (void)snprintf(search->key, COMMON_KEY_MAX, "%s", path);
    }
}

bool common_suggest(const common_key_t *keys, const char *path, char suggestion[COMMON_KEY_MAX])
{
    search_t search = {.path = path, .best = common_text_too_far(last_part(path)), .key = suggestion};
    suggestion[0]   = '\0';
    common_key_visit(keys, compare, &search);
    return suggestion[0] != '\0';
}

const char *common_suggest_word(const common_key_t *key, const char *text)
{
    // A word that differs in every letter is not a suggestion.
    const char *nearest = NULL;
    size_t      best    = smaller(common_text_too_far(text), strlen(text));
    for (const char *const *word = key->words; *word != NULL; word++)
    {
        const size_t found = common_text_distance(text, *word);
        if (found < best)
        {
            best    = found;
            nearest = *word;
        }
    }
    return nearest;
}
