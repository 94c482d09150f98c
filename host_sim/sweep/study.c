#include "sweep/study.h"

#include "scenario/keys.h"
#include "support/file.h"
#include "support/number.h"
#include "support/text.h"
#include "sweep/sample.h"
#include "sweep/study_reader.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FILE_BYTES_MAX (4096u * 1024u) ///< of a study
#define LABEL_MAX      64u             ///< of a drawn number
#define NUMBER_MAX     64u

// --- values of axes ------------------------------------------------------------------------------------------------

/// Index of an axis's value in a row.
static size_t index_in_grid(const sim_study_t *study, uint64_t row, unsigned axis)
{
    uint64_t index = row % study->grid_rows;
    for (unsigned i = study->grid_count - 1; i > axis; i--)
    {
        index /= study->axes[i]->count;
    }
    return (size_t)(index % study->axes[axis]->count);
}

/// The row's probability in the axis's distribution, from 0 to 1.
static double probability_of(const sim_study_t *study, uint64_t row, unsigned axis)
{
    const sim_axis_t *it = study->axes[axis];
    if (axis >= study->grid_count)
    {
        return it->probability[row / study->grid_rows];
    }
    const double index = (double)index_in_grid(study, row, axis);
    return it->kind == SIM_AXIS_NORMAL ? (index + 0.5) / (double)it->count : index / (double)(it->count - 1);
}

static const sim_case_t *case_of(const sim_study_t *study, uint64_t row, unsigned axis)
{
    const sim_axis_t *it = study->axes[axis];
    if (axis < study->grid_count)
    {
        return &it->cases[index_in_grid(study, row, axis)];
    }
    const size_t index = (size_t)(it->probability[row / study->grid_rows] * (double)it->count);
    return &it->cases[index < it->count ? index : it->count - 1];
}

/// The distribution's value, as printed in the row's column.
static void draw(const sim_axis_t *axis, double p, char text[LABEL_MAX])
{
    double x;
    switch (axis->kind)
    {
    case SIM_AXIS_LOG_UNIFORM:
        x = axis->a * pow(axis->b / axis->a, p);
        break;
    case SIM_AXIS_NORMAL:
        if (axis->is_cut)
        {
            const double low  = sim_normal_probability((axis->low - axis->a) / axis->b);
            const double high = sim_normal_probability((axis->high - axis->a) / axis->b);
            p                 = low + p * (high - low);
        }
        x = axis->a + axis->b * sim_normal_value(p);
        break;
    default:
        x = axis->whole ? fmin(floor(axis->a + p * (axis->b - axis->a + 1.0)), axis->b)
                        : axis->a + p * (axis->b - axis->a);
        break;
    }
    (void)snprintf(text, LABEL_MAX, axis->whole ? "%.0f" : "%.6g", x);
}

/// The value of the axis's key number `k` where the column shows `label`.
static void value_of(const sim_axis_t *axis, unsigned k, const char *label, char text[NUMBER_MAX])
{
    if (axis->relative)
    {
        (void)snprintf(text, NUMBER_MAX, "%.9g", strtod(label, NULL) * axis->base[k]);
    }
    else
    {
        (void)snprintf(text, NUMBER_MAX, "%s", label);
    }
}

void sim_study_label(const sim_study_t *study, uint64_t row, unsigned axis, char *text, size_t size)
{
    const sim_axis_t *it = study->axes[axis];
    char              label[LABEL_MAX];
    if (it->kind == SIM_AXIS_LIST)
    {
        (void)snprintf(text, size, "%s", case_of(study, row, axis)->label);
        return;
    }
    draw(it, probability_of(study, row, axis), label);
    (void)snprintf(text, size, "%s", label);
}

// --- assignments ---------------------------------------------------------------------------------------------------

/// A list that owns its "key=value" strings.
typedef struct
{
    char **entry;
    size_t count;
    bool   failed; ///< out of memory
} list_t;

static void free_list(list_t *list)
{
    for (size_t i = 0; i < list->count; i++)
    {
        free(list->entry[i]);
    }
    free((void *)list->entry);
    *list = (list_t){.count = 0};
}

static bool same_key(const char *a, const char *b)
{
    const size_t length = strcspn(a, "=");
    return length == strcspn(b, "=") && strncmp(a, b, length) == 0;
}

/// Takes ownership of `assignment`, which replaces an earlier one of the same key.
static void put(list_t *list, char *assignment)
{
    if (assignment == NULL)
    {
        list->failed = true;
        return;
    }
    for (size_t i = 0; i < list->count; i++)
    {
        if (same_key(list->entry[i], assignment))
        {
            free(list->entry[i]);
            list->entry[i] = assignment;
            return;
        }
    }
    char **larger = (char **)realloc((void *)list->entry, (list->count + 1) * sizeof *larger);
    if (larger == NULL)
    {
        free(assignment);
        list->failed = true;
        return;
    }
    list->entry                = larger;
    list->entry[list->count++] = assignment;
}

