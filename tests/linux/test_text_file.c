// Numbers in files of sysfs: a whole one or none.

#include "text_file.h"

#include "unity.h"

#include <errno.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

static int interrupted; ///< number of reads and writes that a signal interrupts

// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp): names of ld --wrap
ssize_t __real_pread(int file, void *bytes, size_t size, off_t at);
ssize_t __wrap_pread(int file, void *bytes, size_t size, off_t at);
ssize_t __real_pwrite(int file, const void *bytes, size_t size, off_t at);
ssize_t __wrap_pwrite(int file, const void *bytes, size_t size, off_t at);

static bool interrupts(void)
{
    const bool now = interrupted > 0;
    interrupted -= now;
    errno = now ? EINTR : errno;
    return now;
}

ssize_t __wrap_pread(int file, void *bytes, size_t size, off_t at)
{
    return interrupts() ? -1 : __real_pread(file, bytes, size, at);
}

ssize_t __wrap_pwrite(int file, const void *bytes, size_t size, off_t at)
{
    return interrupts() ? -1 : __real_pwrite(file, bytes, size, at);
}

// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)

static char path[] = "/tmp/tribo_text_XXXXXX";
static int  file;

void setUp(void)
{
    (void)snprintf(path, sizeof path, "/tmp/tribo_text_XXXXXX");
    file = mkstemp(path);
    TEST_ASSERT_TRUE(file >= 0);
}

void tearDown(void)
{
    (void)close(file);
    (void)unlink(path);
}

static bool reads(const char *text, int64_t *number)
{
    TEST_ASSERT_EQUAL_INT(0, ftruncate(file, 0));
    TEST_ASSERT_EQUAL_INT((int)strlen(text), (int)pwrite(file, text, strlen(text), 0));
    errno = 0;
    return text_file_read(file, number);
}

static void test_whole_numbers_are_read(void)
{
    static const struct
    {
        const char *text;
        int64_t     number;
    } known[] = {{"13200\n", 13200},
                 {"0", 0},
                 {"-8388608\n", -8388608},
                 {"  7 \n", 7},
                 {"9223372036854775807\n", INT64_MAX}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
    {
        int64_t number = 1;
        TEST_ASSERT_TRUE(reads(known[i].text, &number));
        TEST_ASSERT_TRUE(number == known[i].number);
    }
}

static void test_half_a_number_is_not_a_number(void)
{
    static const char *const wrong[] =
        {"", "\n", "x", "1.5\n", "12x", "0x10", "9223372036854775808\n", "000000000000000000000000013200\n"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
    {
        int64_t number = 1;
        TEST_ASSERT_FALSE_MESSAGE(reads(wrong[i], &number), wrong[i]);
        TEST_ASSERT_TRUE(errno != 0);
    }
    int64_t number = 1;
    TEST_ASSERT_FALSE(text_file_read(-1, &number));
    TEST_ASSERT_EQUAL_INT(EBADF, errno);
}

/// A signal such as SIGWINCH interrupts a driver that waits, and must not stop the drive.
static void test_what_a_signal_interrupts_is_repeated(void)
{
    int64_t number = 1;
    TEST_ASSERT_TRUE(reads("-42\n", &number));
    interrupted = 3;
    TEST_ASSERT_TRUE(text_file_read(file, &number));
    TEST_ASSERT_EQUAL_INT64(-42, number);
    interrupted = 3;
    TEST_ASSERT_TRUE(text_file_write(file, 77));
    TEST_ASSERT_TRUE(text_file_read(file, &number));
    TEST_ASSERT_EQUAL_INT64(77, number);
}

/// Signals without end do not hold up the tick.
static void test_what_is_always_interrupted_fails(void)
{
    int64_t number = 1;
    interrupted    = 1000;
    TEST_ASSERT_FALSE(text_file_read(file, &number));
    TEST_ASSERT_EQUAL_INT(EINTR, errno);
    TEST_ASSERT_FALSE(text_file_write(file, 77));
    TEST_ASSERT_EQUAL_INT(EINTR, errno);
    interrupted = 0;
}

#include "runners/test_text_file.inc" // main
