#include "sweep/study_reader.h"

#include "keys/document.h"
#include "keys/suggest.h"
#include "support/number.h"
#include "support/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NODES_MAX  20000u
#define POINTS_MAX 100000u ///< of an axis

typedef struct
{
    sim_study_t    *study;
    yaml_document_t document;
    common_error_t *error;
    char          **scenario_name;
} reader_t;

// --- messages ------------------------------------------------------------------------------------------------------

bool sim_study_complain(const sim_study_t *study,
                        size_t             line,
                        size_t             column,
                        common_error_t    *error,
                        const char        *format,
                        ...)
{
    common_error_t what = {""};
    va_list        args;
    va_start(args, format);
    (void)common_error_set_list(&what, format, args);
    va_end(args);
    return common_error_set(error, "%s:%zu:%zu: %s", study->path, line, column, what.text);
}

#define COMPLAIN(reader, node, ...)                                                                                    \
    sim_study_complain((reader)->study,                                                                                \
                       COMMON_LINE((node)->start_mark),                                                                \
                       COMMON_COLUMN((node)->start_mark),                                                              \
                       (reader)->error,                                                                                \
                       __VA_ARGS__)

static bool no_memory(const reader_t *reader)
{
    return common_error_set(reader->error, "out of memory");
}

// --- nodes ---------------------------------------------------------------------------------------------------------

static const yaml_node_t *node_of(reader_t *reader, int id)
{
    return yaml_document_get_node(&reader->document, id);
}

static const char *scalar(const yaml_node_t *node)
{
    return (const char *)node->data.scalar.value;
}

static bool check_kind(const reader_t *reader, const yaml_node_t *node, yaml_node_type_t type, const char *name)
{
    static const char *const called[] =
        {[YAML_SCALAR_NODE] = "a single value", [YAML_MAPPING_NODE] = "a mapping", [YAML_SEQUENCE_NODE] = "a list"};
    if (node->type != type)
    {
        return COMPLAIN(reader, node, "%s: %s is expected here, not %s", name, called[type], called[node->type]);
    }
    return type != YAML_SCALAR_NODE || strlen(scalar(node)) == node->data.scalar.length ||
           COMPLAIN(reader, node, "%s: holds a zero byte", name);
}

typedef bool (*pair_handler_t)(reader_t *reader, void *context, const yaml_node_t *key, const yaml_node_t *value);

/// Calls `take` with each pair of a mapping, whose keys are all different words.
static bool read_pairs(reader_t          *reader,
                       const yaml_node_t *mapping,
                       const char        *name,
                       pair_handler_t     take,
                       void              *context)
{
    if (!check_kind(reader, mapping, YAML_MAPPING_NODE, name))
    {
        return false;
    }
    const yaml_node_pair_t *first = mapping->data.mapping.pairs.start;
    for (const yaml_node_pair_t *pair = first; pair < mapping->data.mapping.pairs.top; pair++)
    {
        const yaml_node_t *key = node_of(reader, pair->key);
        if (!check_kind(reader, key, YAML_SCALAR_NODE, name))
        {
            return false;
        }
        for (const yaml_node_pair_t *other = first; other < pair; other++)
        {
            const yaml_node_t *before = node_of(reader, other->key);
            if (strcmp(scalar(before), scalar(key)) == 0)
            {
                return COMPLAIN(reader,
                                key,
                                "%s is given twice, first in line %zu",
                                scalar(key),
                                COMMON_LINE(before->start_mark));
            }
        }
        if (!take(reader, context, key, node_of(reader, pair->value)))
        {
            return false;
        }
    }
    return true;
}

/// Reports a key that is not among `words`, with the most similar one. Always false.
static bool complain_unknown(const reader_t *reader, const yaml_node_t *key, const char *const *words)
{
    const common_key_t choice = {.words = words};
    const char        *meant  = common_suggest_word(&choice, scalar(key));
    return meant != NULL ? COMPLAIN(reader, key, "unknown key %s, did you mean %s?", scalar(key), meant)
                         : COMPLAIN(reader, key, "unknown key %s", scalar(key));
}

static int word_of(const char *const *words, const char *text)
{
    int index = 0;
    while (words[index] != NULL && strcmp(words[index], text) != 0)
    {
        index++;
    }
    return index;
}

// --- single values -------------------------------------------------------------------------------------------------

