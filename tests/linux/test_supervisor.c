// Two processes on outputs that only count: whatever ends the loop, the outputs are off before supervisor_run returns. The linker
// puts this file's ioctl, a watchdog's, in the place of the library's.

#include "supervisor.h"

#include "realtime.h"
#include "unity.h"

#include <errno.h>
#include <linux/watchdog.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define MS           INT64_C(1000000)
#define HEARTBEAT_MS 500u // the loop beats every millisecond

/// Shared by both processes.
static struct
{
    atomic_int   off;
    atomic_llong stopped_ns, off_ns;
} *seen;

static supervisor_config_t config;

static int  timeout_s;     ///< of the watchdog
static int  timeout_min_s; ///< shortest that it takes
static bool takes_no_timeout;

// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp): names of ld --wrap
int __wrap_ioctl(int file, unsigned long request, ...);

int __wrap_ioctl(int file, unsigned long request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    int *seconds = va_arg(arguments, int *);
    va_end(arguments);
    (void)file;
    if (takes_no_timeout)
    {
        errno = ENOTTY;
        return -1;
    }
    TEST_ASSERT_TRUE(request == WDIOC_SETTIMEOUT || request == WDIOC_GETTIMEOUT);
    if (request == WDIOC_SETTIMEOUT)
    {
        timeout_s = *seconds < timeout_min_s ? timeout_min_s : *seconds;
    }
    *seconds = timeout_s;
    return 0;
}
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)

static void off(void *context)
{
    (void)context;
    atomic_store(&seen->off_ns, realtime_now_ns());
    atomic_fetch_add(&seen->off, 1);
}

