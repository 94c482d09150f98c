#include "support/output_file.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// The one thing here that is not in a struct: what a signal handler has to know. A run writes two traces at a time.
static struct
{
    char                  name[4096];
    volatile sig_atomic_t is_pending;
} temporaries[2];

#define TEMPORARIES (sizeof temporaries / sizeof temporaries[0])

static void remove_pending(int number)
{
    for (size_t i = 0; i < TEMPORARIES; i++)
    {
        if (temporaries[i].is_pending)
        {
            (void)unlink(temporaries[i].name);
        }
    }
    (void)signal(number, SIG_DFL);
    (void)raise(number);
}

/// A name too long, or one too many, is not remembered.
static void remember(const char *name)
{
    for (size_t i = 0; i < TEMPORARIES && strlen(name) < sizeof temporaries[i].name; i++)
    {
        if (!temporaries[i].is_pending)
        {
            (void)snprintf(temporaries[i].name, sizeof temporaries[i].name, "%s", name);
            temporaries[i].is_pending = 1;
            return;
        }
    }
}

static const int ending[] = {SIGINT, SIGTERM, SIGHUP};

#define ENDING (sizeof ending / sizeof ending[0])

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

void sim_output_file_clean_on_signal(void)
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

static void forget(sim_output_file_t *file)
{
    for (size_t i = 0; i < TEMPORARIES && file->temporary != NULL; i++)
    {
        if (strcmp(temporaries[i].name, file->temporary) == 0)
        {
            temporaries[i].is_pending = 0;
        }
    }
    free(file->path);
    free(file->temporary);
    *file = (sim_output_file_t){0};
}

/// mkstemp makes files for their owner only; a result gets the mode that any new file would.
static int open_temporary(char *name)
{
    const int descriptor = mkstemp(name);
    if (descriptor >= 0)
    {
        const mode_t mask = umask(0);
        (void)umask(mask);
        (void)fchmod(descriptor, 0666u & ~mask);
    }
    return descriptor;
}

/// What the file is written to: `path`, or what it points to, so that a link stays one.
static char *find_target(const char *path)
{
    struct stat info;
    const bool  is_link = lstat(path, &info) == 0 && S_ISLNK(info.st_mode);
    return is_link ? realpath(path, NULL) : strdup(path);
}

static bool open_and_remember(sim_output_file_t *file)
{
    const size_t size = strlen(file->path) + sizeof ".XXXXXX";
    file->temporary   = malloc(size);
    if (file->temporary == NULL)
    {
        return false;
    }
    (void)snprintf(file->temporary, size, "%s.XXXXXX", file->path);
    const int descriptor = open_temporary(file->temporary);
    file->stream         = (descriptor >= 0) ? fdopen(descriptor, "wb") : NULL;
    if (file->stream == NULL)
    {
        const int cause = errno;
        if (descriptor >= 0)
        {
            (void)close(descriptor);
            (void)unlink(file->temporary);
        }
        errno = cause;
        return false;
    }
    remember(file->temporary);
    return true;
}

/// Opens a temporary file beside `file->path`. A signal must not come between its making and its being remembered.
static bool open_beside(sim_output_file_t *file)
{
    sigset_t before;
    block_ending(&before);
    const bool opened = open_and_remember(file);
    const int  cause  = errno;
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
    errno = cause;
    return opened;
}

static bool open_target(sim_output_file_t *file, const char *path)
{
    struct stat info;
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode))
    {
        // A device or a pipe is there to be written to; a file renamed over it would end it.
        file->path   = strdup(path);
        file->stream = (file->path != NULL) ? fopen(path, "wb") : NULL;
        return file->stream != NULL;
    }
    file->path = find_target(path);
    return file->path != NULL && open_beside(file);
}

bool sim_output_file_open(sim_output_file_t *file, const char *path, sim_error_t *error)
{
    *file = (sim_output_file_t){0};
    if (path == NULL)
    {
        file->stream = stdout;
        return true;
    }
    if (!open_target(file, path))
    {
        (void)sim_error_set(error, "%s: cannot be written: %s", path, strerror(errno));
        forget(file);
        return false;
    }
    return true;
}

bool sim_output_flush(sim_error_t *error)
{
    if (fflush(stdout) != 0 || ferror(stdout))
    {
        return sim_error_set(error, "standard output: cannot be written: %s", strerror(errno));
    }
    return true;
}

static void remove_temporary(const sim_output_file_t *file)
{
    if (file->temporary != NULL)
    {
        (void)unlink(file->temporary);
    }
}

bool sim_output_file_commit(sim_output_file_t *file, sim_error_t *error)
{
    if (file->path == NULL)
    {
        *file = (sim_output_file_t){0};
        return sim_output_flush(error);
    }
    // If a write has failed before, it is the caller's last act, and errno still says why.
    bool      ok  = !ferror(file->stream) && fflush(file->stream) == 0;
    int       why = errno;
    const int end = fclose(file->stream);
    if (ok && end != 0)
    {
        ok  = false;
        why = errno;
    }
    if (ok && file->temporary != NULL && rename(file->temporary, file->path) != 0)
    {
        ok  = false;
        why = errno;
    }
    if (!ok)
    {
        remove_temporary(file);
        (void)sim_error_set(error, "%s: cannot be written: %s", file->path, strerror(why != 0 ? why : EIO));
    }
    forget(file);
    return ok;
}

void sim_output_file_discard(sim_output_file_t *file)
{
    if (file->path != NULL)
    {
        (void)fclose(file->stream);
        remove_temporary(file);
    }
    forget(file);
}

bool sim_output_file_write_line(const char *path, const char *line, sim_error_t *error)
{
    sim_output_file_t file;
    if (!sim_output_file_open(&file, path, error))
    {
        return false;
    }
    // NOLINTNEXTLINE(clang-analyzer-unix.Stream,clang-analyzer-core.NonNullParamChecker): an open file has a stream
    (void)fprintf(file.stream, "%s\n", line);
    return sim_output_file_commit(&file, error);
}

bool sim_output_file_remove(const char *path, sim_error_t *error)
{
    struct stat info;
    if (stat(path, &info) == 0 && S_ISREG(info.st_mode) && unlink(path) != 0)
    {
        return sim_error_set(error, "%s: cannot be removed: %s", path, strerror(errno));
    }
    return true;
}

/// One folder; one that is there already is fine.
static bool create_one(const char *path)
{
    if (mkdir(path, 0777) == 0)
    {
        return true;
    }
    const int   cause = errno;
    struct stat info;
    if (stat(path, &info) == 0)
    {
        errno = ENOTDIR;
        return S_ISDIR(info.st_mode);
    }
    errno = cause;
    return false;
}

bool sim_output_folder_create(const char *path, sim_error_t *error)
{
    char *partial = strdup(path);
    if (partial == NULL)
    {
        return sim_error_set(error, "out of memory");
    }
    bool ok = partial[0] != '\0';
    errno   = ENOENT;
    for (char *p = partial + 1; ok && *p != '\0'; p++)
    {
        if (*p == '/')
        {
            *p = '\0';
            ok = create_one(partial);
            *p = '/';
        }
    }
    ok = ok && create_one(partial);
    if (!ok)
    {
        (void)sim_error_set(error, "%s: the folder cannot be made: %s", path, strerror(errno));
    }
    free(partial);
    return ok;
}
