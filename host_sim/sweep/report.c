#include "sweep/report.h"

#include "support/text.h"
#include "sweep/rows.h"
#include "sweep/sweep.h"

#include <cjson/cJSON.h>

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define COLUMNS_MAX (2u * SIM_SWEEP_MEASURES + 1u)
#define FIELDS_MAX  (2u + SIM_STUDY_AXES_MAX + COLUMNS_MAX + 2u)

static const double probabilities[] = {0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0};

#define PROBABILITIES (sizeof probabilities / sizeof probabilities[0])

/// One column of numbers by row; NaN: none.
typedef struct
{
    char    name[48];
    double *value;
    size_t  count; ///< of numbers
    double  quantile[PROBABILITIES];
} column_t;

/// The worst rows by a column.
typedef struct
{
    const char *name;
    bool        lowest; ///< or the highest
    uint64_t    row[SIM_REPORT_WORST];
    double      value[SIM_REPORT_WORST];
    size_t      count;
} worst_t;

struct sim_report
{
    const sim_study_t *study;
    column_t           column[COLUMNS_MAX];
    unsigned           columns;
    uint64_t           failed, worse; ///< worse: ratio below 1
    char              *failure[SIM_REPORT_WORST];
    worst_t            worst[3];
};

// --- rows ----------------------------------------------------------------------------------------------------------

static bool name_columns(sim_report_t *report)
{
    const sim_study_t *study = report->study;
    for (unsigned without = 0; without <= (study->is_paired ? 1u : 0u); without++)
    {
        for (size_t i = 0; i < SIM_SWEEP_MEASURES; i++)
        {
            column_t *column = &report->column[report->columns++];
            (void)snprintf(column->name,
                           sizeof column->name,
                           "%s%s",
                           without != 0 ? "without_" : "",
                           sim_sweep_measures[i]);
        }
    }
    if (study->is_paired)
    {
        (void)snprintf(report->column[report->columns++].name, sizeof report->column[0].name, "ratio");
    }
    bool ok = true;
    for (unsigned i = 0; i < report->columns; i++)
    {
        report->column[i].value = calloc(study->rows, sizeof(double));
        ok                      = ok && report->column[i].value != NULL;
    }
    return ok;
}

static bool take_row(sim_report_t *report, uint64_t row, char *text, common_error_t *error)
{
    const size_t first = 2u + report->study->axis_count;
    const size_t last  = first + report->columns;
    char        *field[FIELDS_MAX];
    if (sim_rows_split(text, field, FIELDS_MAX) != last + 2)
    {
        return common_error_set(error, "row %" PRIu64 " of the result has not as many fields as its header", row);
    }
    for (unsigned i = 0; i < report->columns; i++)
    {
        const char *number           = field[first + i];
        report->column[i].value[row] = number[0] != '\0' ? strtod(number, NULL) : (double)NAN;
    }
    if (strcmp(field[last], "ok") != 0 && report->failed++ < SIM_REPORT_WORST)
    {
        char *failure = common_text_format("row %" PRIu64 ": %s: %s", row, field[last], field[last + 1]);
        report->failure[report->failed - 1] = failure;
        return failure != NULL || common_error_set(error, "out of memory");
    }
    return true;
}

static int compare_numbers(const void *a, const void *b)
{
    double x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return (x > y) - (x < y);
}

/// Quantiles, linear between the numbers in order.
static bool measure(column_t *column, uint64_t rows)
{
    double *sorted = calloc(rows, sizeof *sorted);
    if (sorted == NULL)
    {
        return false;
    }
    for (uint64_t i = 0; i < rows; i++)
    {
        if (!isnan(column->value[i]))
        {
            sorted[column->count++] = column->value[i];
        }
    }
    qsort(sorted, column->count, sizeof *sorted, compare_numbers);
    for (size_t i = 0; i < PROBABILITIES && column->count > 0; i++)
    {
        const double place  = probabilities[i] * (double)(column->count - 1);
        const size_t below  = (size_t)place;
        const size_t above  = below + 1 < column->count ? below + 1 : below;
        column->quantile[i] = sorted[below] + (place - (double)below) * (sorted[above] - sorted[below]);
    }
    free(sorted);
    return true;
}

static const column_t *find(const sim_report_t *report, const char *name)
{
    for (unsigned i = 0; i < report->columns; i++)
    {
        if (strcmp(report->column[i].name, name) == 0)
        {
            return &report->column[i];
        }
    }
    return NULL;
}

