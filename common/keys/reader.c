#include "keys/reader.h"

#include "keys/document.h"
#include "keys/suggest.h"
#include "support/c_locale.h"
#include "support/number.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/// State of the reader, with its position in the document.
typedef struct
{
    const common_text_t *text;
    common_sources_t    *sources;
    common_error_t      *error;
    yaml_document_t      document;
    size_t               line; ///< line of the key, or of the element of a list
    char                 path[COMMON_KEY_MAX];
    size_t               length; ///< length of the path
} reader_t;

// --- messages ------------------------------------------------------------------------------------------------------

/// Reports an error: "FILE:LINE: " and the text, or "--set key=value: " and the text for an option. Always returns false.
static bool complain(const reader_t *reader, const char *format, ...)
{
    const common_text_t *text = reader->text;
    common_error_t       what = {""};
    va_list              args;
    va_start(args, format);
    (void)common_error_set_list(&what, format, args);
    va_end(args);
    return text->is_option ? common_error_set(reader->error, "%s: %s", text->name, what.text)
                           : common_error_set(reader->error, "%s:%zu: %s", text->name, reader->line, what.text);
}

static bool complain_unknown(const reader_t *reader)
{
    const common_text_t *text   = reader->text;
    const size_t         prefix = (text->prefix[0] != '\0') ? strlen(text->prefix) + 1 : 0;
    common_place_t       place;
    char                 suggestion[COMMON_KEY_MAX];
    if (prefix > 0 && !text->is_option && common_key_find(text->root, NULL, reader->path + prefix, &place))
    {
        return complain(reader,
                        "%s is a key of a whole scenario: a file with only the keys of its %s is expected here",
                        reader->path + prefix,
                        text->prefix);
    }
    return common_suggest(text->root, reader->path, suggestion)
               ? complain(reader, "unknown key %s, did you mean %s?", reader->path, suggestion)
               : complain(reader, "unknown key %s", reader->path);
}

// --- nodes and the path to them ------------------------------------------------------------------------------------

static const yaml_node_t *node_of(reader_t *reader, int id)
{
    return yaml_document_get_node(&reader->document, id);
}

/// Returns a scalar's text, cut at a zero byte, which is invalid in values and keys.
static const char *scalar(const yaml_node_t *node)
{
    return (const char *)node->data.scalar.value;
}

static bool has_zero_byte(const yaml_node_t *node)
{
    return strlen(scalar(node)) != node->data.scalar.length;
}

/// Appends to the path.
static bool append(reader_t *reader, const char *format, ...)
{
    const size_t room = sizeof reader->path - reader->length;
    va_list      args;
    va_start(args, format);
    const size_t length = (size_t)vsnprintf(reader->path + reader->length, room, format, args);
    va_end(args);
    reader->length += length;
    return length < room || complain(reader, "a key is too long");
}

static void cut(reader_t *reader, size_t length)
{
    reader->length       = length;
    reader->path[length] = '\0';
}

/// Records the source line of the path's value.
static bool note(const reader_t *reader, size_t line)
{
    const common_text_t *text = reader->text;
    return common_sources_add(reader->sources, reader->path, text->name, text->is_option ? 0 : line, reader->error);
}

// --- values --------------------------------------------------------------------------------------------------------

