/// Runs in a thread of ordinary priority what a microcontroller does between its ticks: serves the bus, makes and saves
/// params, and writes a line to standard error when the drive changes state. The tick does not wait for this thread
/// (gate.h).
///
/// The application is written for a tick that interrupts the background. Here both run at once, so a read is repeated until it
/// falls between two ticks, and a trace is stopped for a tick before it is armed.

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

/// The line of a drive whose bus is not served in the tick.
extern const modbus_line_t background_line;

/// Starts the thread. Returns false with the cause in `error`. The arguments must outlive the thread.
bool background_start(background_t   *background,
                      registers_t    *registers,
                      gate_t         *gate,
                      bus_t          *bus,
                      common_error_t *error);

/// Ends the thread once its current request is finished. The drive must have stopped ticking. Returns false if a disk holds the
/// thread up, which is then left running; the store stays whole.
bool background_stop(background_t *background);

#endif
