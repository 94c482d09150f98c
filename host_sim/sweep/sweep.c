#include "sweep/sweep.h"

#include "scenario/runner.h"
#include "support/text.h"
#include "sweep/rows.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LABEL_MAX 4096u

const char *const sim_sweep_measures[SIM_SWEEP_MEASURES] = {"rms_error_N",
                                                            "max_error_N",
                                                            "rms_measured_error_N",
                                                            "u_variation_N",
                                                            "variation_ratio",
                                                            "chatter_ticks",
                                                            "Q_switches",
                                                            "window_ticks",
                                                            "limited_ticks",
                                                            "bad_inputs"};

/// A text written through `stream`; `bytes` is to be freed after fclose(stream).
typedef struct
{
    FILE  *stream;
    char  *bytes;
    size_t size;
} memory_t;

static bool open_memory(memory_t *memory)
{
    *memory        = (memory_t){.bytes = NULL};
    memory->stream = open_memstream(&memory->bytes, &memory->size);
    return memory->stream != NULL;
}

/// The text; null if memory ran out.
static char *close_memory(memory_t *memory)
{
    const bool failed = ferror(memory->stream) != 0;
    if (fclose(memory->stream) != 0 || failed)
    {
        free(memory->bytes);
        return NULL;
    }
    return memory->bytes;
}

char *sim_sweep_header(const sim_study_t *study)
{
    memory_t memory;
    if (!open_memory(&memory))
    {
        return NULL;
    }
    (void)fputs("study,row", memory.stream);
    for (unsigned i = 0; i < study->axis_count; i++)
    {
        (void)fputc(',', memory.stream);
        sim_rows_write_field(memory.stream, study->axes[i]->name);
    }
    for (unsigned without = 0; without <= (study->is_paired ? 1u : 0u); without++)
    {
        for (size_t i = 0; i < SIM_SWEEP_MEASURES; i++)
        {
            (void)fprintf(memory.stream, ",%s%s", without != 0 ? "without_" : "", sim_sweep_measures[i]);
        }
    }
    (void)fputs(study->is_paired ? ",ratio,status,message" : ",status,message", memory.stream);
    return close_memory(&memory);
}

/// Writes nothing for NaN, a missing number.
static void write_number(FILE *stream, double x)
{
    (void)fprintf(stream, isfinite(x) ? ",%.9g" : ",", x);
}

static void write_measures(FILE *stream, const sim_summary_t *summary)
{
    const sim_result_t *result                     = summary != NULL ? &summary->result : NULL;
    const double        values[SIM_SWEEP_MEASURES] = {
        result != NULL ? result->rms_error_n : (double)NAN,
        result != NULL ? result->max_error_n : (double)NAN,
        result != NULL ? result->rms_measured_error_n : (double)NAN,
        result != NULL ? result->activity.u_variation_n : (double)NAN,
        result != NULL ? sim_activity_variation_ratio(&result->activity) : (double)NAN,
        result != NULL ? (double)result->activity.chatter_ticks : (double)NAN,
        result != NULL ? (double)result->activity.q_switches : (double)NAN,
        result != NULL ? (double)result->activity.ticks : (double)NAN,
        result != NULL ? (double)result->limited_ticks : (double)NAN,
        result != NULL ? (double)result->bad_inputs : (double)NAN,
    };
    for (size_t i = 0; i < SIM_SWEEP_MEASURES; i++)
    {
        write_number(stream, values[i]);
    }
}

/// A row's columns; null stands for a missing run.
static char *write_row(const sim_study_t   *study,
                       uint64_t             row,
                       const sim_summary_t *with,
                       const sim_summary_t *without,
                       const char          *status,
                       const char          *message)
{
    memory_t memory;
    char     label[LABEL_MAX];
    if (!open_memory(&memory))
    {
        return NULL;
    }
    for (unsigned i = 0; i < study->axis_count; i++)
    {
        sim_study_label(study, row, i, label, sizeof label);
        (void)fputs(i > 0 ? "," : "", memory.stream);
        sim_rows_write_field(memory.stream, label);
    }
    write_measures(memory.stream, with);
    if (study->is_paired)
    {
        write_measures(memory.stream, without);
        const bool both = with != NULL && without != NULL && with->result.rms_error_n > 0.0;
        write_number(memory.stream, both ? without->result.rms_error_n / with->result.rms_error_n : (double)NAN);
    }
    (void)fprintf(memory.stream, ",%s,", status);
    sim_rows_write_field(memory.stream, message);
    char *text = close_memory(&memory);
    // A study without axes: the row begins with its measures.
    if (text != NULL && study->axis_count == 0)
    {
        memmove(text, text + 1, strlen(text));
    }
    return text;
}

/// Status of a failed run: refused before its start, or failed during it. Null on success.
static const char *play(const sim_study_t *study,
                        uint64_t           row,
                        bool               without,
                        sim_summary_t     *summary,
                        common_error_t    *error)
{
    const sim_run_options_t options  = {.q31 = study->q31};
    common_scenario_t      *scenario = sim_study_scenario(study, row, without, error);
    if (scenario == NULL)
    {
        return "refused";
    }
    *summary      = (sim_summary_t){.ticks = 0};
    const bool ok = sim_run(scenario, &options, NULL, NULL, summary, error);
    common_scenario_destroy(scenario);
    return ok ? NULL : summary->ticks == 0 ? "refused" : "failed";
}

/// The run with `without`, repeated only if it differs from the last one.
static const char *play_without(const sim_study_t *study, uint64_t row, sim_sweep_last_t *last, common_error_t *error)
{
    char *assignments = sim_study_assignments(study, row, true);
    if (assignments != NULL && last->assignments != NULL && strcmp(assignments, last->assignments) == 0)
    {
        free(assignments);
        return NULL;
    }
    free(last->assignments);
    last->assignments  = NULL;
    const char *status = play(study, row, true, &last->summary, error);
    if (status != NULL)
    {
        free(assignments);
        return status;
    }
    last->assignments = assignments;
    return NULL;
}

char *sim_sweep_row(const sim_study_t *study, uint64_t row, sim_sweep_last_t *last, double *simulated_s)
{
    common_error_t error = {""};
    sim_summary_t  with;
    const char    *status = play(study, row, false, &with, &error);
    if (status != NULL)
    {
        return write_row(study, row, NULL, NULL, status, error.text);
    }
    *simulated_s += with.simulated_s;
    if (!study->is_paired)
    {
        return write_row(study, row, &with, NULL, "ok", "");
    }
    const char *before = last->assignments;
    status             = play_without(study, row, last, &error);
    *simulated_s += (status == NULL && last->assignments != before) ? last->summary.simulated_s : 0.0;
    if (status != NULL)
    {
        char *message = common_text_format("without: %s", error.text);
        char *text    = message != NULL ? write_row(study, row, &with, NULL, status, message) : NULL;
        free(message);
        return text;
    }
    return write_row(study, row, &with, &last->summary, "ok", "");
}

char *sim_sweep_failed_row(const sim_study_t *study, uint64_t row, const char *status, const char *message)
{
    return write_row(study, row, NULL, NULL, status, message);
}