/// Stores a single value at `at`. Returns false with the fault in `what`.
static bool take_value(const common_key_t *key, const char *text, char *at, char *what, size_t size)
{
    common_optional_t number    = {.is_given = true};
    uint64_t          whole     = 0;
    int               word      = 0;
    const char       *complaint = NULL;
    char              words[COMMON_WORDS_MAX];
    const char       *meant = NULL;
    switch (key->type)
    {
    case COMMON_KEY_WHOLE:
        complaint = common_number_parse_whole(text, &whole);
        (void)snprintf(what, size, "%.40s is outside %g to %g", text, key->min, key->max);
        if (complaint == NULL && !((double)whole >= key->min && (double)whole <= key->max))
        {
            return false;
        }
        memcpy(at, &whole, sizeof whole);
        break;
    case COMMON_KEY_CHOICE:
        word  = common_key_find_word(key, text);
        meant = common_suggest_word(key, text);
        common_key_words(key, words, sizeof words);
        (void)snprintf(what,
                       size,
                       "'%.40s' is not %s%s%s%s",
                       text,
                       words,
                       meant != NULL ? ", did you mean " : "",
                       meant != NULL ? meant : "",
                       meant != NULL ? "?" : "");
        memcpy(at, &word, sizeof word);
        return word >= 0;
    case COMMON_KEY_TEXT:
        (void)snprintf(what, size, "is longer than %g bytes", key->max);
        memcpy(at, text, strlen(text) <= (size_t)key->max ? strlen(text) + 1 : 0);
        return strlen(text) <= (size_t)key->max;
    default:
        complaint = common_number_parse(text, &number.value);
        (void)snprintf(what, size, "%.10g is outside %g to %g", number.value, key->min, key->max);
        if (complaint == NULL && !(number.value >= key->min && number.value <= key->max))
        {
            return false;
        }
        memcpy(at,
               key->type == COMMON_KEY_OPTIONAL ? (const void *)&number : (const void *)&number.value,
               key->type == COMMON_KEY_OPTIONAL ? sizeof number : sizeof number.value);
        break;
    }
    (void)snprintf(what, size, "'%.40s' %s", text, complaint != NULL ? complaint : "");
    return complaint == NULL;
}

static bool read_scalar(const reader_t *reader, const common_key_t *key, const yaml_node_t *node, char *at)
{
    char what[2 * COMMON_WORDS_MAX] = "holds a zero byte";
    return (!has_zero_byte(node) && take_value(key, scalar(node), at, what, sizeof what)) ||
           complain(reader, "%s: %s", reader->path, what);
}

// --- mappings and lists --------------------------------------------------------------------------------------------

static bool check_kind(const reader_t *reader, yaml_node_type_t type, const char *called, const yaml_node_t *node)
{
    static const char *const found[] =
        {[YAML_SCALAR_NODE] = "a single value", [YAML_MAPPING_NODE] = "a mapping", [YAML_SEQUENCE_NODE] = "a list"};
    return node->type == type ||
           complain(reader, "%s: %s is expected here, not %s", reader->path, called, found[node->type]);
}

/// Returns the key called `name` in a mapping, before `end`; null if there is none.
static const yaml_node_t *find_in(reader_t               *reader,
                                  const yaml_node_t      *mapping,
                                  const yaml_node_pair_t *end,
                                  const char             *name)
{
    for (const yaml_node_pair_t *pair = mapping->data.mapping.pairs.start; pair < end; pair++)
    {
        const yaml_node_t *key = node_of(reader, pair->key);
        if (strcmp(scalar(key), name) == 0)
        {
            return key;
        }
    }
    return NULL;
}

static bool read_mapping(reader_t *reader, const common_key_t *keys, const yaml_node_t *mapping, char *group);

/// Reads an element of a list. All its keys are required.
static bool read_element(reader_t *reader, const common_key_t *keys, const yaml_node_t *node, char *at)
{
    const size_t line = node->start_mark.line + 1;
    reader->line      = line;
    if (!check_kind(reader, YAML_MAPPING_NODE, "a mapping", node) || !read_mapping(reader, keys, node, at))
    {
        return false;
    }
    reader->line = line;
    for (const common_key_t *key = keys; key->name != NULL; key++)
    {
        if (find_in(reader, node, node->data.mapping.pairs.top, key->name) == NULL)
        {
            return complain(reader, "%s.%s: is missing", reader->path, key->name);
        }
    }
    return note(reader, line);
}

static bool read_list(reader_t *reader, const common_key_t *key, const yaml_node_t *node, char *group)
{
    const yaml_node_item_t *items  = node->data.sequence.items.start;
    const unsigned          count  = (unsigned)(node->data.sequence.items.top - items);
    const size_t            length = reader->length;
    if (!(count >= key->min && count <= key->max))
    {
        return complain(reader, "%s: has %u elements, %g to %g are expected", reader->path, count, key->min, key->max);
    }
    for (unsigned i = 0; i < count; i++)
    {
        if (!append(reader, "[%u]", i) ||
            !read_element(reader, key->keys, node_of(reader, items[i]), group + key->offset + i * key->size))
        {
            return false;
        }
        cut(reader, length);
    }
    memcpy(group + key->count_offset, &count, sizeof count);
    return true;
}

