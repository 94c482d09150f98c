#include "keys/table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const common_key_t *common_key_below(const common_key_t *key)
{
    return key->keys_of_model != NULL ? *key->keys_of_model : key->keys;
}

const common_key_t *common_key_in(const common_key_t *keys, const char *name, size_t length)
{
    for (; keys != NULL && keys->name != NULL; keys++)
    {
        if (strncmp(keys->name, name, length) == 0 && keys->name[length] == '\0' &&
            (keys->type != COMMON_KEY_GROUP || common_key_below(keys) != NULL))
        {
            return keys;
        }
    }
    return NULL;
}

/// Parses "[index]" at *path and enters that element. Returns false if the index is missing or malformed.
static bool enter_element(common_place_t *place, const char **path, const char *group)
{
    if (place->key->type != COMMON_KEY_LIST || (*path)[1] < '0' || (*path)[1] > '9')
    {
        return false;
    }
    char         *end;
    unsigned long index = strtoul(*path + 1, &end, 10);
    if (group != NULL)
    {
        memcpy(&place->count, group + place->key->count_offset, sizeof place->count);
        place->at = (index < place->count) ? place->at + index * place->key->size : NULL;
    }
    place->is_element = true;
    *path             = end + 1;
    return *end == ']';
}

bool common_key_find(const common_key_t *keys, void *values, const char *path, common_place_t *place)
{
    char *group = values;
    *place      = (common_place_t){.key = NULL};
    while (keys != NULL)
    {
        const size_t length = strcspn(path, ".[");
        *place              = (common_place_t){.key = common_key_in(keys, path, length), .count = place->count};
        if (place->key == NULL)
        {
            return false;
        }
        place->at = (group != NULL) ? group + place->key->offset : NULL;
        path += length;
        if (*path == '[' && !enter_element(place, &path, group))
        {
            return false;
        }
        if (*path == '\0')
        {
            return true;
        }
        if (*path++ != '.' || (place->key->type == COMMON_KEY_LIST && !place->is_element))
        {
            return false;
        }
        keys  = common_key_below(place->key);
        group = place->at;
    }
    return false;
}

static void visit_below(const common_key_t *keys, char *path, size_t length, common_key_visitor_t visit, void *context)
{
    for (const common_key_t *key = keys; key != NULL && key->name != NULL; key++)
    {
        const char *dot = (length > 0) ? "." : "";
        size_t      end = length + (size_t)snprintf(path + length, COMMON_KEY_MAX - length, "%s%s", dot, key->name);
        if (key->type != COMMON_KEY_GROUP || common_key_below(key) != NULL)
        {
            visit(context, path, key);
        }
        if (key->type == COMMON_KEY_LIST)
        {
            end += (size_t)snprintf(path + end, COMMON_KEY_MAX - end, "[]");
        }
        visit_below(common_key_below(key), path, end, visit, context);
        path[length] = '\0';
    }
}

void common_key_visit(const common_key_t *keys, common_key_visitor_t visit, void *context)
{
    char path[COMMON_KEY_MAX] = "";
    visit_below(keys, path, 0, visit, context);
}

void common_key_set_defaults(const common_key_t *keys, char *group)
{
    for (const common_key_t *key = keys; key != NULL && key->name != NULL; key++)
    {
        uint64_t whole;
        int      word;
        switch (key->type)
        {
        case COMMON_KEY_NUMBER:
            memcpy(group + key->offset, &key->standard, sizeof key->standard);
            break;
        case COMMON_KEY_WHOLE:
            whole = (uint64_t)key->standard;
            memcpy(group + key->offset, &whole, sizeof whole);
            break;
        case COMMON_KEY_CHOICE:
            word = (int)key->standard;
            memcpy(group + key->offset, &word, sizeof word);
            break;
        case COMMON_KEY_GROUP:
            common_key_set_defaults(common_key_below(key), group + key->offset);
            break;
        default:
            break; // a missing or empty value is all zeros
        }
    }
}

const char *common_key_type_name(const common_key_t *key)
{
    static const char *const names[] = {[COMMON_KEY_NUMBER]   = "a number",
                                        [COMMON_KEY_OPTIONAL] = "a number",
                                        [COMMON_KEY_WHOLE]    = "a whole number",
                                        [COMMON_KEY_CHOICE]   = "a word",
                                        [COMMON_KEY_TEXT]     = "text",
                                        [COMMON_KEY_GROUP]    = "a mapping",
                                        [COMMON_KEY_LIST]     = "a list",
                                        [COMMON_KEY_SKIPPED]  = "a value"};
    return names[key->type];
}

int common_key_find_word(const common_key_t *key, const char *word)
{
    const char *meant = word;
    if (strcmp(key->words[0], "no") == 0)
    {
        meant = strcmp(word, "false") == 0 ? "no" : meant;
        meant = strcmp(word, "true") == 0 ? "yes" : meant;
    }
    int index = 0;
    while (key->words[index] != NULL && strcmp(key->words[index], meant) != 0)
    {
        index++;
    }
    return key->words[index] != NULL ? index : -1;
}

void common_key_words(const common_key_t *key, char *text, size_t size)
{
    size_t length = 0;
    text[0]       = '\0';
    for (const char *const *word = key->words; *word != NULL && length < size; word++)
    {
        const char *separator = (word == key->words) ? "" : (word[1] == NULL) ? " or " : ", ";
        length += (size_t)snprintf(text + length, size - length, "%s%s", separator, *word);
    }
}
