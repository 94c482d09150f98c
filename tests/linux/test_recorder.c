// The log: all rows, in order, or counted as dropped; and the tick never waits for a disk that does not take them.

#include "recorder.h"

#include "realtime.h"
#include "unity.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

static char           path[64];
static recorder_t    *recorder;
static common_error_t error;
static uint64_t       written, dropped;

void setUp(void)
{
    (void)snprintf(path, sizeof path, "/tmp/tribo-recorder-%d", (int)getpid());
    error   = (common_error_t){""};
    written = dropped = 0;
}

void tearDown(void)
{
    (void)unlink(path);
}

static void start(void)
{
    recorder = recorder_start(path, &error);
    TEST_ASSERT_NOT_NULL(recorder);
    TEST_ASSERT_TRUE(recorder_open(recorder, &error));
}

static void refuse(const char *place)
{
    common_error_t unused = {""};
    recorder              = recorder_start(place, &error);
    TEST_ASSERT_NOT_NULL(recorder);
    TEST_ASSERT_FALSE(recorder_open(recorder, &error));
    (void)recorder_stop(recorder, &written, &dropped, &unused);
    TEST_ASSERT_EQUAL_UINT64(0, written);
}

static void add(unsigned number)
{
    recorder_add(recorder, &(recorder_row_t){.t_s = number * 1e-3, .r_n = (float)number, .fault = 7});
}

static void add_up_to(unsigned end)
{
    for (unsigned i = 0; i < end; i++)
    {
        add(i);
    }
}

/// Rows of the file, each whole, later than the one before, and below `end`: with `end` rows none is missing.
static unsigned rows_in_order(FILE *file, unsigned end)
{
    char     line[256];
    unsigned rows = 0;
    unsigned next = 0;
    TEST_ASSERT_NOT_NULL(fgets(line, sizeof line, file));
    TEST_ASSERT_EQUAL_STRING("t_s,r_N,F_N,u_N,state,fault,limits,late_us,step_us\n", line);
    while (fgets(line, sizeof line, file) != NULL)
    {
        const char    *r      = strchr(line, ',');
        const unsigned number = r != NULL ? (unsigned)strtoul(r + 1, NULL, 10) : 0;
        char           expected[64];
        (void)snprintf(expected, sizeof expected, "%.6f,%u,0,0,0,7,0,0.0,0.0\n", number * 1e-3, number);
        TEST_ASSERT_EQUAL_STRING(expected, line);
        TEST_ASSERT_TRUE(number >= next && number < end);
        next = number + 1u;
        rows++;
    }
    return rows;
}

/// All rows that the recorder says it has written, which are of those below `end`, are there.
static void check_file(unsigned end)
{
    FILE *file = fopen(path, "r");
    TEST_ASSERT_NOT_NULL(file);
    TEST_ASSERT_EQUAL_UINT(written, rows_in_order(file, end));
    (void)fclose(file);
}

static void test_all_rows_come_in_order(void)
{
    start();
    add_up_to(RECORDER_ROWS);
    TEST_ASSERT_TRUE(recorder_stop(recorder, &written, &dropped, &error));
    TEST_ASSERT_EQUAL_UINT64(RECORDER_ROWS, written);
    TEST_ASSERT_EQUAL_UINT64(0, dropped);
    check_file(RECORDER_ROWS);
}

static void *count_rows(void *file)
{
    static unsigned rows;
    rows = rows_in_order(file, 2u * RECORDER_ROWS);
    return &rows;
}

