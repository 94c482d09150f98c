#include "support/output_file.h"

#include "support/text.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// --- signals -------------------------------------------------------------------------------------------------------

// The one thing here that is not in a struct: what a signal handler has to know.
static char *volatile pending[SIM_OUTPUT_FILES_MAX];

static const int ending[] = {SIGINT, SIGTERM, SIGHUP};

#define ENDING (sizeof ending / sizeof ending[0])

static void remove_pending(int number)
{
    for (size_t i = 0; i < SIM_OUTPUT_FILES_MAX; i++)
    {
        if (pending[i] != NULL)
        {
            (void)unlink(pending[i]);
        }
    }
    (void)signal(number, SIG_DFL);
    (void)raise(number);
}

void sim_output_clean_on_signal(void)
{
    for (size_t i = 0; i < ENDING; i++)
    {
        // A signal that is ignored (nohup) stays so.
        if (signal(ending[i], remove_pending) == SIG_IGN)
        {
            (void)signal(ending[i], SIG_IGN);
        }
    }
}

/// The signals that end a run wait until they are unblocked; `before` is what was.
static void block_ending(sigset_t *before)
{
    sigset_t set;
    (void)sigemptyset(&set);
    for (size_t i = 0; i < ENDING; i++)
    {
        (void)sigaddset(&set, ending[i]);
    }
    (void)sigprocmask(SIG_BLOCK, &set, before);
}

/// Writes `name` in the place of `old` among what a signal is to remove.
static void replace_pending(const char *old, char *name)
{
    size_t i = 0;
    while (i < SIM_OUTPUT_FILES_MAX && pending[i] != old)
    {
        i++;
    }
    if (i < SIM_OUTPUT_FILES_MAX)
    {
        pending[i] = name;
    }
}

// --- opening -------------------------------------------------------------------------------------------------------

static void forget(sim_output_file_t *file)
{
    if (file->temporary != NULL)
    {
        replace_pending(file->temporary, NULL);
    }
    free(file->path);
    free(file->temporary);
    *file = (sim_output_file_t){.stream = NULL};
}

/// Opens a new file in the folder of file->path; that file's name may leave no room for a longer one.
static bool open_next_to(sim_output_file_t *file)
{
    const char *slash = strrchr(file->path, '/');
    file->temporary =
        sim_text_format("%.*s.tribo.XXXXXX", slash != NULL ? (int)(slash - file->path) + 1 : 0, file->path);
    const int descriptor = (file->temporary != NULL) ? mkstemp(file->temporary) : -1;
    if (descriptor < 0)
    {
        const int cause = errno;
        free(file->temporary);
        file->temporary = NULL;
        errno           = cause;
        return false;
    }
    // mkstemp makes files for their owner only; a result gets the mode that any new file would.
    const mode_t mask = umask(0);
    (void)umask(mask);
    (void)fchmod(descriptor, 0666u & ~mask);
    replace_pending(NULL, file->temporary);
    file->stream = fdopen(descriptor, "wb");
    return file->stream != NULL;
}

/// Where a file is to go: `path`, or what it points to, so that a link stays one.
static char *find_place(const char *path)
{
    struct stat info;
    const bool  is_link = lstat(path, &info) == 0 && S_ISLNK(info.st_mode);
    return is_link ? realpath(path, NULL) : strdup(path);
}

static bool open_place(sim_output_file_t *file, const char *path)
{
    struct stat info;
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode))
    {
        // A device or a pipe is there to be written to; a file renamed over it would end it.
        file->path   = strdup(path);
        file->stream = (file->path != NULL) ? fopen(path, "wb") : NULL;
        return file->stream != NULL;
    }
    file->path = find_place(path);
    // A signal must not come between the making of a file and its being remembered.
    sigset_t before;
    block_ending(&before);
    const bool opened = file->path != NULL && open_next_to(file);
    const int  cause  = errno;
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
    errno = cause;
    return opened;
}

bool sim_output_open(sim_output_file_t *file, const char *path, sim_error_t *error)
{
    *file = (sim_output_file_t){.stream = (path == NULL) ? stdout : NULL};
    if (path != NULL && !open_place(file, path))
    {
        (void)sim_error_set(error, "%s: cannot be written: %s", path, strerror(errno));
        sim_output_discard(file, 1);
        return false;
    }
    return true;
}