void setUp(void)
{
    seen = mmap(NULL, sizeof *seen, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    TEST_ASSERT_TRUE(seen != MAP_FAILED);
    config           = (supervisor_config_t){.heartbeat_ms = HEARTBEAT_MS, .priority = 1, .watchdog_s = 3, .off = off};
    timeout_s        = 60;
    timeout_min_s    = 1;
    takes_no_timeout = false;
}

void tearDown(void)
{
    (void)munmap(seen, sizeof *seen);
}

static int run(int (*loop)(void *context, heart_t *heart))
{
    common_error_t error  = {""};
    const int      status = supervisor_run(&config, loop, NULL, &error);
    TEST_ASSERT_EQUAL_STRING("", error.text);
    TEST_ASSERT_TRUE(atomic_load(&seen->off) > 0);
    return status;
}

static void beat_for_ms(heart_t *heart, int ms)
{
    for (int i = 0; i < ms; i++)
    {
        heart_beat(heart);
        (void)realtime_sleep_until(realtime_now_ns() + MS);
    }
}

static int returns_3(void *context, heart_t *heart)
{
    (void)context;
    beat_for_ms(heart, 5);
    return 3;
}

static int kills_itself(void *context, heart_t *heart)
{
    (void)context;
    beat_for_ms(heart, 5);
    atomic_store(&seen->stopped_ns, realtime_now_ns());
    (void)raise(SIGKILL);
    return 0;
}

static int stops_itself(void *context, heart_t *heart)
{
    (void)context;
    beat_for_ms(heart, 5);
    atomic_store(&seen->stopped_ns, realtime_now_ns());
    (void)raise(SIGSTOP);
    return 0;
}

/// A loop that hangs, and signals that come more often than the supervisor looks. It gives up after 40 heartbeats.
static int hangs_with_signals(void *context, heart_t *heart)
{
    (void)context;
    beat_for_ms(heart, 5);
    const int64_t end_ns = realtime_now_ns() + 40 * HEARTBEAT_MS * MS;
    while (realtime_now_ns() < end_ns)
    {
        (void)kill(getppid(), SIGWINCH);
    }
    return 5;
}

static int rests(void *context, heart_t *heart)
{
    (void)context;
    beat_for_ms(heart, 5);
    heart_rest(heart);
    (void)realtime_sleep_until(realtime_now_ns() + 4 * HEARTBEAT_MS * MS);
    return 4;
}

static volatile sig_atomic_t got;

static void take(int signal)
{
    got = signal;
}

static int tells_supervisor_to_end(void *context, heart_t *heart)
{
    (void)context;
    (void)signal(SIGTERM, take);
    (void)kill(getppid(), SIGTERM);
    while (got == 0)
    {
        beat_for_ms(heart, 1);
    }
    return 10;
}

static int kills_supervisor(void *context, heart_t *heart)
{
    (void)context;
    (void)signal(SIGTERM, take);
    (void)kill(getppid(), SIGKILL);
    while (got == 0)
    {
        beat_for_ms(heart, 1);
    }
    atomic_fetch_add(&seen->off, 100); // here the loop turns its outputs off
    return 0;
}

static void test_an_end_is_passed_on(void)
{
    TEST_ASSERT_EQUAL_INT(3, run(returns_3));
    TEST_ASSERT_EQUAL_INT(1, atomic_load(&seen->off));
}

static void test_a_killed_loop_is_turned_off(void)
{
    TEST_ASSERT_EQUAL_INT(128 + SIGKILL, run(kills_itself));
}

static void test_a_stopped_loop_is_turned_off_and_ended(void)
{
    TEST_ASSERT_EQUAL_INT(128 + SIGKILL, run(stops_itself));
    TEST_ASSERT_TRUE(atomic_load(&seen->off_ns) - atomic_load(&seen->stopped_ns) >= (HEARTBEAT_MS - 10) * MS);
}

static void test_signals_do_not_hide_a_loop_that_hangs(void)
{
    TEST_ASSERT_EQUAL_INT(128 + SIGKILL, run(hangs_with_signals));
}

static void test_a_loop_at_rest_needs_no_heartbeat(void)
{
    TEST_ASSERT_EQUAL_INT(4, run(rests));
    TEST_ASSERT_EQUAL_INT(1, atomic_load(&seen->off));
}

static void test_a_signal_to_the_supervisor_reaches_the_loop(void)
{
    TEST_ASSERT_EQUAL_INT(10, run(tells_supervisor_to_end));
}

/// In a process of its own, as it is the one that is killed.
static void test_without_its_supervisor_the_loop_ends(void)
{
    (void)fflush(NULL);
    const pid_t supervisor = fork();
    if (supervisor == 0)
    {
        common_error_t error = {""};
        _exit(supervisor_run(&config, kills_supervisor, NULL, &error));
    }
    for (int i = 0; i < 60000 && atomic_load(&seen->off) < 100; i++)
    {
        (void)realtime_sleep_until(realtime_now_ns() + MS);
    }
    TEST_ASSERT_EQUAL_INT(100, atomic_load(&seen->off));
}

/// What a watchdog, a file in `path`, was told.
static size_t read_watchdog(const char *path, char *text, size_t size)
{
    FILE *file = fopen(path, "r");
    TEST_ASSERT_NOT_NULL(file);
    const size_t length = fread(text, 1, size, file);
    (void)fclose(file);
    (void)unlink(path);
    return length;
}

static void test_the_watchdog_is_fed_and_disarmed(void)
{
    char path[] = "/tmp/tribo-watchdog-XXXXXX";
    char text[4096];
    (void)close(mkstemp(path));
    config.watchdog = path;
    TEST_ASSERT_EQUAL_INT(3, run(returns_3));
    TEST_ASSERT_EQUAL_INT(3, timeout_s);
    const size_t length = read_watchdog(path, text, sizeof text);
    TEST_ASSERT_TRUE(length > 1);
    TEST_ASSERT_EQUAL_UINT(length - 1, strspn(text, "."));
    TEST_ASSERT_EQUAL_CHAR('V', text[length - 1]);
}

static void test_a_watchdog_that_is_not_there_is_named(void)
{
    common_error_t error = {""};
    config.watchdog      = "/nowhere/watchdog";
    TEST_ASSERT_EQUAL_INT(-1, supervisor_run(&config, returns_3, NULL, &error));
    TEST_ASSERT_EQUAL_STRING("watchdog: /nowhere/watchdog: No such file or directory", error.text);
}

/// It is opened, and so armed, by then.
static void check_refused(const char *message)
{
    char           path[]  = "/tmp/tribo-watchdog-XXXXXX";
    char           text[8] = "";
    char           expected[256];
    common_error_t error = {""};
    (void)close(mkstemp(path));
    config.watchdog = path;
    TEST_ASSERT_EQUAL_INT(-1, supervisor_run(&config, returns_3, NULL, &error));
    (void)snprintf(expected, sizeof expected, message, path);
    TEST_ASSERT_EQUAL_STRING(expected, error.text);
    TEST_ASSERT_EQUAL_UINT(1, read_watchdog(path, text, sizeof text));
    TEST_ASSERT_EQUAL_CHAR('V', text[0]);
    TEST_ASSERT_EQUAL_INT(0, atomic_load(&seen->off)); // no loop has run
}

static void test_a_watchdog_with_another_timeout_is_refused_and_disarmed(void)
{
    timeout_min_s = 16;
    check_refused("watchdog_s: 3: %s uses a timeout of 16 s instead");
}

static void test_a_watchdog_that_takes_no_timeout_is_refused_and_disarmed(void)
{
    takes_no_timeout = true;
    check_refused("watchdog: %s: does not accept a timeout of 3 s (watchdog_s): Inappropriate ioctl for device");
}

#include "runners/test_supervisor.inc" // main