/// A FIFO that nobody reads from stands for the disk.
static void test_a_disk_that_stalls_costs_rows_not_time(void)
{
    const unsigned added = 2u * RECORDER_ROWS;
    pthread_t      reader;
    void          *rows = NULL;
    TEST_ASSERT_EQUAL_INT(0, mkfifo(path, 0600));
    const int end = open(path, O_RDONLY | O_NONBLOCK);
    TEST_ASSERT_TRUE(end >= 0);
    TEST_ASSERT_EQUAL_INT(0, fcntl(end, F_SETFL, 0));
    start();
    const int64_t start_ns = realtime_now_ns();
    add_up_to(added);
    TEST_ASSERT_TRUE(realtime_now_ns() - start_ns < INT64_C(2000000000)); // it would be for ever
    FILE *file = fdopen(end, "r");
    TEST_ASSERT_EQUAL_INT(0, pthread_create(&reader, NULL, count_rows, file));
    TEST_ASSERT_TRUE(recorder_stop(recorder, &written, &dropped, &error));
    TEST_ASSERT_EQUAL_INT(0, pthread_join(reader, &rows));
    (void)fclose(file);
    TEST_ASSERT_EQUAL_UINT64(written, *(unsigned *)rows);
    TEST_ASSERT_EQUAL_UINT64(added, written + dropped);
    TEST_ASSERT_TRUE(dropped > 0);
}

/// It has a reader that has stopped to read. That this returns is the test.
static void test_an_unread_pipe_does_not_delay_the_end(void)
{
    TEST_ASSERT_EQUAL_INT(0, mkfifo(path, 0600));
    const int end = open(path, O_RDONLY | O_NONBLOCK);
    start();
    add_up_to(RECORDER_ROWS);
    TEST_ASSERT_FALSE(recorder_stop(recorder, &written, &dropped, &error));
    TEST_ASSERT_EQUAL_STRING("--log: Connection timed out", error.text);
    TEST_ASSERT_EQUAL_UINT64(RECORDER_ROWS, written + dropped);
    TEST_ASSERT_TRUE(dropped > 0);
    (void)close(end);
}

/// So does a pipe that the program was started with: its writes wait for no reader either.
static void test_an_unread_pipe_of_a_descriptor_does_not_delay_the_end(void)
{
    int ends[2];
    TEST_ASSERT_EQUAL_INT(0, pipe(ends));
    (void)snprintf(path, sizeof path, "/dev/fd/%d", ends[1]);
    start();
    add_up_to(RECORDER_ROWS);
    TEST_ASSERT_FALSE(recorder_stop(recorder, &written, &dropped, &error));
    TEST_ASSERT_EQUAL_STRING("--log: Connection timed out", error.text);
    TEST_ASSERT_TRUE(dropped > 0);
    TEST_ASSERT_EQUAL_INT(0, fcntl(ends[1], F_GETFL) & O_NONBLOCK); // whoever else has the pipe is left alone
    (void)close(ends[0]);
    (void)close(ends[1]);
}

static void test_a_socket_takes_the_rows(void)
{
    int ends[2];
    TEST_ASSERT_EQUAL_INT(0, socketpair(AF_UNIX, SOCK_STREAM, 0, ends));
    (void)snprintf(path, sizeof path, "/proc/self/fd/%d", ends[1]);
    start();
    add_up_to(10);
    TEST_ASSERT_TRUE(recorder_stop(recorder, &written, &dropped, &error));
    (void)close(ends[1]);
    FILE *file = fdopen(ends[0], "r");
    TEST_ASSERT_NOT_NULL(file);
    TEST_ASSERT_EQUAL_UINT(10, rows_in_order(file, 10));
    (void)fclose(file);
}

static void *read_slowly(void *context)
{
    const int *end = context;
    char       bytes[4096];
    size_t     length = 0;
    ssize_t    count  = 0;
    while ((count = read(*end, bytes, sizeof bytes)) > 0)
    {
        length += (size_t)count;
        (void)realtime_sleep_until(realtime_now_ns() + INT64_C(200000000));
    }
    static unsigned all;
    all = (unsigned)length;
    return &all;
}

/// Slower than any one wait, but it reads on.
static void test_a_slow_reader_gets_the_whole_output(void)
{
    pthread_t reader;
    void     *length = NULL;
    TEST_ASSERT_EQUAL_INT(0, mkfifo(path, 0600));
    int end = open(path, O_RDONLY | O_NONBLOCK);
    TEST_ASSERT_EQUAL_INT(0, fcntl(end, F_SETFL, 0));
    TEST_ASSERT_EQUAL_INT(4096, fcntl(end, F_SETPIPE_SZ, 4096));
    start();
    TEST_ASSERT_EQUAL_INT(0, pthread_create(&reader, NULL, read_slowly, &end));
    add_up_to(2000u);
    TEST_ASSERT_TRUE(recorder_stop(recorder, &written, &dropped, &error));
    TEST_ASSERT_EQUAL_UINT64(2000, written);
    TEST_ASSERT_EQUAL_INT(0, pthread_join(reader, &length));
    TEST_ASSERT_TRUE(*(unsigned *)length > 2000u * 20u);
    (void)close(end);
}

