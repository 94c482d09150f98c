#include "scenario/reader.h"

#include "scenario/suggest.h"
#include "support/number.h"

#include <yaml.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEPTH_MAX 16

/// Where the walk through the document is.
typedef struct
{
    const sim_text_t *text;
    sim_sources_t    *sources;
    sim_error_t      *error;
    yaml_document_t   document;
    bool             *is_seen; ///< by node
    char              path[SIM_KEY_MAX];
    size_t            length; ///< of the path
} reader_t;

// --- messages ------------------------------------------------------------------------------------------------------

/// "FILE:LINE: what about", or without the line for an option. Always false.
static bool complain(const reader_t *reader, size_t line, const char *what, const char *about)
{
    const sim_text_t *text = reader->text;
    return text->is_option ? sim_error_set(reader->error, "%s: %s%s", text->name, what, about)
                           : sim_error_set(reader->error, "%s:%zu: %s%s", text->name, line, what, about);
}

/// The same about the value of the path.
static bool complain_value(const reader_t *reader, size_t line, const char *what)
{
    char text[2 * SIM_KEY_MAX + 256];
    (void)snprintf(text, sizeof text, "%s: %s", reader->path, what);
    return complain(reader, line, text, "");
}

static bool complain_unknown(const reader_t *reader, size_t line)
{
    const sim_text_t *text   = reader->text;
    const size_t      prefix = (text->prefix[0] != '\0') ? strlen(text->prefix) + 1 : 0;
    sim_place_t       place;
    char              suggestion[SIM_KEY_MAX];
    char              what[3 * SIM_KEY_MAX];
    if (prefix > 0 && !text->is_option && sim_key_find(NULL, reader->path + prefix, &place))
    {
        (void)snprintf(what,
                       sizeof what,
                       "%s is a scenario's key: a file with the keys of its %s alone is wanted here",
                       reader->path + prefix,
                       text->prefix);
    }
    else if (sim_suggest(reader->path, suggestion))
    {
        (void)snprintf(what, sizeof what, "unknown key %s, did you mean %s?", reader->path, suggestion);
    }
    else
    {
        (void)snprintf(what, sizeof what, "unknown key %s", reader->path);
    }
    return complain(reader, line, what, "");
}

// --- nodes ---------------------------------------------------------------------------------------------------------

static size_t line_of(const yaml_node_t *node)
{
    return node->start_mark.line + 1;
}

/// The node `id`, which nothing else may refer to: that would be an alias. Null with the error filled in.
static const yaml_node_t *take_node(reader_t *reader, int id, size_t line)
{
    const yaml_node_t *node = yaml_document_get_node(&reader->document, id);
    if (reader->is_seen[id])
    {
        (void)complain(reader, line > 0 ? line : line_of(node), "aliases are not supported", "");
        return NULL;
    }
    reader->is_seen[id] = true;
    return node;
}

/// A scalar's text; cut at a zero byte, which no value and no key may have (has_zero_byte).
static const char *scalar(const yaml_node_t *node)
{
    return (const char *)node->data.scalar.value;
}

static bool has_zero_byte(const yaml_node_t *node)
{
    return strlen(scalar(node)) != node->data.scalar.length;
}

/// Adds to the path; cut takes it off again.
static bool append(reader_t *reader, size_t line, const char *separator, const char *name)
{
    const size_t room   = sizeof reader->path - reader->length;
    const size_t length = (size_t)snprintf(reader->path + reader->length, room, "%s%s", separator, name);
    if (length >= room)
    {
        return complain(reader, line, "a key is too long", "");
    }
    reader->length += length;
    return true;
}

static void cut(reader_t *reader, size_t length)
{
    reader->length       = length;
    reader->path[length] = '\0';
}

/// Notes where the value of the path was written.
static bool note(const reader_t *reader, size_t line)
{
    const sim_text_t *text = reader->text;
    return sim_sources_add(reader->sources, reader->path, text->name, text->is_option ? 0 : line, reader->error);
}

// --- values --------------------------------------------------------------------------------------------------------

/// The index of a word among those of a choice; -1 if it is none of them.
static int find_word(const sim_key_t *key, const char *word)
{
    int index = 0;
    while (key->words[index] != NULL && strcmp(key->words[index], word) != 0)
    {
        index++;
    }
    return key->words[index] != NULL ? index : -1;
}