static bool read_number(const reader_t *reader, const yaml_node_t *node, const char *name, double *value)
{
    if (!check_kind(reader, node, YAML_SCALAR_NODE, name))
    {
        return false;
    }
    const char *complaint = common_number_parse(scalar(node), value);
    return complaint == NULL || COMPLAIN(reader, node, "%s: '%.40s' %s", name, scalar(node), complaint);
}

static bool read_whole(const reader_t    *reader,
                       const yaml_node_t *node,
                       const char        *name,
                       uint64_t           min,
                       uint64_t           max,
                       uint64_t          *value)
{
    if (!check_kind(reader, node, YAML_SCALAR_NODE, name))
    {
        return false;
    }
    const char *complaint = common_number_parse_whole(scalar(node), value);
    if (complaint != NULL)
    {
        return COMPLAIN(reader, node, "%s: '%.40s' %s", name, scalar(node), complaint);
    }
    return (*value >= min && *value <= max) || COMPLAIN(reader,
                                                        node,
                                                        "%s: %llu is outside %llu to %llu",
                                                        name,
                                                        (unsigned long long)*value,
                                                        (unsigned long long)min,
                                                        (unsigned long long)max);
}

/// One of two words; the second means true.
static bool read_either(const reader_t    *reader,
                        const yaml_node_t *node,
                        const char        *name,
                        const char        *no,
                        const char        *yes,
                        bool              *value)
{
    if (!check_kind(reader, node, YAML_SCALAR_NODE, name))
    {
        return false;
    }
    *value = strcmp(scalar(node), yes) == 0;
    return *value || strcmp(scalar(node), no) == 0 ||
           COMPLAIN(reader, node, "%s: '%.40s' is not %s or %s", name, scalar(node), no, yes);
}

/// Two numbers in a list.
static bool read_two(reader_t *reader, const yaml_node_t *node, const char *name, double *a, double *b)
{
    if (!check_kind(reader, node, YAML_SEQUENCE_NODE, name))
    {
        return false;
    }
    const yaml_node_item_t *items = node->data.sequence.items.start;
    return (node->data.sequence.items.top - items == 2 ||
            COMPLAIN(reader, node, "%s: two numbers are expected here", name)) &&
           read_number(reader, node_of(reader, items[0]), name, a) &&
           read_number(reader, node_of(reader, items[1]), name, b);
}

// --- settings ------------------------------------------------------------------------------------------------------

/// The value is quoted unless YAML reads it as one plain word.
char *sim_study_assignment(const char *key, const char *value)
{
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_+-./";
    if (value[0] != '\0' && value[strspn(value, plain)] == '\0')
    {
        return common_text_format("%s=%s", key, value);
    }
    char *text = malloc(strlen(key) + 4 * strlen(value) + 4);
    if (text != NULL)
    {
        size_t length = (size_t)sprintf(text, "%s=\"", key);
        for (; *value != '\0'; value++)
        {
            const unsigned char c = (unsigned char)*value;
            length += (size_t)(c == '"' || c == '\\' ? sprintf(text + length, "\\%c", c)
                               : c < 0x20            ? sprintf(text + length, "\\x%02x", c)
                                                     : sprintf(text + length, "%c", c));
        }
        (void)sprintf(text + length, "\"");
    }
    return text;
}

static bool add_setting(reader_t *reader, sim_settings_t *settings, const char *key, const yaml_node_t *value)
{
    sim_setting_t *larger = realloc(settings->entry, (settings->count + 1) * sizeof *larger);
    if (larger == NULL)
    {
        return no_memory(reader);
    }
    settings->entry                    = larger;
    settings->entry[settings->count++] = (sim_setting_t){.assignment = sim_study_assignment(key, scalar(value)),
                                                         .line       = COMMON_LINE(value->start_mark),
                                                         .column     = COMMON_COLUMN(value->start_mark)};
    return settings->entry[settings->count - 1].assignment != NULL || no_memory(reader);
}

static bool take_setting(reader_t *reader, void *context, const yaml_node_t *key, const yaml_node_t *value)
{
    return check_kind(reader, value, YAML_SCALAR_NODE, scalar(key)) && add_setting(reader, context, scalar(key), value);
}

// --- axes ----------------------------------------------------------------------------------------------------------

