/// The two kinds of line of a bus (bus.h).

#ifndef LINUX_BUS_LINES_H
#define LINUX_BUS_LINES_H

#include "bus.h"

typedef struct bus_serial bus_serial_t;
typedef struct bus_tcp    bus_tcp_t;

bus_serial_t *bus_serial_open(const bus_config_t *config, common_error_t *error);
void          bus_serial_close(bus_serial_t *bus);
void          bus_serial_serve(bus_serial_t *bus, const bus_service_t *service, int wait_ms);
void          bus_serial_was_away(bus_serial_t *bus);

bus_tcp_t *bus_tcp_open(const bus_config_t *config, common_error_t *error);
void       bus_tcp_close(bus_tcp_t *bus);
void       bus_tcp_serve(bus_tcp_t *bus, const bus_service_t *service, int wait_ms);
void       bus_tcp_was_away(bus_tcp_t *bus);

#endif
