/// The four functions that a board implements for lock-step with the host over a serial line, 8N1 at any rate. link.c in
/// this folder turns bytes into messages; lock_step() in port/emulated/lock_step.h does the rest.

#ifndef SERIAL_SERIAL_H
#define SERIAL_SERIAL_H

#include <stdint.h>

/// Waits for the next byte and returns it.
uint8_t serial_read(void);

/// Waits until there is room for a byte, and sends it.
void serial_write(uint8_t byte);

/// Returns the core's counter of cycles, e.g. that of DWT; 0 if there is none.
uint32_t serial_cycles(void);

/// The start of the tested RAM: the first variable.
uint32_t *serial_ram(void);

#endif
