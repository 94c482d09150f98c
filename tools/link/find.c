#include "find.h"

#include "bus.h"

#include <glob.h>
#include <stdio.h>
#include <string.h>

static const char *const places[] = {"/dev/ttyUSB*", "/dev/ttyACM*"};

#define HERE "tcp:127.0.0.1:1502" // bus.port of a drive on Linux, if its configuration has no other

/// Calls `take` with each device that answers, and returns their number.
static int find(int unit, int baud, void (*take)(void *context, const char *device), void *context)
{
    glob_t found = {.gl_pathc = 0};
    int    count = 0;
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++)
    {
        (void)glob(places[i], i > 0 ? GLOB_APPEND : 0, NULL, &found);
    }
    for (size_t i = 0; i <= found.gl_pathc; i++)
    {
        const char *device = i < found.gl_pathc ? found.gl_pathv[i] : HERE;
        if (link_bus_answers(device, unit, baud))
        {
            take(context, device);
            count++;
        }
    }
    globfree(&found);
    return count;
}

static bool complain_of_none(int unit)
{
    return link_complain("no drive answers as unit %d at %s, %s or " HERE "; which line? --device DEVICE or "
                         "TRIBO_LINK_DEVICE is expected",
                         unit,
                         places[0],
                         places[1]);
}

static void keep(void *context, const char *device)
{
    (void)snprintf(context, LINK_DEVICE_MAX, "%s", device);
}

bool link_find_device(char device[LINK_DEVICE_MAX], int unit, int baud)
{
    const int count = find(unit, baud, keep, device);
    if (count == 0)
    {
        return complain_of_none(unit);
    }
    return count == 1 ||
           link_complain("%d drives answer (tribo-link ports shows them): which one? --device DEVICE", count);
}

static void print(void *context, const char *device)
{
    (void)context;
    (void)puts(device);
}

bool link_print_devices(int unit, int baud)
{
    return find(unit, baud, print, NULL) > 0 || complain_of_none(unit);
}
