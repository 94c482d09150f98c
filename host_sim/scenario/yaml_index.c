#include "scenario/yaml_index.h"

#include "scenario/schema.h"

#include <yaml.h>

#include <stdlib.h>
#include <string.h>

#define DEPTH_MAX 16

typedef struct
{
    sim_yaml_kind_t kind;
    size_t          path_length; ///< of the path without what this level adds
    size_t          next_index;  ///< of a list
} level_t;

/// The document read so far.
typedef struct
{
    sim_yaml_index_t *index;
    const char       *name;
    bool              name_only;
    sim_error_t      *error;
    yaml_parser_t     parser;

    level_t level[DEPTH_MAX];
    size_t  depth;
    char    path[SIM_KEY_MAX];
    size_t  path_length;
    bool    has_key; ///< in a mapping: the key is read, its value comes next
    size_t  key_line;
    size_t  documents;
} builder_t;

static bool complain(const builder_t *builder, size_t line, const char *what, const char *about)
{
    if (builder->name_only)
    {
        return sim_error_set(builder->error, "%s: %s%s", builder->name, what, about);
    }
    return sim_error_set(builder->error, "%s:%zu: %s%s", builder->name, line, what, about);
}

static bool append_to_path(builder_t *builder, size_t line, const char *text)
{
    const size_t length = strlen(text);
    if (builder->path_length + length >= sizeof builder->path)
    {
        return complain(builder, line, "a key is too long", "");
    }
    memcpy(builder->path + builder->path_length, text, length + 1);
    builder->path_length += length;
    return true;
}

static void cut_path(builder_t *builder, size_t length)
{
    builder->path_length  = length;
    builder->path[length] = '\0';
}

static bool add_entry(builder_t *builder, sim_yaml_kind_t kind, const yaml_event_t *event)
{
    const size_t            line  = builder->has_key ? builder->key_line : event->start_mark.line + 1;
    const sim_yaml_entry_t *other = sim_yaml_index_find(builder->index, builder->path);
    if (other != NULL)
    {
        char text[SIM_KEY_MAX + 64];
        (void)snprintf(text, sizeof text, "%s is given twice, first in line %zu", builder->path, other->line);
        return complain(builder, line, text, "");
    }
    sim_yaml_index_t *index  = builder->index;
    sim_yaml_entry_t *larger = realloc(index->entry, (index->count + 1) * sizeof *larger);
    if (larger == NULL)
    {
        return sim_error_set(builder->error, "out of memory");
    }
    index->entry            = larger;
    sim_yaml_entry_t *entry = &index->entry[index->count++];
    *entry                  = (sim_yaml_entry_t){.path       = strdup(builder->path),
                                                 .kind       = kind,
                                                 .line       = line,
                                                 .column     = event->start_mark.column + 1,
                                                 .value_line = event->start_mark.line + 1};
    if (kind == SIM_YAML_SCALAR)
    {
        entry->text = strdup((const char *)event->data.scalar.value);
    }
    if (entry->path == NULL || (kind == SIM_YAML_SCALAR && entry->text == NULL))
    {
        return sim_error_set(builder->error, "out of memory");
    }
    return true;
}

static bool take_key(builder_t *builder, const yaml_event_t *event)
{
    const size_t line = event->start_mark.line + 1;
    const char  *key  = (const char *)event->data.scalar.value;
    // A '.' or '[' inside a key would pass for a path.
    if (strlen(key) != event->data.scalar.length || strpbrk(key, ".[]") != NULL)
    {
        return complain(builder, line, "unknown key ", key);
    }
    builder->key_line = line;
    builder->has_key  = true;
    return (builder->path_length == 0 || append_to_path(builder, line, ".")) && append_to_path(builder, line, key);
}

/// The value that starts at `event`: puts its place in the path and adds it.
static bool begin_value(builder_t *builder, sim_yaml_kind_t kind, const yaml_event_t *event)
{
    const size_t line = event->start_mark.line + 1;
    if (builder->depth == 0)
    {
        return kind == SIM_YAML_MAPPING || complain(builder, line, "a mapping is wanted here", "");
    }
    level_t *level = &builder->level[builder->depth - 1];
    if (level->kind == SIM_YAML_LIST)
    {
        char text[32];
        (void)snprintf(text, sizeof text, "[%zu]", level->next_index++);
        if (!append_to_path(builder, line, text))
        {
            return false;
        }
    }
    else if (!builder->has_key)
    {
        return complain(builder, line, "a key must be a word", "");
    }
    const bool ok    = add_entry(builder, kind, event);
    builder->has_key = false;
    return ok;
}

