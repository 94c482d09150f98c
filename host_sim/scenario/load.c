// libcyaml loads the text into a fresh struct; what the text gives is then moved over the values that are there. What
// libcyaml lets pass ("3 4" as 3, -1 as 2^64 - 1) or reports without its place is checked before, on the index.

#include "scenario/load.h"

#include "scenario/suggest.h"
#include "scenario/yaml_index.h"
#include "support/number.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct
{
    const sim_load_text_t   *from;
    const sim_load_target_t *target;
    sim_yaml_index_t         index;
    sim_error_t             *error;
} loader_t;

/// "FILE:LINE", or the option.
static void describe_place(const sim_load_text_t *from, size_t line, char *place, size_t size)
{
    if (from->is_option)
    {
        (void)snprintf(place, size, "%s", from->name);
    }
    else
    {
        (void)snprintf(place, size, "%s:%zu", from->name, line);
    }
}

static bool complain(const loader_t *loader, const sim_yaml_entry_t *entry, const char *what)
{
    char place[512];
    describe_place(loader->from, entry->line, place, sizeof place);
    return sim_error_set(loader->error, "%s: %s%s: %s", place, loader->target->prefix, entry->path, what);
}

static bool complain_unknown(const loader_t *loader, const sim_yaml_entry_t *entry)
{
    char place[512];
    describe_place(loader->from, entry->line, place, sizeof place);
    const char *prefix = loader->target->prefix;
    char        suggestion[SIM_KEY_MAX];
    sim_place_t found;
    if (prefix[0] != '\0' && !loader->from->is_option && sim_schema_find(&sim_scenario_schema, entry->path, &found))
    {
        return sim_error_set(loader->error,
                             "%s: %s is a scenario's key: a file with the keys of its %.*s alone is wanted here",
                             place,
                             entry->path,
                             (int)strlen(prefix) - 1,
                             prefix);
    }
    if (sim_suggest(loader->target->schema, entry->path, suggestion, sizeof suggestion))
    {
        return sim_error_set(loader->error,
                             "%s: unknown key %s%s, did you mean %s%s?",
                             place,
                             prefix,
                             entry->path,
                             prefix,
                             suggestion);
    }
    return sim_error_set(loader->error, "%s: unknown key %s%s", place, prefix, entry->path);
}

static bool is_choice(const cyaml_schema_value_t *value, const char *text)
{
    for (uint32_t i = 0; i < value->enumeration.count; i++)
    {
        if (strcmp(text, value->enumeration.strings[i].str) == 0)
        {
            return true;
        }
    }
    return false;
}

static bool check_scalar(const loader_t *loader, const sim_yaml_entry_t *entry, const cyaml_schema_value_t *value)
{
    double      number;
    uint64_t    whole;
    const char *complaint = NULL;
    char        choices[128];
    char        text[256];
    switch (value->type)
    {
    case CYAML_FLOAT:
        complaint = sim_number_parse(entry->text, &number);
        break;
    case CYAML_UINT:
        complaint = sim_number_parse_whole(entry->text, &whole);
        break;
    case CYAML_ENUM:
        sim_schema_choices(value, choices, sizeof choices);
        complaint = is_choice(value, entry->text) ? NULL : choices;
        break;
    default:
        break;
    }
    if (complaint == NULL)
    {
        return true;
    }
    (void)snprintf(text, sizeof text, "'%.40s' %s%s", entry->text, complaint == choices ? "is not " : "", complaint);
    return complain(loader, entry, text);
}

static sim_yaml_kind_t kind_of(const cyaml_schema_value_t *value)
{
    return value->type == CYAML_MAPPING    ? SIM_YAML_MAPPING
           : value->type == CYAML_SEQUENCE ? SIM_YAML_LIST
                                           : SIM_YAML_SCALAR;
}

static bool check_entry(const loader_t *loader, const sim_yaml_entry_t *entry)
{
    sim_place_t place;
    if (!sim_schema_find(loader->target->schema, entry->path, &place))
    {
        return complain_unknown(loader, entry);
    }
    const cyaml_schema_value_t *value = &place.field->value;
    if (place.is_element)
    {
        value = value->sequence.entry;
    }
    if (entry->kind != kind_of(value))
    {
        static const char *const found[] = {"a single value", "a mapping", "a list"};

        char text[128];
        (void)snprintf(text, sizeof text, "%s is wanted here, not %s", sim_schema_type_name(value), found[entry->kind]);
        return complain(loader, entry, text);
    }
    return entry->kind != SIM_YAML_SCALAR || check_scalar(loader, entry, value);
}

/// libcyaml's first message, and the first line number that follows it.
typedef struct
{
    char   message[256];
    size_t line;
} cyaml_report_t;

static void take_log(cyaml_log_t level, void *context, const char *format, va_list args)
{
    (void)level;
    cyaml_report_t *report = context;
    char            text[256];
    (void)vsnprintf(text, sizeof text, format, args);
    text[strcspn(text, "\n")] = '\0';
    if (report->message[0] == '\0')
    {
        const char *start = (strncmp(text, "Load: ", 6) == 0) ? text + 6 : text;
        (void)snprintf(report->message, sizeof report->message, "%s", start);
    }
    const char *line = strstr(text, "(line: ");
    if (report->line == 0 && line != NULL)
    {
        report->line = strtoul(line + strlen("(line: "), NULL, 10);
    }
}

