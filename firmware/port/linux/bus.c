#include "bus.h"

#include "bus_lines.h"

#include "support/clock.h"

#include <stdlib.h>

#define AWAY_S 1.0 ///< if the line was not served for so long, the program was stopped or got no processor time

struct bus
{
    bus_serial_t *serial; ///< or ...
    bus_tcp_t    *tcp;
    double        served_s; ///< time of the last service; 0: none yet
};

bool bus_is_used(const bus_config_t *config)
{
    return config->device[0] != '\0' || config->listen[0] != '\0';
}

bus_t *bus_open(const bus_config_t *config, common_error_t *error)
{
    bus_t *bus = calloc(1, sizeof *bus);
    if (bus == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    bus->serial = config->device[0] != '\0' ? bus_serial_open(config, error) : NULL;
    bus->tcp    = config->device[0] == '\0' ? bus_tcp_open(config, error) : NULL;
    if (bus->serial == NULL && bus->tcp == NULL)
    {
        bus_close(bus);
        return NULL;
    }
    return bus;
}

void bus_close(bus_t *bus)
{
    if (bus == NULL)
    {
        return;
    }
    bus_serial_close(bus->serial);
    bus_tcp_close(bus->tcp);
    free(bus);
}

void bus_was_away(bus_t *bus)
{
    if (bus->serial != NULL)
    {
        bus_serial_was_away(bus->serial);
    }
    else
    {
        bus_tcp_was_away(bus->tcp);
    }
}

void bus_serve(bus_t *bus, const bus_service_t *service, int wait_ms)
{
    if (bus->served_s > 0.0 && common_clock_s() - bus->served_s > AWAY_S)
    {
        bus_was_away(bus);
    }
    if (bus->serial != NULL)
    {
        bus_serial_serve(bus->serial, service, wait_ms);
    }
    else
    {
        bus_tcp_serve(bus->tcp, service, wait_ms);
    }
    bus->served_s = common_clock_s();
}