static sim_case_t *add_case(reader_t *reader, sim_axis_t *axis, const char *label)
{
    sim_case_t *larger = realloc(axis->cases, (axis->count + 1) * sizeof *larger);
    if (larger == NULL)
    {
        (void)no_memory(reader);
        return NULL;
    }
    axis->cases = larger;
    larger += axis->count++;
    *larger = (sim_case_t){.label = strdup(label)};
    if (larger->label == NULL)
    {
        (void)no_memory(reader);
        return NULL;
    }
    return larger;
}

static bool take_case(reader_t *reader, void *context, const yaml_node_t *key, const yaml_node_t *value)
{
    sim_case_t *added = add_case(reader, context, scalar(key));
    return added != NULL && read_pairs(reader, value, scalar(key), take_setting, &added->settings);
}

/// The values become cases; their settings wait for the axis's keys (finish_axis).
static bool read_values(reader_t *reader, sim_axis_t *axis, const yaml_node_t *node)
{
    if (!check_kind(reader, node, YAML_SEQUENCE_NODE, axis->name))
    {
        return false;
    }
    for (const yaml_node_item_t *item = node->data.sequence.items.start; item < node->data.sequence.items.top; item++)
    {
        const yaml_node_t *value = node_of(reader, *item);
        if (!check_kind(reader, value, YAML_SCALAR_NODE, axis->name))
        {
            return false;
        }
        sim_case_t *added = add_case(reader, axis, scalar(value));
        if (added == NULL || !add_setting(reader, &added->settings, "", value))
        {
            return false;
        }
    }
    return true;
}

static bool add_key(reader_t *reader, sim_axis_t *axis, const yaml_node_t *node, const char *key)
{
    if (axis->key_count == SIM_STUDY_KEYS_MAX)
    {
        return COMPLAIN(reader, node, "%s: more than %u keys", axis->name, SIM_STUDY_KEYS_MAX);
    }
    axis->keys[axis->key_count] = strdup(key);
    return axis->keys[axis->key_count++] != NULL || no_memory(reader);
}

static bool read_keys(reader_t *reader, sim_axis_t *axis, const yaml_node_t *node)
{
    if (node->type == YAML_SCALAR_NODE)
    {
        return check_kind(reader, node, YAML_SCALAR_NODE, "keys") && add_key(reader, axis, node, scalar(node));
    }
    if (!check_kind(reader, node, YAML_SEQUENCE_NODE, "keys"))
    {
        return false;
    }
    for (const yaml_node_item_t *item = node->data.sequence.items.start; item < node->data.sequence.items.top; item++)
    {
        const yaml_node_t *key = node_of(reader, *item);
        if (!check_kind(reader, key, YAML_SCALAR_NODE, "keys") || !add_key(reader, axis, key, scalar(key)))
        {
            return false;
        }
    }
    return axis->key_count > 0 || COMPLAIN(reader, node, "keys: the list is empty");
}

/// The keys of an axis's mapping read so far.
typedef struct
{
    sim_axis_t        *axis;
    bool               in_grid;
    const yaml_node_t *kind, *cases, *points, *within; ///< null: not given
    uint64_t           point_count;
} axis_reader_t;

enum
{
    AXIS_VALUES,
    AXIS_CASES,
    AXIS_UNIFORM,
    AXIS_LOG_UNIFORM,
    AXIS_NORMAL,
    AXIS_KEYS,
    AXIS_RELATIVE,
    AXIS_POINTS,
    AXIS_WITHIN
};

static const char *const axis_words[] =
    {"values", "cases", "uniform", "log_uniform", "normal", "keys", "relative", "points", "within", NULL};