static void put_settings(list_t *list, const sim_settings_t *settings)
{
    for (size_t i = 0; i < settings->count; i++)
    {
        put(list, strdup(settings->entry[i].assignment));
    }
}

static void put_axis(list_t *list, const sim_study_t *study, uint64_t row, unsigned axis)
{
    const sim_axis_t *it = study->axes[axis];
    char              label[LABEL_MAX];
    char              value[NUMBER_MAX];
    if (it->kind == SIM_AXIS_LIST)
    {
        put_settings(list, &case_of(study, row, axis)->settings);
        return;
    }
    draw(it, probability_of(study, row, axis), label);
    for (unsigned k = 0; k < it->key_count; k++)
    {
        value_of(it, k, label, value);
        put(list, sim_study_assignment(it->keys[k], value));
    }
}

/// All assignments of a row; check list->failed.
static list_t assignments_of(const sim_study_t *study, uint64_t row, bool without)
{
    list_t list = {.count = 0};
    put_settings(&list, &study->set);
    for (unsigned axis = 0; axis < study->axis_count; axis++)
    {
        put_axis(&list, study, row, axis);
    }
    if (without)
    {
        put_settings(&list, &study->without);
    }
    return list;
}

/// Appends to a growing text; null once memory is out.
static char *append(char *text, const char *more, const char *end)
{
    char *longer = text != NULL ? common_text_format("%s%s%s", text, more, end) : NULL;
    free(text);
    return longer;
}

char *sim_study_assignments(const sim_study_t *study, uint64_t row, bool without)
{
    list_t list = assignments_of(study, row, without);
    char  *text = list.failed ? NULL : strdup("");
    for (size_t i = 0; i < list.count; i++)
    {
        text = append(text, list.entry[i], "\n");
    }
    free_list(&list);
    return text;
}

/// Appends `word`, in single quotes if the shell would split it.
static char *append_word(char *text, const char *word)
{
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_+-./=,:@%";
    if (word[0] != '\0' && word[strspn(word, plain)] == '\0')
    {
        return append(text, " ", word);
    }
    text = append(text, " '", "");
    for (; *word != '\0'; word++)
    {
        const char c[2] = {*word, '\0'};
        text            = append(text, *word == '\'' ? "'\\''" : c, "");
    }
    return append(text, "'", "");
}

char *sim_study_command(const sim_study_t *study, uint64_t row, bool without)
{
    list_t list = assignments_of(study, row, without);
    char  *text = list.failed ? NULL : append_word(strdup("tribo-sim run"), study->scenario);
    text        = study->q31 ? append(text, " --arith q31", "") : text;
    for (size_t i = 0; i < list.count; i++)
    {
        text = append_word(append(text, " --set", ""), list.entry[i]);
    }
    free_list(&list);
    return text;
}

common_scenario_t *sim_study_scenario(const sim_study_t *study, uint64_t row, bool without, common_error_t *error)
{
    list_t             list     = assignments_of(study, row, without);
    common_scenario_t *scenario = sim_scenario_create();
    bool               ok       = (scenario != NULL && !list.failed) || common_error_set(error, "out of memory");
    ok                          = ok && common_scenario_load(scenario, study->scenario, error);
    for (size_t i = 0; ok && i < list.count; i++)
    {
        ok = common_scenario_set(scenario, list.entry[i], error);
    }
    ok = ok && sim_scenario_check(scenario, error);
    free_list(&list);
    if (!ok)
    {
        common_scenario_destroy(scenario);
        return NULL;
    }
    return scenario;
}

// --- checks --------------------------------------------------------------------------------------------------------

/// Sets a key of a scenario; errors name the study's line instead of "--set key=value".
static bool try_setting(const sim_study_t   *study,
                        common_scenario_t   *scenario,
                        const sim_setting_t *setting,
                        common_error_t      *error)
{
    common_error_t what = {""};
    if (common_scenario_set(scenario, setting->assignment, &what))
    {
        return true;
    }
    const size_t length = strlen(setting->assignment);
    const bool   named  = strncmp(what.text, "--set ", 6) == 0 &&
                       strncmp(what.text + 6, setting->assignment, length) == 0 &&
                       strncmp(what.text + 6 + length, ": ", 2) == 0;
    return sim_study_complain(study, setting->line, setting->column, error, "%s", what.text + (named ? length + 8 : 0));
}

static bool try_settings(const sim_study_t    *study,
                         common_scenario_t    *scenario,
                         const sim_settings_t *settings,
                         common_error_t       *error)
{
    for (size_t i = 0; i < settings->count; i++)
    {
        if (!try_setting(study, scenario, &settings->entry[i], error))
        {
            return false;
        }
    }
    return true;
}