/// Keeps the worst rows in order; of equal ones the first.
static void rank(sim_report_t *report, worst_t *worst)
{
    const column_t *column = find(report, worst->name);
    for (uint64_t row = 0; column != NULL && row < report->study->rows; row++)
    {
        const double value = column->value[row];
        size_t       place = worst->count;
        while (place > 0 && (worst->lowest ? value < worst->value[place - 1] : value > worst->value[place - 1]))
        {
            place--;
        }
        if (isnan(value) || place == SIM_REPORT_WORST)
        {
            continue;
        }
        worst->count += worst->count < SIM_REPORT_WORST ? 1u : 0u;
        for (size_t i = worst->count - 1; i > place; i--)
        {
            worst->row[i]   = worst->row[i - 1];
            worst->value[i] = worst->value[i - 1];
        }
        worst->row[place]   = row;
        worst->value[place] = value;
    }
}

static bool evaluate(sim_report_t *report)
{
    const uint64_t  rows  = report->study->rows;
    const column_t *ratio = find(report, "ratio");
    for (unsigned i = 0; i < report->columns; i++)
    {
        if (!measure(&report->column[i], rows))
        {
            return false;
        }
    }
    for (uint64_t row = 0; ratio != NULL && row < rows; row++)
    {
        report->worse += ratio->value[row] < 1.0 ? 1u : 0u;
    }
    report->worst[0] = (worst_t){.name = "ratio", .lowest = true};
    report->worst[1] = (worst_t){.name = "rms_error_N"};
    report->worst[2] = (worst_t){.name = "chatter_ticks"};
    for (size_t i = 0; i < 3; i++)
    {
        rank(report, &report->worst[i]);
    }
    return true;
}

sim_report_t *sim_report_read(const sim_study_t *study, const char *path, common_error_t *error)
{
    const sim_rows_t file   = {.path = path, .id = study->id, .shard = {.count = 1}};
    char            *header = sim_sweep_header(study);
    char            *row    = NULL;
    char            *text   = header != NULL ? sim_rows_read(&file, header, study->rows, &row, error) : NULL;
    sim_report_t    *report = text != NULL ? calloc(1, sizeof *report) : NULL;
    bool             ok     = report != NULL;
    if (ok)
    {
        report->study = study;
        ok            = name_columns(report);
    }
    for (uint64_t i = 0; ok && i < study->rows; i++)
    {
        char *next = row + strlen(row) + 1;
        ok         = take_row(report, i, row, error);
        row        = next;
    }
    ok = ok && evaluate(report);
    free(text);
    free(header);
    if (!ok)
    {
        (void)common_error_set(error, "out of memory"); // unless an error is set already
        sim_report_free(report);
        return NULL;
    }
    return report;
}

void sim_report_free(sim_report_t *report)
{
    if (report != NULL)
    {
        for (unsigned i = 0; i < report->columns; i++)
        {
            free(report->column[i].value);
        }
        for (size_t i = 0; i < SIM_REPORT_WORST; i++)
        {
            free(report->failure[i]);
        }
        free(report);
    }
}

uint64_t sim_report_failed(const sim_report_t *report)
{
    return report->failed;
}

const char *sim_report_first_failure(const sim_report_t *report)
{
    return report->failure[0];
}

// --- output --------------------------------------------------------------------------------------------------------

void sim_report_print(const sim_report_t *report)
{
    (void)printf("%-28s", "quantiles");
    for (size_t i = 0; i < PROBABILITIES; i++)
    {
        (void)printf("%10.0f %%", 100.0 * probabilities[i]);
    }
    (void)puts("");
    for (unsigned c = 0; c < report->columns; c++)
    {
        const column_t *column = &report->column[c];
        (void)printf("%-28s", column->name);
        for (size_t i = 0; i < PROBABILITIES && column->count > 0; i++)
        {
            (void)printf("%12.5g", column->quantile[i]);
        }
        (void)puts("");
    }
    const column_t *ratio = find(report, "ratio");
    if (ratio != NULL && ratio->count > 0)
    {
        (void)printf("worse than without: %" PRIu64 " of %zu (%.3g %%)\n",
                     report->worse,
                     ratio->count,
                     100.0 * (double)report->worse / (double)ratio->count);
    }
    for (size_t i = 0; i < 3; i++)
    {
        const worst_t *worst   = &report->worst[i];
        char          *command = worst->count > 0 ? sim_study_command(report->study, worst->row[0], false) : NULL;
        if (command != NULL)
        {
            (void)printf("worst %s, %.4g in row %" PRIu64 ":\n  %s\n",
                         worst->name,
                         worst->value[0],
                         worst->row[0],
                         command);
        }
        free(command);
    }
}

