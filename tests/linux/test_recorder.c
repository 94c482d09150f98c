// The log: all rows, in order, or counted as dropped; and the tick never waits for a disk that does not take them.

#include "recorder.h"

#include "realtime.h"
#include "unity.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char path[64];

void setUp(void)
{
    (void)snprintf(path, sizeof path, "/tmp/tribo-recorder-%d", (int)getpid());
}

void tearDown(void)
{
    (void)unlink(path);
}

static void add(recorder_t *recorder, unsigned number)
{
    recorder_add(recorder, &(recorder_row_t){.t_s = number * 1e-3, .r_n = (float)number, .fault = 7});
}

/// Rows of the file whose r counts up from the one before.
static unsigned rows_in_order(FILE *file)
{
    char     line[256];
    unsigned rows = 0;
    TEST_ASSERT_NOT_NULL(fgets(line, sizeof line, file));
    TEST_ASSERT_EQUAL_STRING("t_s,r_N,F_N,u_N,state,fault,limits,late_us,step_us\n", line);
    while (fgets(line, sizeof line, file) != NULL)
    {
        char expected[64];
        (void)snprintf(expected, sizeof expected, "%.6f,%u,0,0,0,7,0,0.0,0.0\n", rows * 1e-3, rows);
        TEST_ASSERT_EQUAL_STRING(expected, line);
        rows++;
    }
    return rows;
}

static void test_all_rows_come_in_order(void)
{
    sim_error_t error    = {""};
    uint64_t    written  = 0;
    uint64_t    dropped  = 0;
    recorder_t *recorder = recorder_start(path, &error);
    TEST_ASSERT_NOT_NULL(recorder);
    for (unsigned i = 0; i < RECORDER_ROWS; i++)
    {
        add(recorder, i);
    }
    TEST_ASSERT_TRUE(recorder_stop(recorder, &written, &dropped, &error));
    TEST_ASSERT_EQUAL_UINT64(RECORDER_ROWS, written);
    TEST_ASSERT_EQUAL_UINT64(0, dropped);
    FILE *file = fopen(path, "r");
    TEST_ASSERT_NOT_NULL(file);
    TEST_ASSERT_EQUAL_UINT(RECORDER_ROWS, rows_in_order(file));
    (void)fclose(file);
}

static void *count_rows(void *file)
{
    static unsigned rows;
    rows = rows_in_order(file);
    return &rows;
}

/// A FIFO that nobody reads from stands for the disk.
static void test_a_disk_that_stalls_costs_rows_not_time(void)
{
    const unsigned added   = 2u * RECORDER_ROWS;
    sim_error_t    error   = {""};
    uint64_t       written = 0;
    uint64_t       dropped = 0;
    pthread_t      reader;
    void          *rows = NULL;
    TEST_ASSERT_EQUAL_INT(0, mkfifo(path, 0600));
    const int end = open(path, O_RDONLY | O_NONBLOCK);
    TEST_ASSERT_TRUE(end >= 0);
    TEST_ASSERT_EQUAL_INT(0, fcntl(end, F_SETFL, 0));
    recorder_t *recorder = recorder_start(path, &error);
    TEST_ASSERT_NOT_NULL(recorder);
    const int64_t start_ns = realtime_now_ns();
    for (unsigned i = 0; i < added; i++)
    {
        add(recorder, i);
    }
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

static void test_a_full_disk_is_told(void)
{
    sim_error_t error    = {""};
    uint64_t    written  = 0;
    uint64_t    dropped  = 0;
    recorder_t *recorder = recorder_start("/dev/full", &error);
    TEST_ASSERT_NOT_NULL(recorder);
    add(recorder, 0);
    TEST_ASSERT_FALSE(recorder_stop(recorder, &written, &dropped, &error));
    TEST_ASSERT_EQUAL_STRING("--log: No space left on device", error.text);
}

static void test_a_file_that_cannot_be_made_is_named(void)
{
    sim_error_t error = {""};
    TEST_ASSERT_NULL(recorder_start("/nowhere/log.csv", &error));
    TEST_ASSERT_EQUAL_STRING("--log /nowhere/log.csv: No such file or directory", error.text);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_all_rows_come_in_order);
    RUN_TEST(test_a_disk_that_stalls_costs_rows_not_time);
    RUN_TEST(test_a_full_disk_is_told);
    RUN_TEST(test_a_file_that_cannot_be_made_is_named);
    return UNITY_END();
}
