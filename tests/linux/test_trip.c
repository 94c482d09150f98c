// Stops that come while the tick takes them: a signal is the interrupt.

#include "port/trip.h"
#include "unity.h"

#include <signal.h>
#include <sys/time.h>

#define STOPS 5000

static trip_t                trip;
static volatile sig_atomic_t stops, is_new;

static void stop(int number)
{
    (void)number;
    trip_count(&trip);
    is_new = 1;
    stops  = stops + 1;
}

static void test_no_stop_is_swallowed_whenever_it_comes(void)
{
    const struct itimerval every = {.it_interval = {0, 50}, .it_value = {0, 50}};
    const struct itimerval never = {.it_interval = {0, 0}, .it_value = {0, 0}};
    (void)signal(SIGALRM, stop);
    TEST_ASSERT_EQUAL_INT(0, setitimer(ITIMER_REAL, &every, NULL));
    int swallowed = 0;
    while (stops < STOPS)
    {
        is_new             = 0;
        const bool before  = trip_take(&trip); // of a stop before is_new was cleared, or of a new one
        const bool has_new = is_new != 0;      // if it has come by now, it was taken or waits
        swallowed += has_new && !before && !trip_has_come(&trip);
    }
    (void)setitimer(ITIMER_REAL, &never, NULL);
    TEST_ASSERT_EQUAL_INT(0, swallowed);
}

#include "runners/test_trip.inc" // main
