/// A Modbus server on a serial line (RTU) or over TCP. app/modbus.h describes what requests do on each kind of line. The
/// server is for a thread that may wait; no client makes it wait longer than its caller allows.
///
/// Over TCP the first client has the drive as long as it sends a request now and then. Other clients may stop the drive; all
/// their other requests are answered with busy, and reported on standard error. When the first client has gone, the next one
/// to send a request has the drive.

#ifndef LINUX_BUS_H
#define LINUX_BUS_H

#include "app/modbus.h"
#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

#define BUS_NAME_MAX 255u

/// The configuration has `device` or `listen`, or neither if there is no bus.
typedef struct
{
    char     device[BUS_NAME_MAX + 1]; ///< a serial line, 8N1
    uint64_t baud;
    int      rs485;                    ///< 0 or 1
    char     listen[BUS_NAME_MAX + 1]; ///< an address of this machine
    uint64_t port;
    uint64_t silent_s; ///< a client without a request for longer gives way to the next one
} bus_config_t;

bool bus_is_used(const bus_config_t *config);

/// The application behind the server.
typedef struct
{
    modbus_t          *modbus;    ///< unit and counters
    modbus_registers_t registers; ///< and the context ...
    void (*leave)(void *context); ///< ... of this, called when the client that has the drive has gone
} bus_service_t;

typedef struct bus bus_t;

/// Opens the bus. Returns null with the cause in `error`. `config` and `service` must outlive the bus.
bus_t *bus_open(const bus_config_t *config, common_error_t *error);
void   bus_close(bus_t *bus);

/// Waits up to `wait_ms` for requests to the unit (over TCP to any) and answers them. A line that fails is reported on standard
/// error and opened again, with one attempt a second.
void bus_serve(bus_t *bus, const bus_service_t *service, int wait_ms);

/// Marks all bytes that have come until now as late (MODBUS_LATE), because the program could not answer.
void bus_was_away(bus_t *bus);

#endif