static bool read_value(reader_t *reader, const common_key_t *key, const yaml_node_t *node, char *group)
{
    if (key->type == COMMON_KEY_SKIPPED)
    {
        return true;
    }
    const char            *called = common_key_type_name(key);
    const yaml_node_type_t type   = (key->type == COMMON_KEY_GROUP)  ? YAML_MAPPING_NODE
                                    : (key->type == COMMON_KEY_LIST) ? YAML_SEQUENCE_NODE
                                                                     : YAML_SCALAR_NODE;
    if (!check_kind(reader, type, called, node))
    {
        return false;
    }
    switch (type)
    {
    case YAML_MAPPING_NODE:
        return read_mapping(reader, common_key_below(key), node, group + key->offset);
    case YAML_SEQUENCE_NODE:
        return read_list(reader, key, node, group);
    default:
        return read_scalar(reader, key, node, group + key->offset);
    }
}

/// Appends a pair's name to the path.
static bool read_name(reader_t *reader, const yaml_node_t *mapping, const yaml_node_pair_t *pair)
{
    const yaml_node_t *node = node_of(reader, pair->key);
    reader->line            = node->start_mark.line + 1;
    if (node->type != YAML_SCALAR_NODE)
    {
        return complain(reader, "a key must be a word");
    }
    // A '.' or '[' inside a key would read as a path.
    if (has_zero_byte(node) || strpbrk(scalar(node), ".[]") != NULL)
    {
        return complain(reader, "unknown key %s", scalar(node));
    }
    if (!append(reader, "%s%s", reader->length > 0 ? "." : "", scalar(node)))
    {
        return false;
    }
    const yaml_node_t *other = find_in(reader, mapping, pair, scalar(node));
    return other == NULL ||
           complain(reader, "%s is given twice, first in line %zu", reader->path, other->start_mark.line + 1);
}

static bool read_pair(reader_t               *reader,
                      const common_key_t     *keys,
                      const yaml_node_t      *mapping,
                      const yaml_node_pair_t *pair,
                      char                   *group)
{
    if (!read_name(reader, mapping, pair))
    {
        return false;
    }
    const char         *name = scalar(node_of(reader, pair->key));
    const common_key_t *key  = common_key_in(keys, name, strlen(name));
    const size_t        line = reader->line;
    if (keys == reader->text->keys && reader->text->only != NULL && key != reader->text->only)
    {
        return complain(reader, "unknown key %s", reader->path);
    }
    if (key == NULL)
    {
        return complain_unknown(reader);
    }
    return read_value(reader, key, node_of(reader, pair->value), group) && note(reader, line);
}

static bool read_mapping(reader_t *reader, const common_key_t *keys, const yaml_node_t *mapping, char *group)
{
    const size_t length = reader->length;
    for (const yaml_node_pair_t *pair = mapping->data.mapping.pairs.start; pair < mapping->data.mapping.pairs.top;
         pair++)
    {
        if (!read_pair(reader, keys, mapping, pair, group))
        {
            return false;
        }
        cut(reader, length);
    }
    return true;
}

// --- the document --------------------------------------------------------------------------------------------------

static bool read_document(reader_t *reader)
{
    const yaml_node_t *root = yaml_document_get_root_node(&reader->document);
    reader->line            = root->start_mark.line + 1;
    return (root->type == YAML_MAPPING_NODE || complain(reader, "a mapping is expected here")) &&
           append(reader, "%s", reader->text->prefix) &&
           read_mapping(reader, reader->text->keys, root, reader->text->group);
}

bool common_read(const common_text_t *text, common_sources_t *sources, common_error_t *error)
{
    reader_t                  reader = {.text = text, .sources = sources, .error = error};
    common_document_problem_t problem;
    if (!common_document_load(&reader.document, text->text, COMMON_FILE_NODES_MAX, &problem))
    {
        reader.line = problem.line;
        return complain(&reader, "%s", problem.what);
    }
    const common_c_locale_t scope = common_c_locale_begin();
    const bool              ok    = read_document(&reader);
    common_c_locale_end(scope);
    yaml_document_delete(&reader.document);
    return ok;
}
