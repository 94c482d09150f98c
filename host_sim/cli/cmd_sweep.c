// Plays the rows of a study on all cores, and resumes an interrupted sweep.

#include "cli/commands.h"
#include "cli/sweep_options.h"
#include "support/clock.h"
#include "support/number.h"
#include "support/output_file.h"
#include "support/text.h"
#include "sweep/pool.h"
#include "sweep/rows.h"
#include "sweep/sweep.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

typedef struct
{
    const char *study;
    const char *folder;
    uint64_t    workers; ///< 0: one for each core
    sim_shard_t shard;
    const char *row; ///< null: all
} options_t;

enum
{
    OPTION_OUT = SIM_OPTION_FIRST,
    OPTION_WORKERS,
    OPTION_SHARD,
    OPTION_ROW
};

// clang-format off: one row an option
static const struct argp_option known[] = {
    {.name = "out", .key = OPTION_OUT, .arg = "DIR", .doc = "where DIR/rows.csv and DIR/summary.json go; rows that are there already are not played again"},
    {.name = "workers", .key = OPTION_WORKERS, .arg = "N", .doc = "how many runs at a time; one for each core if left out"},
    {.name = "shard", .key = OPTION_SHARD, .arg = "I/N", .doc = "plays the I-th of N parts alone, into DIR/rows-I-of-N.csv; `merge` joins them"},
    {.name = "row", .key = OPTION_ROW, .arg = "ROW", .doc = "plays nothing, prints the commands that play this row"},
    {.name = NULL}};
// clang-format on

static int take_shard(sim_shard_t *shard, const char *value)
{
    char        first[24] = "";
    const char *slash     = strchr(value, '/');
    uint64_t    index = 0, count = 0;
    if (slash != NULL && (size_t)(slash - value) < sizeof first)
    {
        memcpy(first, value, (size_t)(slash - value));
    }
    if (slash == NULL || common_number_parse_whole(first, &index) != NULL ||
        common_number_parse_whole(slash + 1, &count) != NULL || index < 1 || index > count || count > SIM_SHARDS_MAX)
    {
        return sim_usage("--shard %s: I/N is expected, with I from 1 to N, at most %u", value, SIM_SHARDS_MAX);
    }
    *shard = (sim_shard_t){.index = index - 1, .count = count};
    return 0;
}

static int take(void *context, int key, const char *value)
{
    options_t *options = context;
    switch (key)
    {
    case OPTION_OUT:
        options->folder = value;
        return 0;
    case OPTION_WORKERS:
        return common_number_parse_whole(value, &options->workers) == NULL && options->workers >= 1 &&
                       options->workers <= SIM_POOL_WORKERS_MAX
                   ? 0
                   : sim_usage("--workers %s: a number from 1 to %u is expected", value, SIM_POOL_WORKERS_MAX);
    case OPTION_SHARD:
        return take_shard(&options->shard, value);
    default:
        options->row = value;
        return 0;
    }
}

// --- progress ------------------------------------------------------------------------------------------------------

typedef struct
{
    double   start_s, next_s;
    uint64_t before; ///< rows present at the start
    bool     is_shown, is_wanted;
} progress_t;

static void show_progress(progress_t *progress, uint64_t done, uint64_t rows)
{
    const double now_s = common_clock_s();
    if (!progress->is_wanted || now_s < progress->next_s)
    {
        return;
    }
    const double left_s = (now_s - progress->start_s) / (double)(done - progress->before) * (double)(rows - done);
    char         left[48];
    (void)snprintf(left,
                   sizeof left,
                   left_s < 100.0    ? "%.0f s left"
                   : left_s < 6000.0 ? "%.0f min left"
                                     : "%.1f h left",
                   left_s < 100.0    ? left_s
                   : left_s < 6000.0 ? left_s / 60.0
                                     : left_s / 3600.0);
    (void)fprintf(stderr,
                  "\r%3.0f %%, %" PRIu64 " of %" PRIu64 " rows, %-16s",
                  floor(100.0 * (double)done / (double)rows),
                  done,
                  rows,
                  left);
    progress->next_s   = now_s + 0.5;
    progress->is_shown = true;
}

// --- the rows ------------------------------------------------------------------------------------------------------

typedef struct
{
    const sim_study_t *study;
    sim_rows_t         file;
    sim_sweep_last_t   last; ///< of a worker
    uint64_t           rows; ///< of the shard
    double             simulated_s;
    progress_t         progress;
} sweep_t;

static uint64_t row_of(const sweep_t *sweep, uint64_t place)
{
    return place * sweep->file.shard.count + sweep->file.shard.index;
}

static char *work(void *context, uint64_t place, double *simulated_s)
{
    sweep_t *sweep = context;
    return sim_sweep_row(sweep->study, row_of(sweep, place), &sweep->last, simulated_s);
}

static char *lost(void *context, uint64_t place, sim_pool_loss_t how, int signal)
{
    const sweep_t *sweep = context;
    char           message[96];
    if (how == SIM_POOL_TIMED_OUT)
    {
        (void)snprintf(message, sizeof message, "took more than %g s of CPU time", sweep->study->timeout_s);
    }
    else
    {
        (void)snprintf(message, sizeof message, "the program was ended by signal %d", signal);
    }
    return sim_sweep_failed_row(sweep->study,
                                row_of(sweep, place),
                                how == SIM_POOL_TIMED_OUT ? "timeout" : "crashed",
                                message);
}