static bool add_number(cJSON *object, const char *name, double value)
{
    return cJSON_AddNumberToObject(object, name, value) != NULL;
}

static bool add_numbers(cJSON *object, const char *name, const double *values, size_t count)
{
    cJSON *array = cJSON_AddArrayToObject(object, name);
    bool   ok    = array != NULL;
    for (size_t i = 0; ok && i < count; i++)
    {
        ok = cJSON_AddItemToArray(array, cJSON_CreateNumber(values[i]));
    }
    return ok;
}

static bool add_command(cJSON *object, const char *name, const sim_study_t *study, uint64_t row, bool without)
{
    char      *command = sim_study_command(study, row, without);
    const bool ok      = command != NULL && cJSON_AddStringToObject(object, name, command) != NULL;
    free(command);
    return ok;
}

static bool add_worst(cJSON *object, const sim_report_t *report, const worst_t *worst)
{
    cJSON *array = cJSON_AddArrayToObject(object, worst->name);
    bool   ok    = array != NULL;
    for (size_t i = 0; ok && i < worst->count; i++)
    {
        cJSON *one = cJSON_CreateObject();
        ok         = cJSON_AddItemToArray(array, one) && add_number(one, "row", (double)worst->row[i]) &&
             add_number(one, "value", worst->value[i]) &&
             add_command(one, "command", report->study, worst->row[i], false) &&
             (!report->study->is_paired || add_command(one, "without", report->study, worst->row[i], true));
    }
    return ok;
}

static bool add_all(cJSON *object, const sim_report_t *report)
{
    const sim_study_t *study = report->study;
    char               id[16];
    (void)snprintf(id, sizeof id, "%08" PRIx32, study->id);
    bool ok = cJSON_AddStringToObject(object, "study", study->path) != NULL &&
              cJSON_AddStringToObject(object, "id", id) != NULL && add_number(object, "rows", (double)study->rows) &&
              add_number(object, "failed", (double)report->failed) &&
              (!study->is_paired || add_number(object, "worse_than_without", (double)report->worse));
    cJSON *failures = cJSON_AddArrayToObject(object, "failures");
    for (size_t i = 0; ok && i < SIM_REPORT_WORST && report->failure[i] != NULL; i++)
    {
        ok = cJSON_AddItemToArray(failures, cJSON_CreateString(report->failure[i]));
    }
    cJSON *axes = cJSON_AddArrayToObject(object, "axes");
    for (unsigned i = 0; ok && i < study->axis_count; i++)
    {
        ok = cJSON_AddItemToArray(axes, cJSON_CreateString(study->axes[i]->name));
    }
    cJSON *relative = cJSON_AddArrayToObject(object, "relative");
    for (unsigned i = 0; ok && i < study->axis_count; i++)
    {
        ok = !study->axes[i]->relative || cJSON_AddItemToArray(relative, cJSON_CreateString(study->axes[i]->name));
    }
    cJSON *quantiles = cJSON_AddObjectToObject(object, "quantiles");
    ok               = ok && add_numbers(quantiles, "probabilities", probabilities, PROBABILITIES);
    for (unsigned i = 0; ok && i < report->columns; i++)
    {
        ok = add_numbers(quantiles,
                         report->column[i].name,
                         report->column[i].quantile,
                         report->column[i].count > 0 ? PROBABILITIES : 0);
    }
    cJSON *worst = cJSON_AddObjectToObject(object, "worst");
    for (size_t i = study->is_paired ? 0 : 1; ok && i < 3; i++)
    {
        ok = add_worst(worst, report, &report->worst[i]);
    }
    return ok;
}

char *sim_report_to_json(const sim_report_t *report)
{
    cJSON *object = cJSON_CreateObject();
    char  *text   = add_all(object, report) ? cJSON_Print(object) : NULL;
    cJSON_Delete(object);
    return text;
}
