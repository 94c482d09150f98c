#define _GNU_SOURCE // O_TMPFILE; NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)

#include "support/output_file.h"

#include "support/text.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// --- signals -------------------------------------------------------------------------------------------------------

// Global because a signal handler reads them.
static char *volatile pending[COMMON_OUTPUT_FILES_MAX];
static char *volatile made;         ///< the folder that was made for the files, until a commit; null: none
static size_t made_from = SIZE_MAX; ///< length of the shortest part of its path that was made

static const int ending[] = {SIGINT, SIGTERM, SIGHUP};

#define ENDING (sizeof ending / sizeof ending[0])

/// Removes the folders that were made for files that are not written, if they are empty.
static void remove_made(void)
{
    char *path = made;
    while (path != NULL && strlen(path) >= made_from)
    {
        (void)rmdir(path);
        char *slash                     = strrchr(path, '/');
        *(slash != NULL ? slash : path) = '\0';
    }
}

/// Keeps the folders. Also forgets those that have been removed.
static void forget_made(void)
{
    char *path = made;
    made       = NULL;
    made_from  = SIZE_MAX;
    free(path);
}

static void remove_pending(int number)
{
    for (size_t i = 0; i < COMMON_OUTPUT_FILES_MAX; i++)
    {
        if (pending[i] != NULL)
        {
            (void)unlink(pending[i]);
        }
    }
    remove_made();
    (void)signal(number, SIG_DFL);
    (void)raise(number);
}

void common_output_fill_descriptors(void)
{
    for (int i = STDIN_FILENO; i <= STDERR_FILENO; i++)
    {
        if (fcntl(i, F_GETFD) < 0)
        {
            (void)open("/dev/null", i == STDIN_FILENO ? O_WRONLY : O_RDONLY); // the lowest free number, which is i
        }
    }
}

void common_output_clean_on_signal(void)
{
    for (size_t i = 0; i < ENDING; i++)
    {
        // An ignored signal (nohup) stays ignored.
        if (signal(ending[i], remove_pending) == SIG_IGN)
        {
            (void)signal(ending[i], SIG_IGN);
        }
    }
}

/// Blocks the signals that end a run. `before` receives the previous mask.
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

/// Replaces `old` with `name` among the files that a signal removes.
static void replace_pending(const char *old, char *name)
{
    size_t i = 0;
    while (i < COMMON_OUTPUT_FILES_MAX && pending[i] != old)
    {
        i++;
    }
    if (i < COMMON_OUTPUT_FILES_MAX)
    {
        pending[i] = name;
    }
}

// --- opening -------------------------------------------------------------------------------------------------------

static void forget(common_output_file_t *file)
{
    if (file->temporary != NULL)
    {
        replace_pending(file->temporary, NULL);
    }
    free(file->path);
    free(file->temporary);
    *file = (common_output_file_t){.stream = NULL};
}

/// Opens a file without a name in the folder of file->path, so that nothing is left of a run that is killed.
static bool open_nameless(common_output_file_t *file, const char *slash)
{
#ifdef O_TMPFILE
    char *folder = slash != NULL ? common_text_format("%.*s", (int)(slash - file->path) + 1, file->path) : strdup(".");
    const bool can_be_named = access("/proc/self/fd", X_OK) == 0;
    const int  descriptor = folder != NULL && can_be_named ? open(folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666) : -1;
    free(folder);
    file->stream   = descriptor >= 0 ? fdopen(descriptor, "wb") : NULL;
    file->nameless = file->stream != NULL;
    if (descriptor >= 0 && !file->nameless)
    {
        (void)close(descriptor);
    }
#else
    (void)slash;
#endif
    return file->nameless;
}

