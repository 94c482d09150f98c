#include "loop/effective.h"

#include "keys/table.h"
#include "support/c_locale.h"

#include <yaml.h>

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

typedef struct
{
    yaml_emitter_t           emitter;
    const common_scenario_t *scenario;
    char                    *reference; ///< absolute path
    char                     path[COMMON_KEY_MAX];
    bool                     ok;
} writer_t;

static void emit(writer_t *writer, int made, yaml_event_t *event)
{
    writer->ok = writer->ok && made != 0 && yaml_emitter_emit(&writer->emitter, event) != 0;
}

static void emit_text(writer_t *writer, const char *text, yaml_scalar_style_t style)
{
    yaml_event_t event;
    const int    made =
        yaml_scalar_event_initialize(&event, NULL, NULL, (const yaml_char_t *)text, (int)strlen(text), 1, 1, style);
    emit(writer, made, &event);
}

static void emit_value(writer_t *writer, const common_key_t *key, const char *at)
{
    char     text[32];
    double   number;
    uint64_t whole;
    int      word;
    switch (key->type)
    {
    case COMMON_KEY_WHOLE:
        memcpy(&whole, at, sizeof whole);
        (void)snprintf(text, sizeof text, "%" PRIu64, whole);
        emit_text(writer, text, YAML_PLAIN_SCALAR_STYLE);
        break;
    case COMMON_KEY_CHOICE:
        memcpy(&word, at, sizeof word);
        emit_text(writer, key->words[word], YAML_PLAIN_SCALAR_STYLE);
        break;
    case COMMON_KEY_TEXT:
        emit_text(writer,
                  writer->reference != NULL && strcmp(writer->path, "reference.file") == 0 ? writer->reference : at,
                  YAML_DOUBLE_QUOTED_SCALAR_STYLE);
        break;
    default:
        at += key->type == COMMON_KEY_OPTIONAL ? offsetof(common_optional_t, value) : 0u;
        memcpy(&number, at, sizeof number);
        (void)snprintf(text, sizeof text, "%.15g", number);
        if (strtod(text, NULL) != number)
        {
            (void)snprintf(text, sizeof text, "%.17g", number);
        }
        emit_text(writer, text, YAML_PLAIN_SCALAR_STYLE);
        break;
    }
}

static void emit_mapping(writer_t *writer, const common_key_t *keys, const char *group, size_t length);

static void emit_list(writer_t *writer, const common_key_t *key, const char *group, size_t length)
{
    yaml_event_t event;
    unsigned     count;
    memcpy(&count, group + key->count_offset, sizeof count);
    emit(writer, yaml_sequence_start_event_initialize(&event, NULL, NULL, 1, YAML_BLOCK_SEQUENCE_STYLE), &event);
    for (unsigned i = 0; i < count; i++)
    {
        const int end = snprintf(writer->path + length, COMMON_KEY_MAX - length, "[%u]", i);
        emit_mapping(writer, key->keys, group + key->offset + i * key->size, length + (size_t)end);
    }
    emit(writer, yaml_sequence_end_event_initialize(&event), &event);
}

static void emit_key(writer_t *writer, const common_key_t *key, const char *group, size_t length)
{
    emit_text(writer, key->name, YAML_PLAIN_SCALAR_STYLE);
    switch (key->type)
    {
    case COMMON_KEY_GROUP:
        emit_mapping(writer, common_key_below(key), group + key->offset, length);
        break;
    case COMMON_KEY_LIST:
        emit_list(writer, key, group, length);
        break;
    default:
        emit_value(writer, key, group + key->offset);
        break;
    }
}

/// Writes the keys that were given in the mapping at the path, which is `length` characters long.
static void emit_mapping(writer_t *writer, const common_key_t *keys, const char *group, size_t length)
{
    yaml_event_t event;
    emit(writer, yaml_mapping_start_event_initialize(&event, NULL, NULL, 1, YAML_BLOCK_MAPPING_STYLE), &event);
    for (const common_key_t *key = keys; key != NULL && key->name != NULL; key++)
    {
        const char  *dot   = length > 0 ? "." : "";
        const size_t added = (size_t)snprintf(writer->path + length, COMMON_KEY_MAX - length, "%s%s", dot, key->name);
        if (key->type != COMMON_KEY_SKIPPED && common_scenario_has_part(writer->scenario, writer->path))
        {
            emit_key(writer, key, group, length + added);
        }
        writer->path[length] = '\0';
    }
    emit(writer, yaml_mapping_end_event_initialize(&event), &event);
}

bool common_scenario_write(FILE *stream, const common_scenario_t *scenario, common_error_t *error)
{
    char        *relative = common_scenario_reference_path(scenario);
    writer_t     writer   = {.scenario = scenario, .reference = NULL, .ok = true};
    yaml_event_t event;

    writer.reference = relative != NULL ? realpath(relative, NULL) : NULL;
    if (yaml_emitter_initialize(&writer.emitter) == 0)
    {
        free(writer.reference);
        free(relative);
        return common_error_set(error, "out of memory");
    }
    yaml_emitter_set_output_file(&writer.emitter, stream);
    yaml_emitter_set_width(&writer.emitter, -1);
    emit(&writer, yaml_stream_start_event_initialize(&event, YAML_UTF8_ENCODING), &event);
    emit(&writer, yaml_document_start_event_initialize(&event, NULL, NULL, NULL, 1), &event);
    const common_c_locale_t scope = common_c_locale_begin();
    emit_mapping(&writer, common_scenario_keys(scenario), common_scenario_values(scenario), 0);
    common_c_locale_end(scope);
    emit(&writer, yaml_document_end_event_initialize(&event, 1), &event);
    emit(&writer, yaml_stream_end_event_initialize(&event), &event);
    yaml_emitter_delete(&writer.emitter);
    free(writer.reference);
    free(relative);
    return writer.ok || ferror(stream) || common_error_set(error, "out of memory");
}