/// Takes a single value to where it goes; false with what is wrong with it.
static bool take_value(const sim_key_t *key, const char *text, char *at, char *what, size_t size)
{
    sim_optional_t number    = {.is_given = true};
    uint64_t       whole     = 0;
    int            word      = 0;
    const char    *complaint = NULL;
    char           words[SIM_KEY_MAX];
    switch (key->type)
    {
    case SIM_KEY_WHOLE:
        complaint = sim_number_parse_whole(text, &whole);
        memcpy(at, &whole, sizeof whole);
        break;
    case SIM_KEY_CHOICE:
        word = find_word(key, text);
        sim_key_words(key, words, sizeof words);
        (void)snprintf(what, size, "'%.40s' is not %s", text, words);
        memcpy(at, &word, sizeof word);
        return word >= 0;
    case SIM_KEY_TEXT:
        (void)snprintf(what, size, "is longer than %g bytes", key->max);
        memcpy(at, text, strlen(text) <= (size_t)key->max ? strlen(text) + 1 : 0);
        return strlen(text) <= (size_t)key->max;
    default:
        complaint = sim_number_parse(text, &number.value);
        (void)snprintf(what, size, "%.10g is outside %g to %g", number.value, key->min, key->max);
        if (complaint == NULL && !(number.value >= key->min && number.value <= key->max))
        {
            return false;
        }
        memcpy(at,
               key->type == SIM_KEY_OPTIONAL ? (const void *)&number : (const void *)&number.value,
               key->type == SIM_KEY_OPTIONAL ? sizeof number : sizeof number.value);
        break;
    }
    (void)snprintf(what, size, "'%.40s' %s", text, complaint != NULL ? complaint : "");
    return complaint == NULL;
}

static bool read_scalar(reader_t *reader, const sim_key_t *key, const yaml_node_t *node, size_t line, char *at)
{
    char what[2 * SIM_KEY_MAX] = "holds a zero byte";
    return (!has_zero_byte(node) && take_value(key, scalar(node), at, what, sizeof what)) ||
           complain_value(reader, line, what);
}

// --- mappings and lists --------------------------------------------------------------------------------------------

static bool check_kind(reader_t          *reader,
                       yaml_node_type_t   type,
                       const char        *called,
                       const yaml_node_t *node,
                       size_t             line)
{
    char        what[64];
    const char *found = (node->type == YAML_SCALAR_NODE)    ? "a single value"
                        : (node->type == YAML_MAPPING_NODE) ? "a mapping"
                                                            : "a list";
    (void)snprintf(what, sizeof what, "%s is wanted here, not %s", called, found);
    return node->type == type || complain_value(reader, line, what);
}

/// The key called `name` in a mapping, looked for before `end`; null if there is none.
static const yaml_node_t *find_in(reader_t               *reader,
                                  const yaml_node_t      *mapping,
                                  const yaml_node_pair_t *end,
                                  const char             *name)
{
    for (const yaml_node_pair_t *pair = mapping->data.mapping.pairs.start; pair < end; pair++)
    {
        const yaml_node_t *key = yaml_document_get_node(&reader->document, pair->key);
        if (key->type == YAML_SCALAR_NODE && strcmp(scalar(key), name) == 0)
        {
            return key;
        }
    }
    return NULL;
}

static bool read_mapping(reader_t *reader, const sim_key_t *keys, const yaml_node_t *node, char *group);

/// All keys of an element are required.
static bool read_element(reader_t *reader, const sim_key_t *keys, int id, char *at)
{
    const yaml_node_t *node = take_node(reader, id, 0);
    if (node == NULL || !check_kind(reader, YAML_MAPPING_NODE, "a mapping", node, line_of(node)) ||
        !read_mapping(reader, keys, node, at))
    {
        return false;
    }
    for (const sim_key_t *key = keys; key->name != NULL; key++)
    {
        if (find_in(reader, node, node->data.mapping.pairs.top, key->name) == NULL)
        {
            return append(reader, line_of(node), ".", key->name) && complain_value(reader, line_of(node), "is missing");
        }
    }
    return note(reader, line_of(node));
}