static void test_a_pipe_without_a_reader_is_refused(void)
{
    char message[128];
    TEST_ASSERT_EQUAL_INT(0, mkfifo(path, 0600));
    refuse(path);
    (void)snprintf(message, sizeof message, "--log %s: this pipe has no reader", path);
    TEST_ASSERT_EQUAL_STRING(message, error.text);
}

static void test_a_disk_without_room_for_the_head_is_reported(void)
{
    refuse("/dev/full");
    TEST_ASSERT_EQUAL_STRING("--log /dev/full: No space left on device", error.text);
}

/// A limit on the size of files stands for the disk's end: a write that crosses it is cut, the next one fails.
static void limit_files(rlim_t bytes)
{
    struct rlimit limit;
    TEST_ASSERT_EQUAL_INT(0, getrlimit(RLIMIT_FSIZE, &limit));
    limit.rlim_cur = bytes;
    TEST_ASSERT_EQUAL_INT(0, setrlimit(RLIMIT_FSIZE, &limit));
}

/// Standard error, until it says so; at most 20 s.
static void wait_until_said(int end, const char *what)
{
    char   said[1024] = "";
    size_t length     = 0;
    for (int i = 0; i < 2000 && strstr(said, what) == NULL; i++)
    {
        const ssize_t count = read(end, said + length, sizeof said - 1u - length);
        length += count > 0 ? (size_t)count : 0u;
        said[length] = '\0';
        (void)realtime_sleep_until(realtime_now_ns() + INT64_C(10000000));
    }
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, what), said);
}

static void test_a_full_disk_is_reported_at_its_start_and_at_its_end(void)
{
    int ends[2];
    (void)signal(SIGXFSZ, SIG_IGN);
    TEST_ASSERT_EQUAL_INT(0, pipe(ends));
    TEST_ASSERT_EQUAL_INT(0, fcntl(ends[0], F_SETFL, O_NONBLOCK));
    const int kept = dup(STDERR_FILENO);
    (void)dup2(ends[1], STDERR_FILENO);
    limit_files(1000);
    start();
    add_up_to(100);
    wait_until_said(ends[0], "File too large; the drive goes on\n");
    add(100);
    limit_files(RLIM_INFINITY);
    wait_until_said(ends[0], "rows are written again; the drive goes on\n");
    const bool ok = recorder_stop(recorder, &written, &dropped, &error);
    (void)dup2(kept, STDERR_FILENO);
    (void)close(kept);
    (void)close(ends[0]);
    (void)close(ends[1]);
    TEST_ASSERT_FALSE(ok);
    TEST_ASSERT_EQUAL_STRING("--log: File too large", error.text);
    TEST_ASSERT_EQUAL_UINT64(101, written);
    TEST_ASSERT_EQUAL_UINT64(0, dropped);
    check_file(101);
}

static void test_a_full_disk_loses_only_the_rows_it_did_not_take(void)
{
    (void)signal(SIGXFSZ, SIG_IGN);
    limit_files(1000);
    start();
    add_up_to(RECORDER_ROWS + 10u);
    const bool ok = recorder_stop(recorder, &written, &dropped, &error);
    limit_files(RLIM_INFINITY);
    TEST_ASSERT_FALSE(ok);
    TEST_ASSERT_EQUAL_UINT64(RECORDER_ROWS + 10u, written + dropped);
    check_file(RECORDER_ROWS + 10u); // whole ones
}

static void test_a_file_that_cannot_be_made_is_named(void)
{
    refuse("/nowhere/log.csv");
    TEST_ASSERT_EQUAL_STRING("--log /nowhere/log.csv: No such file or directory", error.text);
}

#include "runners/test_recorder.inc" // main