static bool take_row(void *context, uint64_t place, const char *text, double simulated_s, common_error_t *error)
{
    sweep_t *sweep = context;
    sweep->simulated_s += simulated_s;
    show_progress(&sweep->progress, place + 1, sweep->rows);
    return sim_rows_append(&sweep->file, text, error);
}

static double cpu_of_children_s(void)
{
    struct rusage usage;
    (void)getrusage(RUSAGE_CHILDREN, &usage);
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

static void print_speed(const sweep_t *sweep, unsigned workers)
{
    const double   wall_s = common_clock_s() - sweep->progress.start_s;
    const double   cpu_s  = cpu_of_children_s();
    const uint64_t played = sweep->rows - sweep->progress.before;
    (void)printf("%" PRIu64 " rows, %" PRIu64 " of them played now", sweep->rows, played);
    if (played > 0 && cpu_s > 0.0 && wall_s > 0.0)
    {
        (void)printf(": %.6g s simulated in %.3g s by %u workers, %.0f times real time a core in %.3g s of CPU time",
                     sweep->simulated_s,
                     wall_s,
                     workers,
                     sweep->simulated_s / cpu_s,
                     cpu_s);
    }
    (void)puts("");
}

/// Opens the file of rows, and plays the missing ones.
static bool play(sweep_t *sweep, const char *path, unsigned workers, common_error_t *error)
{
    char      *header = sim_sweep_header(sweep->study);
    const bool opened = (header != NULL || common_error_set(error, "out of memory")) &&
                        sim_rows_open(&sweep->file, header, sweep->study->rows, error);
    free(header);
    if (!opened)
    {
        return false;
    }
    sweep->file.path      = path;
    sweep->progress       = (progress_t){.start_s   = common_clock_s(),
                                         .next_s    = common_clock_s() + 1.0,
                                         .before    = sweep->file.rows,
                                         .is_wanted = isatty(STDERR_FILENO) != 0};
    const sim_pool_t pool = {.first     = sweep->file.rows,
                             .end       = sweep->rows,
                             .workers   = workers,
                             .timeout_s = sweep->study->timeout_s,
                             .context   = sweep,
                             .work      = work,
                             .lost      = lost,
                             .take      = take_row};
    const bool       ok   = sim_pool_run(&pool, error);
    if (sweep->progress.is_shown)
    {
        (void)fprintf(stderr, "\r%60s\r", "");
    }
    return sim_rows_close(&sweep->file, error) && ok;
}

static bool sweep_study(const sim_study_t *study, const options_t *options, common_error_t *error)
{
    const unsigned workers = options->workers != 0 ? (unsigned)options->workers : sim_pool_cores();
    const bool     whole   = options->shard.count == 1;
    sweep_t        sweep   = {.study = study, .rows = sim_shard_rows(&options->shard, study->rows)};
    char          *path    = sim_sweep_rows_path(options->folder, options->shard.index, options->shard.count);
    sweep.file             = (sim_rows_t){.path = path, .id = study->id, .shard = options->shard};
    bool ok                = (path != NULL || common_error_set(error, "out of memory")) &&
              common_output_folder_create(options->folder, error) &&
              (!whole || sim_sweep_forget_summary(options->folder, error)) && play(&sweep, path, workers, error);
    if (ok)
    {
        print_speed(&sweep, workers);
        ok = whole ? sim_sweep_report(study, options->folder, error) : common_output_flush(error);
    }
    free(path);
    return ok;
}

/// Prints the commands that play a row, instead of playing it.
static bool print_row(const sim_study_t *study, const char *text, common_error_t *error)
{
    uint64_t    row       = 0;
    const char *complaint = common_number_parse_whole(text, &row);
    if (complaint != NULL || row >= study->rows)
    {
        return complaint != NULL
                   ? common_error_set(error, "--row %s: '%.40s' %s", text, text, complaint)
                   : common_error_set(error, "--row %s: %s is outside 0 to %" PRIu64, text, text, study->rows - 1);
    }
    bool ok = true;
    for (unsigned without = 0; ok && without <= (study->is_paired ? 1u : 0u); without++)
    {
        char *command = sim_study_command(study, row, without != 0);
        ok            = (command != NULL && puts(command) >= 0) || common_error_set(error, "out of memory");
        free(command);
    }
    return ok && common_output_flush(error);
}

static int run(int count, char **arguments)
{
    options_t options = {.shard = {.count = 1}};
    int       status  = sim_options_parse(&sim_command_sweep, count, arguments, &options, &options.study);
    if (status == 0 && (options.folder == NULL) == (options.row == NULL))
    {
        status = options.folder == NULL ? sim_usage("sweep: --out DIR is expected")
                                        : sim_usage("sweep: --out and --row do not go together");
    }
    if (status == 0)
    {
        common_error_t error = {""};
        sim_study_t   *study = sim_sweep_open(options.study, &error);
        const bool     ok    = study != NULL && (options.row != NULL ? print_row(study, options.row, &error)
                                                                     : sweep_study(study, &options, &error));
        sim_study_close(study);
        status = ok ? SIM_EXIT_OK : sim_failure(error.text);
    }
    return status;
}

const sim_command_t sim_command_sweep = {.name     = "sweep",
                                         .argument = "STUDY.yaml",
                                         .noun     = "study",
                                         .text = "Plays a study: a scenario many times, with other values of its keys "
                                                 "each time. A path, or a name in the studies folder.",
                                         .options = known,
                                         .run     = run,
                                         .take    = take};