static bool take_axis_pair(reader_t *reader, void *context, const yaml_node_t *key, const yaml_node_t *value)
{
    axis_reader_t *part = context;
    sim_axis_t    *axis = part->axis;
    const int      word = word_of(axis_words, scalar(key));
    if (word <= AXIS_NORMAL)
    {
        if (part->kind != NULL)
        {
            return COMPLAIN(reader,
                            key,
                            "%s: %s and %s do not go together",
                            axis->name,
                            scalar(part->kind),
                            scalar(key));
        }
        part->kind = key;
    }
    switch (word)
    {
    case AXIS_VALUES:
        return read_values(reader, axis, value);
    case AXIS_CASES:
        part->cases = key;
        return read_pairs(reader, value, axis->name, take_case, axis);
    case AXIS_UNIFORM:
        axis->kind = SIM_AXIS_UNIFORM;
        return read_two(reader, value, scalar(key), &axis->a, &axis->b) &&
               (axis->a < axis->b || COMPLAIN(reader, value, "uniform: %g is not below %g", axis->a, axis->b));
    case AXIS_LOG_UNIFORM:
        axis->kind = SIM_AXIS_LOG_UNIFORM;
        return read_two(reader, value, scalar(key), &axis->a, &axis->b) &&
               ((axis->a > 0.0 && axis->a < axis->b) ||
                COMPLAIN(reader, value, "log_uniform: 0 < from < to is expected, not %g, %g", axis->a, axis->b));
    case AXIS_NORMAL:
        axis->kind = SIM_AXIS_NORMAL;
        return read_two(reader, value, scalar(key), &axis->a, &axis->b) &&
               (axis->b > 0.0 || COMPLAIN(reader, value, "normal: the standard deviation %g is not above 0", axis->b));
    case AXIS_KEYS:
        return read_keys(reader, axis, value);
    case AXIS_RELATIVE:
        return read_either(reader, value, scalar(key), "false", "true", &axis->relative);
    case AXIS_POINTS:
        part->points = key;
        return read_whole(reader, value, scalar(key), 2, POINTS_MAX, &part->point_count);
    case AXIS_WITHIN:
        part->within = key;
        axis->is_cut = true;
        return read_two(reader, value, scalar(key), &axis->low, &axis->high) &&
               (axis->low < axis->high || COMPLAIN(reader, value, "within: %g is not below %g", axis->low, axis->high));
    default:
        return complain_unknown(reader, key, axis_words);
    }
}

/// Checks which keys of an axis go together.
static bool check_axis(const reader_t *reader, const axis_reader_t *part, const yaml_node_t *node)
{
    const sim_axis_t *axis    = part->axis;
    const bool        is_list = axis->kind == SIM_AXIS_LIST;
    if (part->kind == NULL && axis->count == 0)
    {
        return COMPLAIN(reader, node, "%s: values, cases, uniform, log_uniform or normal is expected", axis->name);
    }
    if (part->cases != NULL && (axis->relative || axis->key_count > 0))
    {
        return COMPLAIN(reader, part->cases, "%s: cases have keys of their own: no keys, no relative", axis->name);
    }
    if (part->points != NULL && (is_list || !part->in_grid))
    {
        return COMPLAIN(reader, part->points, "%s: points are for a distribution in the grid", axis->name);
    }
    if (part->within != NULL && axis->kind != SIM_AXIS_NORMAL)
    {
        return COMPLAIN(reader, part->within, "%s: within goes with normal alone", axis->name);
    }
    if (is_list && axis->count == 0)
    {
        return COMPLAIN(reader, node, "%s: has no values", axis->name);
    }
    return is_list || !part->in_grid || part->points != NULL ||
           COMPLAIN(reader, node, "%s: in a grid a distribution wants points: how many", axis->name);
}

/// An axis without keys is named after its only key; each value gets its key.
static bool finish_axis(reader_t *reader, const axis_reader_t *part, const yaml_node_t *name)
{
    sim_axis_t *axis      = part->axis;
    const bool  has_cases = part->cases != NULL;
    axis->count           = part->points != NULL ? (size_t)part->point_count : axis->count;
    if (axis->key_count == 0 && !has_cases && !add_key(reader, axis, name, axis->name))
    {
        return false;
    }
    for (size_t i = 0; !has_cases && axis->kind == SIM_AXIS_LIST && i < axis->count; i++)
    {
        sim_case_t    *one   = &axis->cases[i];
        sim_setting_t  place = one->settings.entry[0];
        sim_setting_t *all   = calloc(axis->key_count, sizeof *all);
        if (all == NULL)
        {
            return no_memory(reader);
        }
        free(one->settings.entry);
        free(place.assignment);
        one->settings = (sim_settings_t){.entry = all, .count = axis->key_count};
        for (unsigned k = 0; k < axis->key_count; k++)
        {
            all[k] = (sim_setting_t){.assignment = sim_study_assignment(axis->keys[k], one->label),
                                     .line       = place.line,
                                     .column     = place.column};
            if (all[k].assignment == NULL)
            {
                return no_memory(reader);
            }
        }
    }
    return true;
}