static const cyaml_config_t plain_cyaml = {.mem_fn    = cyaml_mem,
                                           .log_level = CYAML_LOG_ERROR,
                                           .flags     = CYAML_CFG_NO_ALIAS};

/// The list whose length or element libcyaml did not like: the last one that begins at or before its line.
static bool complain_cyaml(const loader_t *loader, const cyaml_report_t *report)
{
    const sim_yaml_entry_t *nearest = NULL;
    for (size_t i = 0; i < loader->index.count; i++)
    {
        const sim_yaml_entry_t *entry = &loader->index.entry[i];
        if (entry->kind != SIM_YAML_MAPPING && entry->line <= report->line)
        {
            nearest = (entry->kind == SIM_YAML_LIST || nearest == NULL) ? entry : nearest;
        }
    }
    char place[512];
    describe_place(loader->from, report->line, place, sizeof place);
    return sim_error_set(loader->error,
                         "%s: %s%s: %s",
                         place,
                         nearest != NULL ? loader->target->prefix : "",
                         nearest != NULL ? nearest->path : "scenario",
                         report->message);
}

static bool load_data(const loader_t *loader, cyaml_data_t **data)
{
    cyaml_report_t report = {.line = 0};
    cyaml_config_t cyaml  = plain_cyaml;
    cyaml.log_fn          = take_log;
    cyaml.log_ctx         = &report;
    const cyaml_err_t err = cyaml_load_data((const uint8_t *)loader->from->text,
                                            strlen(loader->from->text),
                                            &cyaml,
                                            loader->target->schema,
                                            data,
                                            NULL);
    if (err == CYAML_OK)
    {
        return true;
    }
    if (report.message[0] == '\0')
    {
        (void)snprintf(report.message, sizeof report.message, "%s", cyaml_strerror(err));
    }
    return complain_cyaml(loader, &report);
}

/// Moves one value; what is allocated changes its owner.
static void move_value(const cyaml_schema_field_t *field, char *to, char *from)
{
    if ((field->value.flags & CYAML_FLAG_POINTER) == 0)
    {
        memcpy(to + field->data_offset, from + field->data_offset, field->value.data_size);
        return;
    }
    void *old, *fresh;
    void *none = NULL;
    memcpy((void *)&old, to + field->data_offset, sizeof old);
    memcpy((void *)&fresh, from + field->data_offset, sizeof fresh);
    memcpy(to + field->data_offset, (const void *)&fresh, sizeof fresh);
    memcpy(from + field->data_offset, (const void *)&none, sizeof none);
    free(old); // nothing of ours points further than this
    if (field->value.type == CYAML_SEQUENCE)
    {
        memcpy(to + field->count_offset, from + field->count_offset, field->count_size);
        memset(from + field->count_offset, 0, field->count_size);
    }
}

/// Moves what the index has of the mapping at `path` from one struct to another.
static void move_given(const loader_t             *loader,
                       const cyaml_schema_field_t *field,
                       const char                 *path,
                       char                       *to,
                       char                       *from)
{
    for (; field->key != NULL; field++)
    {
        char key[SIM_KEY_MAX];
        (void)snprintf(key, sizeof key, "%s%s%s", path, path[0] != '\0' ? "." : "", field->key);
        if (sim_yaml_index_find(&loader->index, key) == NULL)
        {
            continue;
        }
        if (field->value.type == CYAML_MAPPING)
        {
            move_given(loader, field->value.mapping.fields, key, to + field->data_offset, from + field->data_offset);
        }
        else
        {
            move_value(field, to, from);
        }
    }
}

static bool note_sources(const loader_t *loader, sim_sources_t *sources)
{
    bool ok = true;
    for (size_t i = 0; ok && i < loader->index.count; i++)
    {
        const sim_yaml_entry_t *entry = &loader->index.entry[i];

        char place[512];
        char key[SIM_KEY_MAX + SIM_KEY_MAX];
        describe_place(loader->from, entry->line, place, sizeof place);
        (void)snprintf(key, sizeof key, "%s%s", loader->target->prefix, entry->path);
        ok = sim_sources_add(sources, key, place, loader->error);
    }
    return ok;
}

static bool load_indexed(const loader_t *loader, sim_sources_t *sources)
{
    for (size_t i = 0; i < loader->index.count; i++)
    {
        if (!check_entry(loader, &loader->index.entry[i]))
        {
            return false;
        }
    }
    cyaml_data_t *data = NULL;
    if (!load_data(loader, &data))
    {
        return false;
    }
    if (data != NULL)
    {
        move_given(loader, loader->target->schema->mapping.fields, "", loader->target->data, data);
        (void)cyaml_free(&plain_cyaml, loader->target->schema, data, 0);
    }
    return note_sources(loader, sources);
}

bool sim_load_text(const sim_load_text_t   *from,
                   const sim_load_target_t *target,
                   sim_sources_t           *sources,
                   sim_error_t             *error)
{
    loader_t loader = {.from = from, .target = target, .error = error};
    if (!sim_yaml_index_build(&loader.index, from->text, from->name, from->is_option, error))
    {
        return false;
    }
    const bool ok = load_indexed(&loader, sources);
    sim_yaml_index_free(&loader.index);
    return ok;
}

void sim_load_free(sim_config_t *config)
{
    (void)cyaml_free(&plain_cyaml, &sim_scenario_schema, config, 0);
}
