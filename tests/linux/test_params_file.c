// The store in a file, and power that fails. The linker puts this file's pwrite and fdatasync in the place of the library's: they
// note what is written, and when it must be on the disk. A cut keeps all that was synchronised, and of the rest, which the kernel
// writes in any order, any part.

#include "params_file.h"

#include "unity.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define WORDS      40u
#define LAYOUT     7u
#define FILE_BYTES (2u * PARAMS_FILE_SECTOR_WORDS * sizeof(uint32_t))
#define WRITES_MAX 320u
#define SUBSETS    20u ///< tried at each point

static char path[] = "/tmp/tribo_params_XXXXXX";

typedef struct
{
    size_t  size, place;
    uint8_t bytes[PARAMS_FILE_SECTOR_WORDS * sizeof(uint32_t)];
} write_t;

static write_t writes[WRITES_MAX];
static size_t  write_count, syncs, synced[WRITES_MAX + 1u]; ///< writes before a sync
static bool    notes;
static int     fails_with; ///< errno
static bool    is_unreadable;
static off_t   unreadable_from;

// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp): names of ld --wrap
ssize_t __real_pread(int file, void *bytes, size_t size, off_t place);
ssize_t __wrap_pread(int file, void *bytes, size_t size, off_t place);
ssize_t __real_pwrite(int file, const void *bytes, size_t size, off_t place);
ssize_t __wrap_pwrite(int file, const void *bytes, size_t size, off_t place);
int     __real_fdatasync(int file);
int     __wrap_fdatasync(int file);

ssize_t __wrap_pread(int file, void *bytes, size_t size, off_t place)
{
    if (is_unreadable && place >= unreadable_from)
    {
        errno = EIO;
        return -1;
    }
    return __real_pread(file, bytes, size, place);
}

ssize_t __wrap_pwrite(int file, const void *bytes, size_t size, off_t place)
{
    if (fails_with != 0)
    {
        errno = fails_with;
        return -1;
    }
    if (notes)
    {
        TEST_ASSERT_TRUE(write_count < WRITES_MAX);
        write_t *noted = &writes[write_count++];
        *noted         = (write_t){.size = size, .place = (size_t)place};
        memcpy(noted->bytes, bytes, size);
    }
    return __real_pwrite(file, bytes, size, place);
}

int __wrap_fdatasync(int file)
{
    if (!notes)
    {
        return 0; // thousands of trials
    }
    TEST_ASSERT_TRUE(syncs < WRITES_MAX);
    synced[syncs++] = write_count;
    return __real_fdatasync(file);
}

/// Does nothing: fsync of the folder.
int __wrap_fsync(int file);
int __wrap_fsync(int file)
{
    (void)file;
    return 0;
}
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)

void setUp(void)
{
    (void)strcpy(path, "/tmp/tribo_params_XXXXXX");
    const int file = mkstemp(path);
    TEST_ASSERT_TRUE(file >= 0);
    (void)close(file);
    write_count = syncs = 0;
    notes               = false;
    fails_with          = 0;
}

void tearDown(void)
{
    (void)unlink(path);
}

static void open_store(params_file_t *store)
{
    common_error_t error = {""};
    if (!params_file_open(store, path, &error))
    {
        TEST_FAIL_MESSAGE(error.text);
    }
}

static void fill(uint32_t words[WORDS], uint32_t seed)
{
    for (uint32_t i = 0; i < WORDS; i++)
    {
        words[i] = seed * 2654435761u + i * 40503u;
    }
}

static size_t read_file(uint8_t bytes[FILE_BYTES])
{
    const int file = open(path, O_RDONLY);
    TEST_ASSERT_TRUE(file >= 0);
    const ssize_t size = read(file, bytes, FILE_BYTES);
    (void)close(file);
    TEST_ASSERT_TRUE(size >= 0);
    return (size_t)size;
}