static bool take_axis(reader_t *reader, const yaml_node_t *name, const yaml_node_t *node, bool in_grid)
{
    sim_study_t *study = reader->study;
    if (study->axis_count == SIM_STUDY_AXES_MAX)
    {
        return COMPLAIN(reader, name, "more than %u axes", SIM_STUDY_AXES_MAX);
    }
    for (unsigned i = 0; i < study->axis_count; i++)
    {
        if (strcmp(study->axes[i]->name, scalar(name)) == 0)
        {
            return COMPLAIN(reader, name, "%s is there twice, first in line %zu", scalar(name), study->axes[i]->line);
        }
    }
    sim_axis_t *axis = calloc(1, sizeof *axis);
    if (axis == NULL)
    {
        return no_memory(reader);
    }
    study->axes[study->axis_count++] = axis;
    *axis                            = (sim_axis_t){.name   = strdup(scalar(name)),
                                                    .line   = COMMON_LINE(name->start_mark),
                                                    .column = COMMON_COLUMN(name->start_mark)};
    axis_reader_t part               = {.axis = axis, .in_grid = in_grid};
    return (axis->name != NULL || no_memory(reader)) &&
           (node->type == YAML_SEQUENCE_NODE ? read_values(reader, axis, node)
                                             : read_pairs(reader, node, axis->name, take_axis_pair, &part)) &&
           check_axis(reader, &part, node) && finish_axis(reader, &part, name);
}

static bool take_grid_axis(reader_t *reader, void *context, const yaml_node_t *name, const yaml_node_t *node)
{
    (void)context;
    return take_axis(reader, name, node, true);
}

static bool take_sampled_axis(reader_t *reader, void *context, const yaml_node_t *name, const yaml_node_t *node)
{
    (void)context;
    return take_axis(reader, name, node, false);
}

// --- the study -----------------------------------------------------------------------------------------------------

enum
{
    STUDY_DESCRIPTION,
    STUDY_SCENARIO,
    STUDY_ARITHMETIC,
    STUDY_METHOD,
    STUDY_RUNS,
    STUDY_SEED,
    STUDY_TIMEOUT,
    STUDY_SET,
    STUDY_WITHOUT,
    STUDY_GRID,
    STUDY_SAMPLE,
    STUDY_WORDS
};

static const char *const study_words[] = {"description",
                                          "scenario",
                                          "arithmetic",
                                          "method",
                                          "runs",
                                          "seed",
                                          "timeout_s",
                                          "set",
                                          "without",
                                          "grid",
                                          "sample",
                                          NULL};

/// The nodes of a study by word; the axes are read once the rest is known.
typedef struct
{
    const yaml_node_t *key[STUDY_WORDS], *value[STUDY_WORDS];
} parts_t;

static bool take_part(reader_t *reader, void *context, const yaml_node_t *key, const yaml_node_t *value)
{
    parts_t  *parts = context;
    const int word  = word_of(study_words, scalar(key));
    if (word == STUDY_WORDS)
    {
        return complain_unknown(reader, key, study_words);
    }
    parts->key[word]   = key;
    parts->value[word] = value;
    return true;
}

static bool read_plain_parts(reader_t *reader, const parts_t *parts)
{
    sim_study_t              *study = reader->study;
    const yaml_node_t *const *value = parts->value;
    if (value[STUDY_SCENARIO] == NULL)
    {
        return sim_study_complain(study, 1, 1, reader->error, "scenario: is missing");
    }
    if (!check_kind(reader, value[STUDY_SCENARIO], YAML_SCALAR_NODE, "scenario"))
    {
        return false;
    }
    *reader->scenario_name = strdup(scalar(value[STUDY_SCENARIO]));
    study->seed            = 1;
    study->samples         = 1;
    study->timeout_s       = 600.0;
    return (*reader->scenario_name != NULL || no_memory(reader)) &&
           (value[STUDY_DESCRIPTION] == NULL ||
            check_kind(reader, value[STUDY_DESCRIPTION], YAML_SCALAR_NODE, "description")) &&
           (value[STUDY_ARITHMETIC] == NULL ||
            read_either(reader, value[STUDY_ARITHMETIC], "arithmetic", "f32", "q31", &study->q31)) &&
           (value[STUDY_SEED] == NULL || read_whole(reader, value[STUDY_SEED], "seed", 0, UINT64_MAX, &study->seed)) &&
           (value[STUDY_TIMEOUT] == NULL ||
            (read_number(reader, value[STUDY_TIMEOUT], "timeout_s", &study->timeout_s) &&
             ((study->timeout_s >= 0.01 && study->timeout_s <= 1e6) ||
              COMPLAIN(reader, value[STUDY_TIMEOUT], "timeout_s: %g is outside 0.01 to 1e+06", study->timeout_s))));
}

