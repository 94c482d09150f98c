#include "params_file.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define ERASED       0xffffffffu
#define REPLACED     0u
#define MARK_WORDS   2u ///< words of the mark at the beginning of a sector
#define SECTOR_BYTES (PARAMS_FILE_SECTOR_WORDS * sizeof(uint32_t))
#define PATH_LENGTH  1024

static off_t place_of(unsigned sector, uint32_t word)
{
    return (off_t)(sector * SECTOR_BYTES + word * sizeof word);
}

/// Reads a word. A file that ends early reads as erased from there on.
static uint32_t read_word(void *context, unsigned sector, uint32_t word)
{
    const params_file_t *store = context;
    uint32_t             value = ERASED;
    return pread(store->file, &value, sizeof value, place_of(sector, word)) == (ssize_t)sizeof value ? value : ERASED;
}

static bool erase(void *context, unsigned sector)
{
    const params_file_t *store = context;
    uint32_t             words[PARAMS_FILE_SECTOR_WORDS];
    memset(words, 0xff, sizeof words);
    // The kernel may write a sector's blocks in any order, so the mark "replaced" must be on the disk before a block is erased.
    return fdatasync(store->file) == 0 &&
           pwrite(store->file, words, sizeof words, place_of(sector, 0)) == (ssize_t)sizeof words &&
           fdatasync(store->file) == 0;
}

/// Writes a word. It only clears bits, as flash does. A mark waits until all earlier writes, including an earlier mark, are
/// on the disk.
static bool write_word(void *context, unsigned sector, uint32_t word, uint32_t value)
{
    const params_file_t *store   = context;
    const uint32_t       left    = read_word(context, sector, word) & value;
    const bool           is_mark = word < MARK_WORDS;
    return (!is_mark || fdatasync(store->file) == 0) &&
           pwrite(store->file, &left, sizeof left, place_of(sector, word)) == (ssize_t)sizeof left;
}

static bool can_be_mark(uint32_t word)
{
    return word == ERASED || word == STORE_CURRENT || word == REPLACED;
}

/// Checks that the file can be read, because a file that cannot be read must not count as one that was never saved.
static bool can_be_read(const params_file_t *store)
{
    uint32_t words[PARAMS_FILE_SECTOR_WORDS];
    bool     ok = true;
    for (unsigned sector = 0; ok && sector < STORE_SECTORS; sector++)
    {
        ok = pread(store->file, words, sizeof words, place_of(sector, 0)) >= 0;
    }
    return ok;
}

/// Returns true if the file is empty or begins with a mark, of which one word may have rotted.
static bool is_store(params_file_t *store)
{
    struct stat is;
    return fstat(store->file, &is) == 0 && S_ISREG(is.st_mode) && is.st_size <= place_of(STORE_SECTORS, 0) &&
           (can_be_mark(read_word(store, 0, 0)) || can_be_mark(read_word(store, 0, 1)));
}

/// Flushes the folder, so that a file that was just created is found again after the power fails.
static bool sync_folder(const char *path)
{
    char copy[PATH_LENGTH];
    (void)snprintf(copy, sizeof copy, "%s", path);
    const int  folder = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool ok     = folder >= 0 && fsync(folder) == 0;
    if (folder >= 0)
    {
        (void)close(folder);
    }
    return ok;
}

static bool fail(params_file_t *store, const char *path, const char *why, common_error_t *error)
{
    params_file_close(store);
    return common_error_set(error, "store: %s: %s", path, why);
}

bool params_file_open(params_file_t *store, const char *path, common_error_t *error)
{
    *store = (params_file_t){.file  = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0644),
                             .flash = {.context      = store,
                                       .sector_words = PARAMS_FILE_SECTOR_WORDS,
                                       .read         = read_word,
                                       .erase        = erase,
                                       .write        = write_word}};
    if (store->file < 0)
    {
        return fail(store, path, strerror(errno), error);
    }
    if (flock(store->file, LOCK_EX | LOCK_NB) != 0)
    {
        return fail(store, path, errno == EWOULDBLOCK ? "another drive has it" : strerror(errno), error);
    }
    if (!can_be_read(store))
    {
        return fail(store, path, strerror(errno), error);
    }
    if (!is_store(store))
    {
        return fail(store, path, "this is not a store of params", error);
    }
    return sync_folder(path) || fail(store, path, strerror(errno), error);
}

void params_file_close(params_file_t *store)
{
    if (store->file >= 0)
    {
        (void)close(store->file);
        store->file = -1;
    }
}
