/// What a microcontroller does between its ticks, in a thread of ordinary priority: the bus, making and saving params, and a line
/// on standard error when the drive changes state. The tick does not wait for it: gate.h.
///
/// The application is written for a tick that interrupts the background. Here both run at once. So a read is repeated
/// until it falls between two ticks, and a trace is stopped for a tick before it is armed.

#ifndef LINUX_BACKGROUND_H
#define LINUX_BACKGROUND_H

#include "app/registers.h"
#include "bus.h"
#include "gate.h"

#include <pthread.h>
#include <stdatomic.h>

typedef struct
{
    registers_t *registers;
    gate_t      *gate;
    bus_t       *bus;
    atomic_bool  stops, has_ended;
    pthread_t    thread;
} background_t;

/// Its line for a drive whose bus is not in the tick.
extern const modbus_line_t background_line;

/// False with the cause in `error`. The arguments must outlive the thread.
bool background_start(background_t   *background,
                      registers_t    *registers,
                      gate_t         *gate,
                      bus_t          *bus,
                      common_error_t *error);

/// Ends the thread once its current request is finished. Only for a drive that has stopped ticking. False: a disk holds it up, and
/// it is left to itself; whatever it had of the store, the store is whole.
bool background_stop(background_t *background);

#endif