/// Gives a nameless file a temporary name.
static bool give_name(common_output_file_t *file)
{
    const char *slash = strrchr(file->path, '/');
    const int   to    = slash != NULL ? (int)(slash - file->path) + 1 : 0;
    const int   from  = fileno(file->stream);
    char       *self  = common_text_format("/proc/self/fd/%d", from);
    char       *name  = common_text_format("%.*s.tribo.%ld.%d", to, file->path, (long)getpid(), from);
    bool        named = self != NULL && name != NULL;
    if (named)
    {
        (void)unlink(name); // a killed process with the same number may have left one
        named = linkat(AT_FDCWD, self, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0;
    }
    file->temporary = named ? name : NULL;
    const int cause = errno;
    free(named ? NULL : name);
    free(self);
    errno = cause;
    return named;
}

/// Opens a new file in the folder of file->path, under a name of its own, because the name in file->path may already have the
/// maximum length.
static bool open_next_to(common_output_file_t *file)
{
    const char *slash = strrchr(file->path, '/');
    if (open_nameless(file, slash))
    {
        return true;
    }
    file->temporary =
        common_text_format("%.*s.tribo.XXXXXX", slash != NULL ? (int)(slash - file->path) + 1 : 0, file->path);
    const int descriptor = (file->temporary != NULL) ? mkstemp(file->temporary) : -1;
    if (descriptor < 0)
    {
        const int cause = errno;
        free(file->temporary);
        file->temporary = NULL;
        errno           = cause;
        return false;
    }
    // Files of mkstemp are for their owner only; a result gets the mode of any new file.
    const mode_t mask = umask(0);
    (void)umask(mask);
    (void)fchmod(descriptor, 0666u & ~mask);
    replace_pending(NULL, file->temporary);
    file->stream = fdopen(descriptor, "wb");
    return file->stream != NULL;
}

/// Returns the final place of a file: `path`, or the target of a link, which stays a link.
static char *find_place(const char *path)
{
    struct stat info;
    const bool  is_link = lstat(path, &info) == 0 && S_ISLNK(info.st_mode);
    return is_link ? realpath(path, NULL) : strdup(path);
}

/// Opens a file to take the place of the old one, if there is one, with its mode and owner as far as user and file system allow.
static bool open_regular(common_output_file_t *file, const struct stat *old)
{
    const bool opened = open_next_to(file);
    if (opened && old != NULL)
    {
        (void)!fchown(fileno(file->stream), (uid_t)-1, old->st_gid); // a user may give a file to a group of theirs
        (void)!fchown(fileno(file->stream), old->st_uid, (gid_t)-1);
        (void)fchmod(fileno(file->stream), old->st_mode & 07777u);
    }
    return opened;
}

int common_output_descriptor(const char *path)
{
    static const char *const folders[] = {"/dev/fd/", "/proc/self/fd/"};
    static const char *const names[]   = {"/dev/stdin", "/dev/stdout", "/dev/stderr"};
    for (int i = 0; i < 3; i++)
    {
        if (strcmp(path, names[i]) == 0)
        {
            return i;
        }
    }
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++)
    {
        const size_t length = strlen(folders[i]);
        const char  *number = path + length;
        if (strncmp(path, folders[i], length) == 0 && *number != '\0' && strlen(number) < 6 &&
            strspn(number, "0123456789") == strlen(number))
        {
            return atoi(number); // NOLINT(cert-err34-c): up to five digits
        }
    }
    return -1;
}

/// Opens a copy of the descriptor, because opening its path would start at the beginning of a file that a shell appends to.
static bool open_descriptor(common_output_file_t *file, int descriptor)
{
    (void)fflush(stdout);
    const int copy = fcntl(descriptor, F_DUPFD_CLOEXEC, 3);
    file->stream   = copy >= 0 ? fdopen(copy, "wb") : NULL;
    if (copy >= 0 && file->stream == NULL)
    {
        (void)close(copy);
    }
    return file->stream != NULL;
}

/// Returns null, or the reason why an existing file must not be replaced. Permissions do not bind root, but a file without
/// any write permission is protected by somebody's intent.
static const char *why_protected(const char *path, const struct stat *info)
{
    return (info->st_mode & 0222u) == 0u ? "it is read-only" : access(path, W_OK) != 0 ? strerror(errno) : NULL;
}

/// Returns null, or the reason why the file cannot be opened.
static const char *open_place(common_output_file_t *file, const char *path)
{
    struct stat info;
    const bool  exists     = stat(path, &info) == 0;
    const int   descriptor = common_output_descriptor(path);
    if (descriptor >= 0)
    {
        file->path = strdup(path);
        return file->path != NULL && open_descriptor(file, descriptor) ? NULL : strerror(errno);
    }
    if (exists && !S_ISREG(info.st_mode))
    {
        // Write directly to a device or a pipe, because renaming a file over it would replace it.
        file->path   = strdup(path);
        file->stream = file->path != NULL ? fopen(path, "wb") : NULL;
        return file->stream != NULL ? NULL : strerror(errno);
    }
    const char *why = exists ? why_protected(path, &info) : NULL;
    if (why != NULL)
    {
        return why;
    }
    file->path = find_place(path);
    // No signal may arrive between the creation of a file and its registration.
    sigset_t before;
    block_ending(&before);
    const bool opened = file->path != NULL && open_regular(file, exists ? &info : NULL);
    const int  cause  = errno;
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
    return opened ? NULL : strerror(cause);
}

static bool complain(const char *path, const char *why, common_error_t *error)
{
    return common_error_set(error, "%s: cannot be written: %s", path, why);
}

bool common_output_open(common_output_file_t *file, const char *path, common_error_t *error)
{
    *file           = (common_output_file_t){.stream = path == NULL ? stdout : NULL};
    const char *why = path == NULL ? NULL : open_place(file, path);
    if (why != NULL)
    {
        (void)complain(path, why, error);
        common_output_discard(file, 1);
    }
    return why == NULL;
}

