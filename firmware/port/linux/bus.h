/// A Modbus server on a serial line (RTU) or over TCP. app/modbus.h says what a request does, on each line alike. For a thread that
/// may wait; no client makes it wait longer than it is told to.
///
/// Over TCP the first client has the drive for as long as it asks for something now and then. Others may stop it, and are otherwise
/// told that it is busy, with a message on standard error. When the first has gone, the next that asks has the drive.

#ifndef LINUX_BUS_H
#define LINUX_BUS_H

#include "app/modbus.h"
#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

#define BUS_NAME_MAX 255u

/// `device` or `listen`. Neither: there is no bus.
typedef struct
{
    char     device[BUS_NAME_MAX + 1]; ///< a serial line, 8N1
    uint64_t baud;
    int      rs485;                    ///< 0 or 1
    char     listen[BUS_NAME_MAX + 1]; ///< an address of this machine
    uint64_t port;
    uint64_t silent_s; ///< a client that asks for nothing for longer gives way to the next one
} bus_config_t;

bool bus_is_used(const bus_config_t *config);

/// What is behind the server.
typedef struct
{
    modbus_t          *modbus;    ///< unit and counters
    modbus_registers_t registers; ///< and the context ...
    void (*leave)(void *context); ///< ... of this, called when the client that has the drive has gone
} bus_service_t;

typedef struct bus bus_t;

/// Null with the cause in `error`. `config` and `service` must outlive it.
bus_t *bus_open(const bus_config_t *config, common_error_t *error);
void   bus_close(bus_t *bus);

/// Waits up to `wait_ms` for requests to the unit (over TCP to any) and answers them. A line that fails is reported on standard
/// error and opened again, with one attempt a second.
void bus_serve(bus_t *bus, const bus_service_t *service, int wait_ms);

/// Nobody could answer what has come until now: MODBUS_LATE.
void bus_was_away(bus_t *bus);

#endif