static bool read_sampling(reader_t *reader, const parts_t *parts)
{
    sim_study_t              *study = reader->study;
    const yaml_node_t *const *value = parts->value;
    if (value[STUDY_SAMPLE] == NULL)
    {
        const int extra = value[STUDY_METHOD] != NULL ? STUDY_METHOD
                          : value[STUDY_RUNS] != NULL ? STUDY_RUNS
                                                      : STUDY_WORDS;
        return extra == STUDY_WORDS ||
               COMPLAIN(reader, parts->key[extra], "%s goes with sample, which is missing", study_words[extra]);
    }
    study->latin = true;
    return (value[STUDY_RUNS] != NULL || COMPLAIN(reader, parts->key[STUDY_SAMPLE], "sample wants runs: how many")) &&
           read_whole(reader, value[STUDY_RUNS], "runs", 1, SIM_STUDY_RUNS_MAX, &study->samples) &&
           (value[STUDY_METHOD] == NULL ||
            read_either(reader, value[STUDY_METHOD], "method", "monte_carlo", "latin_hypercube", &study->latin)) &&
           read_pairs(reader, value[STUDY_SAMPLE], "sample", take_sampled_axis, NULL);
}

static bool read_study(reader_t *reader)
{
    sim_study_t       *study = reader->study;
    parts_t            parts = {{NULL}, {NULL}};
    const yaml_node_t *root  = yaml_document_get_root_node(&reader->document);
    if (!read_pairs(reader, root, "a study", take_part, &parts) || !read_plain_parts(reader, &parts))
    {
        return false;
    }
    const yaml_node_t *const *value = parts.value;
    study->is_paired                = value[STUDY_WITHOUT] != NULL;
    if ((value[STUDY_SET] != NULL && !read_pairs(reader, value[STUDY_SET], "set", take_setting, &study->set)) ||
        (study->is_paired && !read_pairs(reader, value[STUDY_WITHOUT], "without", take_setting, &study->without)) ||
        (value[STUDY_GRID] != NULL && !read_pairs(reader, value[STUDY_GRID], "grid", take_grid_axis, NULL)))
    {
        return false;
    }
    const yaml_node_t *grid = parts.key[STUDY_GRID] != NULL ? parts.key[STUDY_GRID] : root;
    const yaml_node_t *runs = parts.key[STUDY_RUNS] != NULL ? parts.key[STUDY_RUNS] : root;
    study->grid_count       = study->axis_count;
    study->grid_rows        = 1;
    for (unsigned i = 0; i < study->grid_count; i++)
    {
        study->grid_rows *= study->axes[i]->count;
        if (study->grid_rows > SIM_STUDY_ROWS_MAX)
        {
            return COMPLAIN(reader, grid, "grid: more than %u combinations", SIM_STUDY_ROWS_MAX);
        }
    }
    if (!read_sampling(reader, &parts))
    {
        return false;
    }
    study->rows = study->grid_rows * study->samples;
    return study->rows <= SIM_STUDY_ROWS_MAX || COMPLAIN(reader,
                                                         runs,
                                                         "runs: %llu rows with the grid, more than %u",
                                                         (unsigned long long)study->rows,
                                                         SIM_STUDY_ROWS_MAX);
}

bool sim_study_read(sim_study_t *study, const char *text, char **scenario_name, common_error_t *error)
{
    reader_t                  reader = {.study = study, .error = error, .scenario_name = scenario_name};
    common_document_problem_t problem;
    if (!common_document_load(&reader.document, text, NODES_MAX, &problem))
    {
        return sim_study_complain(study, problem.line, problem.column, error, "%s", problem.what);
    }
    const bool ok = read_study(&reader);
    yaml_document_delete(&reader.document);
    return ok;
}