/// Looks up the keys of an axis of numbers, and their values in the scenario.
static bool find_keys(const sim_study_t *study, sim_axis_t *axis, common_scenario_t *scenario, common_error_t *error)
{
    for (unsigned k = 0; k < axis->key_count; k++)
    {
        sim_config_t   config = *sim_scenario_config(scenario); // lookup returns writable pointers
        common_place_t place;
        if (!common_key_find(sim_keys, &config, axis->keys[k], &place) || place.at == NULL || place.is_element)
        {
            continue; // setting it reports the error
        }
        const common_key_type_t type = place.key->type;
        common_optional_t       base = {.is_given = true};
        if (type == COMMON_KEY_WHOLE && axis->kind == SIM_AXIS_UNIFORM && !axis->relative)
        {
            axis->whole = true;
        }
        else if (type == COMMON_KEY_NUMBER || type == COMMON_KEY_OPTIONAL)
        {
            memcpy(type == COMMON_KEY_OPTIONAL ? (void *)&base : (void *)&base.value,
                   place.at,
                   type == COMMON_KEY_OPTIONAL ? sizeof base : sizeof base.value);
        }
        else if (axis->relative || axis->kind != SIM_AXIS_LIST)
        {
            return sim_study_complain(study,
                                      axis->line,
                                      axis->column,
                                      error,
                                      "%s is not a number: values are expected",
                                      axis->keys[k]);
        }
        if (axis->relative && !base.is_given)
        {
            return sim_study_complain(study,
                                      axis->line,
                                      axis->column,
                                      error,
                                      "%s: the scenario gives no value to be relative to",
                                      axis->keys[k]);
        }
        axis->base[k] = base.value;
    }
    return true;
}

/// Turns the factors of a relative axis into values.
static bool scale_values(const sim_study_t *study, sim_axis_t *axis, common_error_t *error)
{
    for (size_t i = 0; i < axis->count; i++)
    {
        const sim_case_t *one = &axis->cases[i];
        for (unsigned k = 0; k < axis->key_count; k++)
        {
            sim_setting_t *setting = &one->settings.entry[k];
            double         factor;
            char           value[NUMBER_MAX];
            const char    *complaint = common_number_parse(one->label, &factor);
            if (complaint != NULL)
            {
                return sim_study_complain(study,
                                          setting->line,
                                          setting->column,
                                          error,
                                          "%s: '%.40s' %s",
                                          axis->name,
                                          one->label,
                                          complaint);
            }
            value_of(axis, k, one->label, value);
            free(setting->assignment);
            setting->assignment = sim_study_assignment(axis->keys[k], value);
            if (setting->assignment == NULL)
            {
                return common_error_set(error, "out of memory");
            }
        }
    }
    return true;
}

/// Tries the value at `p` of a distribution.
static bool try_value(const sim_study_t *study,
                      const sim_axis_t  *axis,
                      double             p,
                      common_scenario_t *scenario,
                      common_error_t    *error)
{
    char label[LABEL_MAX];
    char value[NUMBER_MAX];
    draw(axis, p, label);
    for (unsigned k = 0; k < axis->key_count; k++)
    {
        value_of(axis, k, label, value);
        const sim_setting_t setting = {.assignment = sim_study_assignment(axis->keys[k], value),
                                       .line       = axis->line,
                                       .column     = axis->column};
        const bool          ok      = (setting.assignment != NULL || common_error_set(error, "out of memory")) &&
                        try_setting(study, scenario, &setting, error);
        free(setting.assignment);
        if (!ok)
        {
            return false;
        }
    }
    return true;
}

/// All values of a list; of a distribution only its ends, because a key's range has no gaps.
static bool try_axis(const sim_study_t *study, unsigned number, common_scenario_t *scenario, common_error_t *error)
{
    const sim_axis_t *axis = study->axes[number];
    if (axis->kind == SIM_AXIS_LIST)
    {
        for (size_t i = 0; i < axis->count; i++)
        {
            if (!try_settings(study, scenario, &axis->cases[i].settings, error))
            {
                return false;
            }
        }
        return true;
    }
    double low = 0.0, high = 1.0;
    if (axis->kind == SIM_AXIS_NORMAL && !axis->is_cut) // the extreme samples of this study
    {
        low = high = probability_of(study, 0, number);
        for (uint64_t row = 1; row < study->rows; row++)
        {
            const double p = probability_of(study, row, number);
            low            = fmin(low, p);
            high           = fmax(high, p);
        }
    }
    return try_value(study, axis, low, scenario, error) && try_value(study, axis, high, scenario, error);
}

