// Merges the rows of a study's shards into the file that a single sweep would have written.

#include "cli/commands.h"
#include "cli/sweep_options.h"
#include "support/output_file.h"
#include "support/text.h"
#include "sweep/rows.h"
#include "sweep/sweep.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

typedef struct
{
    const char *study;
    const char *folder;
} options_t;

enum
{
    OPTION_OUT = SIM_OPTION_FIRST
};

// clang-format off: one row an option
static const struct argp_option known[] = {
    {.name = "out", .key = OPTION_OUT, .arg = "DIR", .doc = "the folder of all DIR/rows-I-of-N.csv; DIR/rows.csv and DIR/summary.json are made of them"},
    {.name = NULL}};
// clang-format on

static int take(void *context, int key, const char *value)
{
    (void)key;
    options_t *options = context;
    options->folder    = value;
    return 0;
}

/// Skips a number and the word after it; null if they are missing.
static const char *skip(const char *text, uint64_t *number, const char *word)
{
    char *end = NULL;
    *number   = *text >= '0' && *text <= '9' ? strtoull(text, &end, 10) : 0;
    return end != NULL && strncmp(end, word, strlen(word)) == 0 ? end + strlen(word) : NULL;
}

/// The N of rows-I-of-N.csv; 0 for other files.
static uint64_t shards_of(const char *name)
{
    uint64_t    index = 0, count = 0;
    const char *next = strncmp(name, "rows-", 5) == 0 ? skip(name + 5, &index, "-of-") : NULL;
    next             = next != NULL ? skip(next, &count, ".csv") : NULL;
    return next != NULL && *next == '\0' && count <= SIM_SHARDS_MAX ? count : 0;
}

/// The number of shards, equal in all file names of the folder. 0 with the error filled in.
static uint64_t count_shards(const char *folder, common_error_t *error)
{
    DIR     *entries = opendir(folder);
    uint64_t shards  = 0;
    bool     ok      = true;
    if (entries == NULL)
    {
        (void)common_error_set(error, "%s: cannot be read: %s", folder, strerror(errno));
        return 0;
    }
    for (const struct dirent *entry = readdir(entries); ok && entry != NULL; entry = readdir(entries))
    {
        const uint64_t count = shards_of(entry->d_name);
        ok                   = shards == 0 || count == 0 || count == shards ||
             common_error_set(error,
                              "%s: holds parts of %" PRIu64 " and of %" PRIu64 ": remove those of an earlier sweep",
                              folder,
                              shards < count ? shards : count,
                              shards < count ? count : shards);
        shards = count != 0 ? count : shards;
    }
    (void)closedir(entries);
    if (shards == 0)
    {
        (void)common_error_set(error, "%s: holds no rows-I-of-N.csv", folder);
    }
    return ok ? shards : 0;
}

/// A shard's rows while they are read.
typedef struct
{
    char *text, *next;
} part_t;

static bool read_parts(part_t            *parts,
                       uint64_t           shards,
                       const sim_study_t *study,
                       const char        *folder,
                       const char        *header,
                       common_error_t    *error)
{
    bool ok = true;
    for (uint64_t i = 0; ok && i < shards; i++)
    {
        char            *path = sim_sweep_rows_path(folder, i, shards);
        const sim_rows_t file = {.path = path, .id = study->id, .shard = {.index = i, .count = shards}};
        parts[i].text         = path != NULL ? sim_rows_read(&file, header, study->rows, &parts[i].next, error) : NULL;
        ok                    = parts[i].text != NULL;
        free(path);
    }
    return ok;
}

static bool write_rows(part_t            *parts,
                       uint64_t           shards,
                       const sim_study_t *study,
                       const char        *folder,
                       const char        *header,
                       common_error_t    *error)
{
    common_output_file_t file = {.stream = NULL};
    char                *path = sim_sweep_rows_path(folder, 0, 1);
    bool                 ok   = path != NULL && common_output_open(&file, path, error);
    if (ok)
    {
        (void)fprintf(file.stream, "%s\n", header);
        for (uint64_t row = 0; row < study->rows; row++)
        {
            part_t *part = &parts[row % shards];
            (void)fprintf(file.stream, "%s\n", part->next);
            part->next += strlen(part->next) + 1;
        }
        ok = common_output_commit(&file, 1, error);
    }
    free(path);
    return ok;
}

static bool merge(const sim_study_t *study, const char *folder, common_error_t *error)
{
    const uint64_t shards = count_shards(folder, error);
    if (shards == 0)
    {
        return false;
    }
    char      *header = sim_sweep_header(study);
    part_t    *parts  = calloc(shards, sizeof *parts);
    const bool ok     = header != NULL && parts != NULL && sim_sweep_forget_summary(folder, error) &&
                    read_parts(parts, shards, study, folder, header, error) &&
                    write_rows(parts, shards, study, folder, header, error);
    for (uint64_t i = 0; parts != NULL && i < shards; i++)
    {
        free(parts[i].text);
    }
    free(parts);
    free(header);
    return ok ? sim_sweep_report(study, folder, error) : common_error_set(error, "out of memory"); // unless set already
}

static int merge_study(const options_t *options)
{
    common_error_t error = {""};
    sim_study_t   *study = sim_sweep_open(options->study, &error);
    const bool     ok    = study != NULL && merge(study, options->folder, &error);
    sim_study_close(study);
    return ok ? SIM_EXIT_OK : sim_failure(error.text);
}

static int run(int count, char **arguments)
{
    options_t options = {.folder = NULL};
    const int status  = sim_options_parse(&sim_command_merge, count, arguments, &options, &options.study);
    if (status != 0)
    {
        return status;
    }
    return options.folder != NULL ? merge_study(&options) : sim_usage("merge: --out DIR is expected");
}

const sim_command_t sim_command_merge = {.name     = "merge",
                                         .argument = "STUDY.yaml",
                                         .noun     = "study",
                                         .text     = "Joins the rows of all shards of a sweep in a folder.",
                                         .options  = known,
                                         .run      = run,
                                         .take     = take};
