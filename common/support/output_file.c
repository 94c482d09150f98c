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
#ifdef __linux__
#include <sys/xattr.h>
#endif
#include <unistd.h>

// --- signals -------------------------------------------------------------------------------------------------------

// Global because a signal handler reads them.
static char *volatile pending[COMMON_OUTPUT_FILES_MAX];
static char *volatile made;         ///< the folder that was made for the files, until a commit; null: none
static size_t made_from = SIZE_MAX; ///< length of the shortest part of its path that was made

static const int ending[] = {SIGINT, SIGTERM, SIGHUP};

#define ENDING (sizeof ending / sizeof ending[0])

#define NAMES_SIZE 4096u  ///< of a file's extended attributes; more count as attributes to keep
#define COPY_SIZE  65536u ///< bytes copied at a time

/// Removes the folders that were made for files that do not come, if they are empty.
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
    if (file->is_kept)
    {
        (void)close(file->kept);
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
    const int  descriptor   = folder != NULL && can_be_named ? open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0666) : -1;
    free(folder);
    file->stream   = descriptor >= 0 ? fdopen(descriptor, "w+b") : NULL;
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
    file->temporary   = common_text_format("%.*s.tribo.%ld.%d", to, file->path, (long)getpid(), from);
    bool named        = self != NULL && file->temporary != NULL;
    if (named)
    {
        (void)unlink(file->temporary); // a killed process with the same number may have left one
        sigset_t before;
        block_ending(&before);
        named           = linkat(AT_FDCWD, self, AT_FDCWD, file->temporary, AT_SYMLINK_FOLLOW) == 0;
        const int cause = errno;
        if (named)
        {
            replace_pending(NULL, file->temporary);
        }
        (void)sigprocmask(SIG_SETMASK, &before, NULL);
        errno = cause;
    }
    free(self);
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

/// Returns the descriptor that a path such as /dev/stdout names; -1 if it names none.
static int descriptor_of(const char *path)
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

/// Returns true if the file has attributes that a new file would not get: an access control list or the user's own.
static bool has_attributes(const char *path)
{
#ifdef __linux__
    char          names[NAMES_SIZE];
    const ssize_t length = listxattr(path, names, sizeof names);
    for (const char *name = names; length > 0 && name < names + length; name += strlen(name) + 1)
    {
        if (strncmp(name, "security.", 9) != 0) // a new file gets the label of its folder
        {
            return true;
        }
    }
    return length < 0 && errno == ERANGE;
#else
    (void)path;
    return false;
#endif
}

/// Returns true if a new file in its place would lose more than the mode.
static bool must_be_kept(const char *path, const struct stat *info)
{
    return info->st_nlink > 1 || info->st_uid != geteuid() || info->st_gid != getegid() || has_attributes(path);
}

/// Opens the existing file, which gets its new content at the commit, and a nameless file for the content until then.
static bool open_kept(common_output_file_t *file)
{
    file->kept    = open(file->path, O_WRONLY | O_CLOEXEC);
    file->is_kept = file->kept >= 0;
    if (!file->is_kept)
    {
        return false;
    }
    if (!open_nameless(file, strrchr(file->path, '/')))
    {
        file->stream = tmpfile();
    }
    file->nameless = false;
    return file->stream != NULL;
}

static bool open_regular(common_output_file_t *file, const struct stat *old)
{
    if (old != NULL && must_be_kept(file->path, old))
    {
        return open_kept(file);
    }
    if (open_next_to(file))
    {
        return old == NULL || fchmod(fileno(file->stream), old->st_mode & 07777u) == 0;
    }
    const int  cause = errno;
    const bool is_kept =
        old != NULL && (cause == EACCES || cause == EROFS || cause == EPERM) && access(file->path, W_OK) == 0;
    errno = cause;
    return is_kept && open_kept(file);
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
    const int   descriptor = descriptor_of(path);
    if (descriptor >= 0 || (exists && !S_ISREG(info.st_mode)))
    {
        // Write directly to a device or a pipe, because renaming a file over it would replace it.
        file->path   = strdup(path);
        file->stream = descriptor >= 0 || file->path == NULL ? NULL : fopen(path, "wb");
        return file->stream != NULL || (descriptor >= 0 && file->path != NULL && open_descriptor(file, descriptor))
                   ? NULL
                   : strerror(errno);
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
    *file           = (common_output_file_t){.stream = (path == NULL) ? stdout : NULL};
    const char *why = (path == NULL) ? NULL : open_place(file, path);
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
    if (path == NULL || descriptor_of(path) >= 0 ||
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

/// Closes the stream. Returns false with errno set if anything could not be written.
static bool close_stream(common_output_file_t *file)
{
    // After a failed write the caller makes no other call, so errno is still valid.
    bool      ok  = !ferror(file->stream) && fflush(file->stream) == 0 && (!file->nameless || give_name(file));
    const int why = errno;
    if (file->is_kept)
    {
        errno = (why != 0) ? why : EIO;
        return ok; // the commit copies from the stream
    }
    if (file->path != NULL && fclose(file->stream) != 0 && ok)
    {
        file->stream = NULL;
        return false;
    }
    file->stream = NULL;
    errno        = (why != 0) ? why : EIO;
    return ok;
}

/// Copies the new content into the existing file. A disk without room for it leaves the old content.
static bool copy_to_kept(const common_output_file_t *file)
{
    static char buffer[COPY_SIZE];
    struct stat old, new;
    const int   from = fileno(file->stream);
    if (fstat(file->kept, &old) != 0 || fstat(from, &new) != 0)
    {
        return false;
    }
    const int full = new.st_size > 0 ? posix_fallocate(file->kept, 0, new.st_size) : 0;
    if (full != 0 && full != EOPNOTSUPP && full != EINVAL)
    {
        (void)!ftruncate(file->kept, old.st_size);
        errno = full;
        return false;
    }
    for (off_t done = 0; done < new.st_size;)
    {
        const ssize_t count = pread(from, buffer, sizeof buffer, done);
        if (count <= 0 || pwrite(file->kept, buffer, (size_t)count, done) != count)
        {
            return false;
        }
        done += count;
    }
    return ftruncate(file->kept, new.st_size) == 0;
}

static bool put_in_place(const common_output_file_t *file)
{
    struct stat info;
    if (file->is_kept)
    {
        return copy_to_kept(file);
    }
    if (file->is_unwanted)
    {
        return stat(file->path, &info) != 0 || !S_ISREG(info.st_mode) || unlink(file->path) == 0;
    }
    return file->temporary == NULL || rename(file->temporary, file->path) == 0;
}

/// Returns the first file that could not be put in its place; null on success.
static const common_output_file_t *put_all_in_place(common_output_file_t *files, size_t count)
{
    const common_output_file_t *last = &files[count - 1];
    if (count > 1 && last->temporary != NULL)
    {
        (void)unlink(last->path);
    }
    if (count > 1 && last->is_kept && ftruncate(last->kept, 0) != 0)
    {
        return last;
    }
    for (size_t i = 0; i < count; i++)
    {
        if (!put_in_place(&files[i]))
        {
            return &files[i];
        }
        if (files[i].is_kept)
        {
            (void)fclose(files[i].stream);
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
        failed = (files[i].stream == NULL || close_stream(&files[i])) ? NULL : &files[i];
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