static void write_file(const uint8_t *bytes, size_t size)
{
    const int file = open(path, O_WRONLY);
    TEST_ASSERT_TRUE(file >= 0);
    TEST_ASSERT_EQUAL_INT64((int64_t)size, write(file, bytes, size));
    TEST_ASSERT_EQUAL_INT(0, ftruncate(file, (off_t)size));
    (void)close(file);
}

static void test_a_set_is_read_back(void)
{
    params_file_t store;
    uint32_t      set[WORDS];
    uint32_t      found[WORDS];
    open_store(&store);
    TEST_ASSERT_EQUAL(STORE_EMPTY, store_read(&store.flash, LAYOUT, found, WORDS));
    for (uint32_t i = 1; i <= 5u; i++)
    {
        fill(set, i);
        TEST_ASSERT_EQUAL(STORE_OK, store_write(&store.flash, LAYOUT, set, WORDS));
        params_file_close(&store);
        open_store(&store);
        TEST_ASSERT_EQUAL(STORE_OK, store_read(&store.flash, LAYOUT, found, WORDS));
        TEST_ASSERT_EQUAL_HEX32_ARRAY(set, found, WORDS);
    }
    params_file_close(&store);
}

static void put(uint8_t bytes[FILE_BYTES], size_t *size, const write_t *one)
{
    if (one->place > *size)
    {
        memset(bytes + *size, 0, one->place - *size); // a hole
    }
    memcpy(bytes + one->place, one->bytes, one->size);
    *size = one->place + one->size > *size ? one->place + one->size : *size;
}

/// Power fails after `count` writes, before a sync that follows them or after it. Which of those not synchronised arrived is
/// chosen by `seed`; 0: none, 1: all.
static void cut(const uint8_t *before, size_t before_size, size_t count, bool after_sync, unsigned seed)
{
    uint8_t bytes[FILE_BYTES];
    size_t  size = before_size;
    size_t  safe = 0;
    for (size_t i = 0; i < syncs && (after_sync ? synced[i] <= count : synced[i] < count); i++)
    {
        safe = synced[i];
    }
    memcpy(bytes, before, before_size);
    uint32_t random = seed;
    for (size_t i = 0; i < count; i++)
    {
        random             = random * 1664525u + 1013904223u;
        const bool arrives = i < safe || (seed > 0u && (seed == 1u || random >> 31 == 0u));
        if (arrives)
        {
            put(bytes, &size, &writes[i]);
        }
    }
    write_file(bytes, size);
}

/// The next save of `set`, cut at every write; `old` null: nothing was saved before. The file is left as after the whole save.
static unsigned cut_everywhere(const uint32_t *old, const uint32_t set[WORDS])
{
    params_file_t store;
    uint8_t       before[FILE_BYTES];
    uint8_t       after[FILE_BYTES];
    uint32_t      found[WORDS];
    unsigned      news        = 0;
    const size_t  before_size = read_file(before);
    write_count = syncs = 0;
    notes               = true;
    open_store(&store);
    TEST_ASSERT_EQUAL(STORE_OK, store_write(&store.flash, LAYOUT, set, WORDS));
    notes = false;
    params_file_close(&store);
    const size_t after_size = read_file(after);
    for (size_t count = 0; count <= write_count; count++)
    {
        for (unsigned trial = 0; trial < 2u * SUBSETS; trial++)
        {
            const bool after_sync = trial % 2u != 0u;
            cut(before, before_size, count, after_sync, trial / 2u);
            open_store(&store);
            const store_status_t status = store_read(&store.flash, LAYOUT, found, WORDS);
            const bool           is_new = status == STORE_OK && memcmp(found, set, sizeof found) == 0;
            const bool           is_old =
                old == NULL ? status == STORE_EMPTY : status == STORE_OK && memcmp(found, old, sizeof found) == 0;
            TEST_ASSERT_TRUE(is_new || is_old);
            TEST_ASSERT_TRUE(is_new || count < write_count || !after_sync);
            news += is_new;
            // And the store can be written again.
            TEST_ASSERT_EQUAL(STORE_OK, store_write(&store.flash, LAYOUT, set, WORDS));
            params_file_close(&store);
        }
    }
    write_file(after, after_size);
    return news;
}

