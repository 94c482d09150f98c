/// A board's four functions for lock-step with the host over a serial line, 8N1 at any rate. link.c in this folder turns bytes
/// into messages; lock_step() in port/emulated/lock_step.h does the rest.

#ifndef SERIAL_SERIAL_H
#define SERIAL_SERIAL_H

#include <stdint.h>

/// The next byte; waits for it.
uint8_t serial_read(void);

/// Sends a byte; waits until there is room for it.
void serial_write(uint8_t byte);

/// The core's counter of cycles, e.g. DWT's; 0 where there is none.
uint32_t serial_cycles(void);

/// Start of the tested RAM: the first variable.
uint32_t *serial_ram(void);

#endif