static bool read_list(reader_t *reader, const sim_key_t *key, const yaml_node_t *node, size_t line, char *group)
{
    const size_t   count    = (size_t)(node->data.sequence.items.top - node->data.sequence.items.start);
    const unsigned elements = (unsigned)count;
    const size_t   length   = reader->length;
    char           text[80];
    if (!(count >= (size_t)key->min && count <= (size_t)key->max))
    {
        (void)snprintf(text, sizeof text, "has %zu elements, %g to %g are wanted", count, key->min, key->max);
        return complain_value(reader, line, text);
    }
    for (size_t i = 0; i < count; i++)
    {
        (void)snprintf(text, sizeof text, "[%zu]", i);
        if (!append(reader, line, "", text) ||
            !read_element(reader, key->keys, node->data.sequence.items.start[i], group + key->offset + i * key->size))
        {
            return false;
        }
        cut(reader, length);
    }
    memcpy(group + key->count_offset, &elements, sizeof elements);
    return true;
}

static bool read_value(reader_t *reader, const sim_key_t *key, const yaml_node_t *node, size_t line, char *group)
{
    const char *called = sim_key_type_name(key);
    switch (key->type)
    {
    case SIM_KEY_GROUP:
        return check_kind(reader, YAML_MAPPING_NODE, called, node, line) &&
               read_mapping(reader, sim_key_below(key), node, group + key->offset);
    case SIM_KEY_LIST:
        return check_kind(reader, YAML_SEQUENCE_NODE, called, node, line) && read_list(reader, key, node, line, group);
    default:
        return check_kind(reader, YAML_SCALAR_NODE, called, node, line) &&
               read_scalar(reader, key, node, line, group + key->offset);
    }
}

/// A key's name, which the path then ends with. Null with the error filled in if it is none.
static const char *read_name(reader_t *reader, const yaml_node_t *mapping, const yaml_node_pair_t *pair)
{
    const yaml_node_t *node = take_node(reader, pair->key, 0);
    if (node == NULL)
    {
        return NULL;
    }
    const size_t line = line_of(node);
    if (node->type != YAML_SCALAR_NODE)
    {
        (void)complain(reader, line, "a key must be a word", "");
        return NULL;
    }
    // A '.' or '[' inside a key would pass for a path.
    if (has_zero_byte(node) || strpbrk(scalar(node), ".[]") != NULL)
    {
        (void)complain(reader, line, "unknown key ", scalar(node));
        return NULL;
    }
    if (!append(reader, line, reader->length > 0 ? "." : "", scalar(node)))
    {
        return NULL;
    }
    const yaml_node_t *other = find_in(reader, mapping, pair, scalar(node));
    if (other != NULL)
    {
        char what[SIM_KEY_MAX + 64];
        (void)snprintf(what, sizeof what, "%s is given twice, first in line %zu", reader->path, line_of(other));
        (void)complain(reader, line, what, "");
        return NULL;
    }
    return scalar(node);
}

static bool read_pair(reader_t               *reader,
                      const sim_key_t        *keys,
                      const yaml_node_t      *mapping,
                      const yaml_node_pair_t *pair,
                      char                   *group)
{
    const char *name = read_name(reader, mapping, pair);
    if (name == NULL)
    {
        return false;
    }
    const size_t       line = line_of(yaml_document_get_node(&reader->document, pair->key));
    const sim_key_t   *key  = sim_key_in(keys, name, strlen(name));
    const sim_key_t   *only = (keys == reader->text->keys) ? reader->text->only : NULL;
    const yaml_node_t *node = take_node(reader, pair->value, line);
    if (only != NULL && key != only)
    {
        return complain(reader, line, "unknown key ", reader->path);
    }
    return (key != NULL || complain_unknown(reader, line)) && node != NULL &&
           read_value(reader, key, node, line, group) && note(reader, line);
}

static bool read_mapping(reader_t *reader, const sim_key_t *keys, const yaml_node_t *node, char *group)
{
    const size_t                  length = reader->length;
    const yaml_node_pair_t *const end    = node->data.mapping.pairs.top;
    for (const yaml_node_pair_t *pair = node->data.mapping.pairs.start; pair < end; pair++)
    {
        if (!read_pair(reader, keys, node, pair, group))
        {
            return false;
        }
        cut(reader, length);
    }
    return true;
}

// --- the document --------------------------------------------------------------------------------------------------