static void test_a_cut_leaves_the_old_set_or_the_new_one(void)
{
    uint32_t sets[4][WORDS];
    for (uint32_t i = 0; i < 4u; i++)
    {
        fill(sets[i], i + 1u);
        const unsigned news = cut_everywhere(i > 0u ? sets[i - 1u] : NULL, sets[i]);
        TEST_ASSERT_TRUE(news >= SUBSETS); // those of the last cut
    }
}

#define BLOCK_BYTES 512u ///< of a disk: a write of more may arrive in part

/// A save, cut after `count` writes, of which those behind the last sync have arrived block by block, as `random` has it.
static void cut_blocks(const uint8_t *before, size_t before_size, size_t count, uint32_t *random)
{
    uint8_t bytes[FILE_BYTES];
    size_t  size = before_size;
    size_t  safe = 0;
    for (size_t i = 0; i < syncs && synced[i] <= count; i++)
    {
        // A sync that comes right behind the last write may not have been reached.
        const bool reached = synced[i] < count || (*random >> 13 & 1u) != 0u;
        safe               = reached ? synced[i] : safe;
    }
    memcpy(bytes, before, before_size);
    for (size_t i = 0; i < count; i++)
    {
        for (size_t from = 0; from < writes[i].size; from += BLOCK_BYTES)
        {
            *random            = *random * 1664525u + 1013904223u;
            const size_t left  = writes[i].size - from;
            write_t      block = {.size = left < BLOCK_BYTES ? left : BLOCK_BYTES, .place = writes[i].place + from};
            memcpy(block.bytes, writes[i].bytes + from, block.size);
            if (i < safe || *random >> 31 == 0u)
            {
                put(bytes, &size, &block);
            }
        }
    }
    write_file(bytes, size);
}

#define LONG_WORDS 140u ///< a record across more than one block
#define CUTS       10000u

/// Cuts the second save of a run, reordered by blocks. The first one may not have arrived whole either.
static void test_10000_reordered_cuts_find_no_damage(void)
{
    static uint32_t sets[3][LONG_WORDS];
    static uint32_t found[LONG_WORDS];
    uint8_t         before[FILE_BYTES];
    params_file_t   store;
    uint32_t        random  = 1; // the seed
    unsigned        damaged = 0;
    unsigned        news    = 0;
    size_t          size    = 0;
    size_t          first   = 0; ///< writes of the first save
    open_store(&store);
    for (uint32_t i = 0; i < 3u; i++)
    {
        for (uint32_t k = 0; k < LONG_WORDS; k++)
        {
            sets[i][k] = (i + 1u) * 2654435761u + k * 40503u;
        }
        first = write_count;
        TEST_ASSERT_EQUAL(STORE_OK, store_write(&store.flash, LAYOUT, sets[i], LONG_WORDS));
        size  = i == 0u ? read_file(before) : size;
        notes = true;
    }
    notes = false;
    params_file_close(&store);
    for (unsigned trial = 0; trial < CUTS; trial++)
    {
        // Half of them where sectors are marked and erased, not among the words of the record.
        random             = random * 1664525u + 1013904223u;
        const size_t pick  = random >> 8;
        const size_t near  = pick % 12u;
        const size_t count = trial % 2u == 0u ? first + pick % (write_count - first + 1u)
                             : near < 6u      ? first + near
                                              : write_count - (near - 6u);
        cut_blocks(before, size, count, &random);
        open_store(&store);
        const store_status_t status = store_read(&store.flash, LAYOUT, found, LONG_WORDS);
        const bool           is_new = status == STORE_OK && memcmp(found, sets[2], sizeof found) == 0;
        const bool           is_old = status == STORE_OK && memcmp(found, sets[1], sizeof found) == 0;
        params_file_close(&store);
        TEST_ASSERT_TRUE(is_new || is_old || status == STORE_DAMAGED);
        damaged += status == STORE_DAMAGED;
        news += is_new;
    }
    TEST_ASSERT_EQUAL_UINT(0, damaged);
    TEST_ASSERT_GREATER_THAN_UINT(CUTS / 100u, news);
    TEST_ASSERT_LESS_THAN_UINT(CUTS, news);
}