bool common_output_check(const char *path, common_error_t *error)
{
    struct stat          info;
    common_output_file_t file;
    if (path == NULL || common_output_descriptor(path) >= 0 ||
        (stat(path, &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode)))
    {
        return true; // opening a pipe would wait for its reader
    }
    const bool ok = common_output_open(&file, path, error);
    if (file.stream != NULL)
    {
        (void)fclose(file.stream);
        file.stream = NULL;
    }
    common_output_discard(&file, 1);
    return ok;
}

bool common_output_expect_none(common_output_file_t *file, const char *path, common_error_t *error)
{
    struct stat info;
    const bool  exists = stat(path, &info) == 0 && S_ISREG(info.st_mode);
    const char *why    = exists ? why_protected(path, &info) : NULL;
    *file              = (common_output_file_t){.path = strdup(path), .is_unwanted = true};
    return why != NULL          ? complain(path, why, error)
           : file->path == NULL ? common_error_set(error, "out of memory")
                                : true;
}

// --- closing -------------------------------------------------------------------------------------------------------

/// Writes out what the stream holds. Returns false with errno set if anything could not be written.
static bool flush(const common_output_file_t *file)
{
    // After a failed write the caller makes no other call, so errno is still valid.
    if (!ferror(file->stream) && fflush(file->stream) == 0)
    {
        return true;
    }
    errno = errno != 0 ? errno : EIO;
    return false;
}

/// Closes the stream; a nameless file gets its temporary name before.
static bool finish(common_output_file_t *file)
{
    if (file->nameless && !give_name(file))
    {
        return false;
    }
    FILE *const stream = file->stream;
    file->stream       = NULL;
    return file->path == NULL || fclose(stream) == 0;
}

static bool put_in_place(const common_output_file_t *file)
{
    struct stat info;
    if (file->is_unwanted)
    {
        return stat(file->path, &info) != 0 || !S_ISREG(info.st_mode) || unlink(file->path) == 0;
    }
    return file->temporary == NULL || rename(file->temporary, file->path) == 0;
}

/// Returns the first file that could not be closed or put in its place; null on success.
static const common_output_file_t *put_all_in_place(common_output_file_t *files, size_t count)
{
    for (size_t i = 0; i < count; i++)
    {
        if (files[i].stream != NULL && !finish(&files[i]))
        {
            return &files[i];
        }
    }
    const common_output_file_t *last = &files[count - 1];
    if (count > 1 && last->temporary != NULL)
    {
        (void)unlink(last->path);
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

bool common_output_commit(common_output_file_t *files, size_t count, common_error_t *error)
{
    const common_output_file_t *failed = NULL;
    for (size_t i = 0; i < count && failed == NULL; i++)
    {
        failed = (files[i].stream == NULL || flush(&files[i])) ? NULL : &files[i];
    }
    if (failed == NULL)
    {
        sigset_t before;
        block_ending(&before);
        failed = put_all_in_place(files, count);
        if (failed == NULL)
        {
            forget_made();
        }
        (void)sigprocmask(SIG_SETMASK, &before, NULL);
    }
    if (failed != NULL)
    {
        const char *path = (failed->path != NULL) ? failed->path : "standard output";
        (void)common_error_set(error, "%s: cannot be written: %s", path, strerror(errno));
    }
    common_output_discard(files, count);
    return failed == NULL;
}

void common_output_discard(common_output_file_t *files, size_t count)
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
    remove_made();
}

bool common_output_flush(common_error_t *error)
{
    common_output_file_t file = {.stream = stdout};
    return common_output_commit(&file, 1, error);
}

/// Creates `path` and its missing parents, and notes which were made. Changes `path` temporarily.
static bool make_folder(char *path)
{
    struct stat info;
    char       *slash = strrchr(path, '/');
    if (mkdir(path, 0777) == 0)
    {
        made_from = strlen(path) < made_from ? strlen(path) : made_from;
        return true;
    }
    if (errno == ENOENT && slash != NULL && slash != path)
    {
        *slash           = '\0';
        const bool is_in = make_folder(path);
        *slash           = '/';
        return is_in && (slash[1] == '\0' || mkdir(path, 0777) == 0);
    }
    if (errno == EEXIST && stat(path, &info) == 0)
    {
        errno = ENOTDIR;
        return S_ISDIR(info.st_mode);
    }
    return false;
}

bool common_output_folder_create(const char *path, common_error_t *error)
{
    sigset_t before;
    if (made != NULL && strcmp(made, path) == 0)
    {
        return true;
    }
    block_ending(&before);
    forget_made();
    made             = strdup(path);
    const bool is_in = made != NULL && make_folder(made);
    if (!is_in)
    {
        (void)common_error_set(error, "%s: the folder cannot be created: %s", path, strerror(errno));
        remove_made();
    }
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
    return is_in;
}

bool common_output_folder_temporary(char *path)
{
    sigset_t before;
    block_ending(&before);
    forget_made();
    made      = mkdtemp(path) != NULL ? strdup(path) : NULL;
    made_from = strlen(path);
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
    return made != NULL;
}
