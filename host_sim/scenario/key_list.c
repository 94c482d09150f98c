#include "scenario/key_list.h"

#include "scenario/keys.h"

#include <stdio.h>
#include <string.h>

typedef struct
{
    char range[COMMON_WORDS_MAX], standard[64];
} words_t;

/// Writes a key's range and default as text, "-" if there is none.
static void describe(words_t *words, const char *path, const common_key_t *key)
{
    *words                  = (words_t){.range = "-", .standard = "-"};
    const bool has_standard = !key->is_required && strchr(path, '[') == NULL;
    switch (key->type)
    {
    case COMMON_KEY_NUMBER:
    case COMMON_KEY_WHOLE:
    case COMMON_KEY_OPTIONAL:
        (void)snprintf(words->range, sizeof words->range, "%g to %g", key->min, key->max);
        if (has_standard && key->type != COMMON_KEY_OPTIONAL)
        {
            (void)snprintf(words->standard, sizeof words->standard, "%g", key->standard);
        }
        break;
    case COMMON_KEY_CHOICE:
        if (has_standard)
        {
            (void)snprintf(words->standard, sizeof words->standard, "%s", key->words[(int)key->standard]);
        }
        break;
    default:
        break;
    }
}

static void print_line(void *context, const char *path, const common_key_t *key)
{
    (void)context;
    char    choices[COMMON_WORDS_MAX];
    words_t words;
    describe(&words, path, key);
    if (key->type == COMMON_KEY_CHOICE)
    {
        common_key_words(key, choices, sizeof choices);
    }
    if (key->type != COMMON_KEY_GROUP)
    {
        const char *type = (key->type == COMMON_KEY_CHOICE) ? choices : common_key_type_name(key);
        (void)printf("%s | %s | %s | %s\n", path, type, words.range, words.standard);
    }
}

void sim_key_list_print(void)
{
    common_key_visit(sim_keys, print_line, NULL);
}

static void print_heading(const char *title)
{
    (void)printf("\n### %s\n\n| key | unit | range | default | what |\n|---|---|---|---|---|\n", title);
}

/// Escapes each '|', which would end a cell of a table.
static void print_escaped(const char *text)
{
    for (; *text != '\0'; text++)
    {
        (void)printf("%s%c", *text == '|' ? "\\" : "", *text);
    }
}

static void print_models(void)
{
    (void)printf("\n### Truth models\n\n| `plant.model` | what |\n|---|---|\n");
#define PRINT_MODEL(name, text) (void)printf("| `%s` | %s |\n", #name, text);
    SIM_TRUTH_MODELS(PRINT_MODEL)
}

static void print_row(void *context, const char *path, const common_key_t *key)
{
    bool   *has_models = context;
    words_t words;
    describe(&words, path, key);
    if (key->type == COMMON_KEY_GROUP)
    {
        if (strchr(path, '.') == NULL)
        {
            print_heading(key->text);
        }
        else if (key->keys_of_model != NULL && !*has_models)
        {
            print_models();
            print_heading("Plant: keys that only one truth model has");
            *has_models = true;
        }
        return;
    }
    if (key->type == COMMON_KEY_CHOICE)
    {
        common_key_words(key, words.range, sizeof words.range);
    }
    else if (words.range[0] == '-' && words.range[1] == '\0')
    {
        (void)snprintf(words.range, sizeof words.range, "%s", key->type == COMMON_KEY_LIST ? "list" : "text");
    }
    (void)printf("| `%s` | %s | %s | %s | ", path, key->unit, words.range, words.standard);
    print_escaped(key->text);
    (void)fputs(" |\n", stdout);
}

void sim_key_list_print_markdown(void)
{
    bool has_models = false;
    print_heading("The run");
    common_key_visit(sim_keys, print_row, &has_models);
}