static bool complain_yaml(const reader_t *reader, const yaml_parser_t *parser)
{
    size_t line = parser->problem_mark.line + 1;
    if (parser->error == YAML_COMPOSER_ERROR) // it finds fault with nothing else
    {
        return complain(reader, line, "aliases are not supported", "");
    }
    if (parser->error == YAML_READER_ERROR) // has an offset alone
    {
        line = 1;
        for (size_t i = 0; i < parser->problem_offset && reader->text->text[i] != '\0'; i++)
        {
            line += (reader->text->text[i] == '\n') ? 1u : 0u;
        }
    }
    return complain(reader, line, "not valid YAML: ", parser->problem != NULL ? parser->problem : "unreadable");
}

/// Nothing may come after the document.
static bool check_end(const reader_t *reader, yaml_parser_t *parser)
{
    yaml_document_t second;
    if (!yaml_parser_load(parser, &second))
    {
        return complain_yaml(reader, parser);
    }
    const bool   is_end = yaml_document_get_root_node(&second) == NULL;
    const size_t line   = second.start_mark.line + 1;
    yaml_document_delete(&second);
    return is_end || complain(reader, line, "a second document in one file", "");
}

/// libyaml takes a time that grows with the square of the depth: minutes for a file of brackets. So this looks first, and
/// leaves any other fault for later.
static bool check_depth(const reader_t *reader)
{
    yaml_parser_t parser;
    yaml_event_t  event;
    size_t        line  = 0;
    int           depth = 0;
    bool          more  = yaml_parser_initialize(&parser) == 1;
    yaml_parser_set_input_string(&parser, (const unsigned char *)reader->text->text, strlen(reader->text->text));
    while (more && depth <= DEPTH_MAX && yaml_parser_parse(&parser, &event))
    {
        depth += (event.type == YAML_SEQUENCE_START_EVENT || event.type == YAML_MAPPING_START_EVENT) ? 1 : 0;
        depth -= (event.type == YAML_SEQUENCE_END_EVENT || event.type == YAML_MAPPING_END_EVENT) ? 1 : 0;
        more = event.type != YAML_STREAM_END_EVENT;
        line = event.start_mark.line + 1;
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    return depth <= DEPTH_MAX || complain(reader, line, "nested too deeply", "");
}

static bool check_size(const reader_t *reader)
{
    size_t entries = 0;
    for (const yaml_node_t *node = reader->document.nodes.start; node < reader->document.nodes.top; node++)
    {
        entries += (node->type == YAML_MAPPING_NODE)
                       ? (size_t)(node->data.mapping.pairs.top - node->data.mapping.pairs.start)
                   : (node->type == YAML_SEQUENCE_NODE)
                       ? (size_t)(node->data.sequence.items.top - node->data.sequence.items.start)
                       : 0;
    }
    return entries <= SIM_FILE_ENTRIES_MAX || sim_error_set(reader->error,
                                                            "%s: has %zu entries, %u at most are allowed",
                                                            reader->text->name,
                                                            entries,
                                                            SIM_FILE_ENTRIES_MAX);
}

static bool read_document(reader_t *reader)
{
    const size_t nodes = (size_t)(reader->document.nodes.top - reader->document.nodes.start);
    if (nodes == 0)
    {
        return complain(reader, 1, "the file is empty", "");
    }
    reader->is_seen = calloc(nodes + 1, sizeof *reader->is_seen); // nodes count from 1
    if (reader->is_seen == NULL)
    {
        return sim_error_set(reader->error, "out of memory");
    }
    const yaml_node_t *root = take_node(reader, 1, 0);
    const bool         ok =
        (root->type == YAML_MAPPING_NODE || complain(reader, line_of(root), "a mapping is wanted here", "")) &&
        check_size(reader) && append(reader, 1, "", reader->text->prefix) &&
        read_mapping(reader, reader->text->keys, root, reader->text->group);
    free(reader->is_seen);
    return ok;
}

bool sim_read(const sim_text_t *text, sim_sources_t *sources, sim_error_t *error)
{
    reader_t      reader = {.text = text, .sources = sources, .error = error};
    yaml_parser_t parser;
    if (!check_depth(&reader))
    {
        return false;
    }
    if (!yaml_parser_initialize(&parser))
    {
        return sim_error_set(error, "out of memory");
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text->text, strlen(text->text));
    bool ok = yaml_parser_load(&parser, &reader.document);
    if (!ok)
    {
        (void)complain_yaml(&reader, &parser);
    }
    else
    {
        ok = check_end(&reader, &parser) && read_document(&reader);
        yaml_document_delete(&reader.document);
    }
    yaml_parser_delete(&parser);
    return ok;
}