static bool sample_axes(sim_study_t *study)
{
    for (unsigned i = study->grid_count; i < study->axis_count; i++)
    {
        sim_axis_t *axis  = study->axes[i];
        axis->probability = calloc(study->samples, sizeof *axis->probability);
        if (axis->probability == NULL ||
            !sim_sample(axis->probability, study->samples, study->seed, axis->name, study->latin))
        {
            return false;
        }
    }
    return true;
}

/// Continues FNV-1a.
static uint32_t add_to_id(uint32_t id, const char *text)
{
    for (; *text != '\0'; text++)
    {
        id = (id ^ (unsigned char)*text) * 16777619u;
    }
    return id * 16777619u; // a separator, so that "a", "b" differs from "ab"
}

/// The id, from the files of a scenario.
static bool identify(sim_study_t *study, const char *text, const common_scenario_t *base, common_error_t *error)
{
    char *scenario = common_file_read(study->scenario, FILE_BYTES_MAX, error);
    if (scenario == NULL)
    {
        return false;
    }
    study->id = add_to_id(add_to_id(add_to_id(2166136261u, TRIBO_VERSION), text), scenario);
    free(scenario);
    const common_reference_config_t *reference_config = &common_scenario_loop(base)->reference;
    if (reference_config->kind == COMMON_REFERENCE_CSV && reference_config->file[0] != '\0')
    {
        char *path      = common_scenario_reference_path(base);
        char *reference = path != NULL ? common_file_read(path, 1u << 30u, error) : NULL;
        study->id       = reference != NULL ? add_to_id(study->id, reference) : 0;
        free(reference);
        free(path);
        return reference != NULL || common_error_set(error, "out of memory");
    }
    return true;
}

/// Checks the study against its scenario, and draws the samples.
static bool prepare(sim_study_t *study, const char *text, common_error_t *error)
{
    common_scenario_t *base = sim_scenario_create();
    bool               ok   = base != NULL || common_error_set(error, "out of memory");
    ok = ok && common_scenario_load(base, study->scenario, error) && try_settings(study, base, &study->set, error) &&
         identify(study, text, base, error);
    for (unsigned i = 0; ok && i < study->axis_count; i++)
    {
        sim_axis_t *axis = study->axes[i];
        ok               = find_keys(study, axis, base, error) &&
             (!axis->relative || axis->kind != SIM_AXIS_LIST || scale_values(study, axis, error));
    }
    ok = ok && (sample_axes(study) || common_error_set(error, "out of memory"));
    for (unsigned i = 0; ok && i < study->axis_count; i++)
    {
        ok = try_axis(study, i, base, error);
    }
    ok = ok && try_settings(study, base, &study->without, error);
    common_scenario_destroy(base);
    return ok;
}

// --- open and close ------------------------------------------------------------------------------------------------

static void free_settings(sim_settings_t *settings)
{
    for (size_t i = 0; i < settings->count; i++)
    {
        free(settings->entry[i].assignment);
    }
    free(settings->entry);
}

static void free_axis(sim_axis_t *axis)
{
    for (size_t i = 0; axis->cases != NULL && i < axis->count; i++)
    {
        free(axis->cases[i].label);
        free_settings(&axis->cases[i].settings);
    }
    for (unsigned k = 0; k < axis->key_count; k++)
    {
        free(axis->keys[k]);
    }
    free(axis->cases);
    free(axis->probability);
    free(axis->name);
    free(axis);
}

void sim_study_close(sim_study_t *study)
{
    if (study == NULL)
    {
        return;
    }
    for (unsigned i = 0; i < study->axis_count; i++)
    {
        free_axis(study->axes[i]);
    }
    free_settings(&study->set);
    free_settings(&study->without);
    free(study->scenario);
    free(study->path);
    free(study);
}

sim_study_t *sim_study_open(const char *path, sim_scenario_finder_t find, common_error_t *error)
{
    char        *text  = common_file_read(path, FILE_BYTES_MAX, error);
    char        *name  = NULL;
    sim_study_t *study = text != NULL ? calloc(1, sizeof *study) : NULL;
    bool         ok    = study != NULL;
    if (ok)
    {
        study->path = strdup(path);
        ok          = study->path != NULL && sim_study_read(study, text, &name, error);
    }
    if (ok)
    {
        // A scenario next to the study takes precedence over the scenarios folder.
        const char *slash  = strrchr(path, '/');
        char       *beside = common_text_format("%.*s%s", slash != NULL ? (int)(slash - path) + 1 : 0, path, name);
        const bool  is_its = beside != NULL && name[0] != '/' && common_file_exists(beside);
        study->scenario    = is_its ? strdup(beside) : find(name);
        free(beside);
        ok = study->scenario != NULL && prepare(study, text, error);
    }
    free(name);
    free(text);
    if (!ok)
    {
        (void)common_error_set(error, "out of memory"); // unless an error is set already
        sim_study_close(study);
        return NULL;
    }
    return study;
}
