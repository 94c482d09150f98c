/// A Modbus server by libmodbus, on a serial line (RTU) or over TCP for one client at a time: while it asks for something now and
/// then, a second one is refused with a message on standard error. For a thread that may block, on a line for a request's length;
/// no client over TCP blocks it for longer than 0.1 s.

#ifndef LINUX_BUS_H
#define LINUX_BUS_H

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

/// The registers that it serves. Both functions do all or nothing and return 0 or the exception to answer with. `count` is at most
/// 125, the last address at most 0xffff.
typedef struct
{
    void *context;
    unsigned (*read)(void *context, uint16_t address, uint16_t count, uint16_t *values);
    unsigned (*write)(void *context, uint16_t address, uint16_t count, const uint16_t *values);
} bus_registers_t;

typedef enum
{
    BUS_NOTHING,  ///< no request for this unit
    BUS_EXECUTED, ///< a request was carried out
    BUS_REFUSED,  ///< a request was answered with an exception
    BUS_BAD_FRAME
} bus_event_t;

typedef struct bus bus_t;

/// Null with the cause in `error`.
bus_t *bus_open(const bus_config_t *config, common_error_t *error);
void   bus_close(bus_t *bus);

/// Waits up to `wait_ms` for a request to `unit` (over TCP to any) and answers it. A line that fails is reported on
/// standard error and opened again, with one attempt a second.
bus_event_t bus_serve(bus_t *bus, unsigned unit, const bus_registers_t *registers, int wait_ms);

#endif