bool sim_output_expect_none(sim_output_file_t *file, const char *path, sim_error_t *error)
{
    *file = (sim_output_file_t){.path = strdup(path), .is_unwanted = true};
    return file->path != NULL || sim_error_set(error, "out of memory");
}

// --- closing -------------------------------------------------------------------------------------------------------

/// Ends the writing: what was wrong with it shows here at the latest, with errno set.
static bool close_stream(sim_output_file_t *file)
{
    // If a write has failed before, it is the caller's last act, and errno still says why.
    bool      ok  = !ferror(file->stream) && fflush(file->stream) == 0;
    const int why = errno;
    if (file->path != NULL && fclose(file->stream) != 0 && ok)
    {
        file->stream = NULL;
        return false;
    }
    file->stream = NULL;
    errno        = (why != 0) ? why : EIO;
    return ok;
}

static bool put_in_place(const sim_output_file_t *file)
{
    struct stat info;
    if (file->is_unwanted)
    {
        return stat(file->path, &info) != 0 || !S_ISREG(info.st_mode) || unlink(file->path) == 0;
    }
    return file->temporary == NULL || rename(file->temporary, file->path) == 0;
}

/// Returns the file that could not be put in its place, null if there is none.
static const sim_output_file_t *put_all_in_place(sim_output_file_t *files, size_t count)
{
    if (count > 1 && files[count - 1].temporary != NULL)
    {
        (void)unlink(files[count - 1].path);
    }
    for (size_t i = 0; i < count; i++)
    {
        if (!put_in_place(&files[i]))
        {
            return &files[i];
        }
        forget(&files[i]);
    }
    return NULL;
}

bool sim_output_commit(sim_output_file_t *files, size_t count, sim_error_t *error)
{
    const sim_output_file_t *failed = NULL;
    for (size_t i = 0; i < count && failed == NULL; i++)
    {
        failed = (files[i].stream == NULL || close_stream(&files[i])) ? NULL : &files[i];
    }
    if (failed == NULL)
    {
        sigset_t before;
        block_ending(&before);
        failed = put_all_in_place(files, count);
        (void)sigprocmask(SIG_SETMASK, &before, NULL);
    }
    if (failed != NULL)
    {
        const char *path = (failed->path != NULL) ? failed->path : "standard output";
        (void)sim_error_set(error, "%s: cannot be written: %s", path, strerror(errno));
    }
    sim_output_discard(files, count);
    return failed == NULL;
}

void sim_output_discard(sim_output_file_t *files, size_t count)
{
    for (size_t i = 0; i < count; i++)
    {
        if (files[i].stream != NULL && files[i].path != NULL)
        {
            (void)fclose(files[i].stream);
        }
        if (files[i].temporary != NULL)
        {
            (void)unlink(files[i].temporary);
        }
        forget(&files[i]);
    }
}

bool sim_output_flush(sim_error_t *error)
{
    sim_output_file_t file = {.stream = stdout};
    return sim_output_commit(&file, 1, error);
}

/// `path` and what is missing above it; it is the same again afterwards.
static bool make_folder(char *path)
{
    struct stat info;
    char       *slash = strrchr(path, '/');
    if (mkdir(path, 0777) == 0)
    {
        return true;
    }
    if (errno == ENOENT && slash != NULL && slash != path)
    {
        *slash          = '\0';
        const bool made = make_folder(path);
        *slash          = '/';
        return made && (slash[1] == '\0' || mkdir(path, 0777) == 0);
    }
    if (errno == EEXIST && stat(path, &info) == 0)
    {
        errno = ENOTDIR;
        return S_ISDIR(info.st_mode);
    }
    return false;
}

bool sim_output_folder_create(const char *path, sim_error_t *error)
{
    char      *copy = strdup(path);
    const bool made = copy != NULL && make_folder(copy);
    if (!made)
    {
        (void)sim_error_set(error, "%s: the folder cannot be made: %s", path, strerror(errno));
    }
    free(copy);
    return made;
}
