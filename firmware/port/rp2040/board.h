/// A board with an RP2040, wired as in wiring.h: the drive's port to it, on core 0; core 1 sleeps.
///
/// Emergency stop and the driver's fault interrupt any code and turn the outputs off; the next tick raises the fault, also of a
/// pulse between two ticks. Enable is read back in each tick. TIMER's alarm 0 triggers the ticks at 1 kHz, and TIMER counts time
/// at 1 MHz, both from the crystal. A tick begins with 16 conversions of the sensor, 2 us each, and reads their mean.

#ifndef RP2040_BOARD_H
#define RP2040_BOARD_H

#include "app/drive.h"
#include "app/modbus.h"
#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

#define BOARD_TICK_US 1000u

extern const port_t board_port;

/// Why the chip was reset, as the drive's initial fault. An exception's number and address, 0 of others. Call it once, first.
drive_fault_t board_reset_fault(uint32_t *exception, uint32_t *address);

/// Leaves a record and resets the chip, with the outputs off. Does not return.
__attribute__((noreturn)) void board_reset(uint32_t exception, uint32_t address);

/// Sets up clocks, pins (outputs off) and peripherals. Interrupts stay off. The levels of `config` hold until the next power-up.
/// False if the crystal or a PLL does not start: then nothing else may run.
bool board_init(const drive_config_t *config);

/// Starts interrupts, TIMER, PWM and the watchdog. Call board_kick at least every 20 ms from now on.
void board_start(void);

/// Driver off, no current; safe at any time, also from a fault handler.
void board_off(void);

/// Background: kicks the watchdog after a new tick, so that it monitors both.
void board_kick(void);

/// Background: leaves the line to others once all is sent.
void board_release_line(void);

/// UART0 as the drive's bus.
extern const modbus_line_t board_line;

/// The tick, defined in main.c; the timer's interrupt calls it.
void board_tick(void);

#endif