static void test_a_save_of_what_is_saved_writes_nothing(void)
{
    params_file_t store;
    uint32_t      set[WORDS];
    fill(set, 1);
    open_store(&store);
    TEST_ASSERT_EQUAL(STORE_OK, store_write(&store.flash, LAYOUT, set, WORDS));
    notes = true;
    TEST_ASSERT_EQUAL(STORE_OK, store_write(&store.flash, LAYOUT, set, WORDS));
    notes = false;
    TEST_ASSERT_EQUAL_UINT(0, write_count);
    params_file_close(&store);
}

static void test_a_file_that_takes_nothing_keeps_its_set(void)
{
    params_file_t store;
    uint32_t      set[WORDS];
    uint32_t      other[WORDS];
    uint32_t      found[WORDS];
    fill(set, 1);
    fill(other, 2);
    open_store(&store);
    TEST_ASSERT_EQUAL(STORE_OK, store_write(&store.flash, LAYOUT, set, WORDS));
    fails_with = ENOSPC;
    TEST_ASSERT_EQUAL(STORE_FAILED, store_write(&store.flash, LAYOUT, other, WORDS));
    fails_with = 0;
    TEST_ASSERT_EQUAL(STORE_OK, store_read(&store.flash, LAYOUT, found, WORDS));
    TEST_ASSERT_EQUAL_HEX32_ARRAY(set, found, WORDS);
    params_file_close(&store);
}

static void test_a_mark_may_rot(void)
{
    params_file_t store;
    uint32_t      set[WORDS];
    uint32_t      found[WORDS];
    uint8_t       bytes[FILE_BYTES];
    fill(set, 1);
    open_store(&store);
    TEST_ASSERT_EQUAL(STORE_OK, store_write(&store.flash, LAYOUT, set, WORDS));
    params_file_close(&store);
    const size_t size = read_file(bytes);
    bytes[0] ^= 1u;
    write_file(bytes, size);
    open_store(&store);
    TEST_ASSERT_EQUAL(STORE_OK, store_read(&store.flash, LAYOUT, found, WORDS));
    params_file_close(&store);
}

static void test_a_file_that_is_not_a_store_is_refused(void)
{
    static const uint8_t text[2][FILE_BYTES + 1u] = {"scenario: loop.yaml\n", {0xff, 0xff, 0xff, 0xff}};
    const size_t         sizes[2]                 = {20, sizeof text[1]};
    for (size_t i = 0; i < 2u; i++)
    {
        params_file_t  store;
        common_error_t error = {""};
        write_file(text[i], sizes[i]);
        TEST_ASSERT_FALSE(params_file_open(&store, path, &error));
        TEST_ASSERT_NOT_NULL(strstr(error.text, "this is not a store of params"));
        struct stat is;
        TEST_ASSERT_EQUAL_INT(0, stat(path, &is));
        TEST_ASSERT_EQUAL_INT64((int64_t)sizes[i], is.st_size);
    }
}

/// Whichever sector it is: what was saved there is not what was never saved.
static void test_a_store_that_cannot_be_read_is_not_empty(void)
{
    for (unsigned sector = 0; sector < 2u; sector++)
    {
        params_file_t  store;
        common_error_t error = {""};
        char           message[128];
        is_unreadable   = true;
        unreadable_from = (off_t)(sector * FILE_BYTES / 2u);
        const bool ok   = params_file_open(&store, path, &error);
        is_unreadable   = false;
        (void)snprintf(message, sizeof message, "store: %s: Input/output error", path);
        TEST_ASSERT_FALSE(ok);
        TEST_ASSERT_EQUAL_STRING(message, error.text);
    }
}

#include "runners/test_params_file.inc" // main