static bool take_scalar(builder_t *builder, const yaml_event_t *event)
{
    const bool in_mapping = builder->depth > 0 && builder->level[builder->depth - 1].kind == SIM_YAML_MAPPING;
    if (in_mapping && !builder->has_key)
    {
        return take_key(builder, event);
    }
    if (!begin_value(builder, SIM_YAML_SCALAR, event))
    {
        return false;
    }
    cut_path(builder, builder->level[builder->depth - 1].path_length);
    return true;
}

static bool open_level(builder_t *builder, sim_yaml_kind_t kind, const yaml_event_t *event)
{
    if (!begin_value(builder, kind, event))
    {
        return false;
    }
    if (builder->depth == DEPTH_MAX)
    {
        return complain(builder, event->start_mark.line + 1, "nested too deeply", "");
    }
    builder->level[builder->depth++] = (level_t){.kind = kind, .path_length = builder->path_length};
    return true;
}

static void close_level(builder_t *builder)
{
    builder->depth--;
    cut_path(builder, builder->depth > 0 ? builder->level[builder->depth - 1].path_length : 0);
}

static bool take_event(builder_t *builder, const yaml_event_t *event)
{
    const size_t line = event->start_mark.line + 1;
    switch (event->type)
    {
    case YAML_DOCUMENT_START_EVENT:
        return builder->documents++ == 0 || complain(builder, line, "a second document in one file", "");
    case YAML_ALIAS_EVENT:
        return complain(builder, line, "aliases are not supported", "");
    case YAML_SCALAR_EVENT:
        return take_scalar(builder, event);
    case YAML_MAPPING_START_EVENT:
        return open_level(builder, SIM_YAML_MAPPING, event);
    case YAML_SEQUENCE_START_EVENT:
        return open_level(builder, SIM_YAML_LIST, event);
    case YAML_MAPPING_END_EVENT:
    case YAML_SEQUENCE_END_EVENT:
        close_level(builder);
        return true;
    default:
        return true;
    }
}

static bool parse(builder_t *builder)
{
    yaml_event_type_t type = YAML_NO_EVENT;
    while (type != YAML_STREAM_END_EVENT)
    {
        yaml_event_t event;
        if (!yaml_parser_parse(&builder->parser, &event))
        {
            const char *problem = builder->parser.problem != NULL ? builder->parser.problem : "unreadable";
            return complain(builder, builder->parser.problem_mark.line + 1, "not valid YAML: ", problem);
        }
        type          = event.type;
        const bool ok = take_event(builder, &event);
        yaml_event_delete(&event);
        if (!ok)
        {
            return false;
        }
    }
    return builder->documents > 0 || complain(builder, 1, "the file is empty", "");
}

bool sim_yaml_index_build(sim_yaml_index_t *index,
                          const char       *text,
                          const char       *name,
                          bool              name_only,
                          sim_error_t      *error)
{
    *index            = (sim_yaml_index_t){0};
    builder_t builder = {.index = index, .name = name, .name_only = name_only, .error = error};
    if (!yaml_parser_initialize(&builder.parser))
    {
        return sim_error_set(error, "out of memory");
    }
    yaml_parser_set_input_string(&builder.parser, (const unsigned char *)text, strlen(text));
    const bool ok = parse(&builder);
    yaml_parser_delete(&builder.parser);
    if (!ok)
    {
        sim_yaml_index_free(index);
    }
    return ok;
}

void sim_yaml_index_free(sim_yaml_index_t *index)
{
    for (size_t i = 0; i < index->count; i++)
    {
        free(index->entry[i].path);
        free(index->entry[i].text);
    }
    free(index->entry);
    *index = (sim_yaml_index_t){0};
}

const sim_yaml_entry_t *sim_yaml_index_find(const sim_yaml_index_t *index, const char *path)
{
    for (size_t i = 0; i < index->count; i++)
    {
        if (strcmp(index->entry[i].path, path) == 0)
        {
            return &index->entry[i];
        }
    }
    return NULL;
}
