/// The drive's port to a board with an RP2040, wired as in wiring.h. It runs on core 0; core 1 sleeps.
///
/// Emergency stop and the driver's fault interrupt any code and turn the outputs off. The next tick raises the fault, even
/// after a pulse between two ticks. Enable is read back in each tick. TIMER's alarm 0 triggers the ticks at 1 kHz, and TIMER
/// counts time at 1 MHz, both from the crystal. A tick begins with 16 conversions of the sensor, 2 us each, and reads their
/// mean.

#ifndef RP2040_BOARD_H
#define RP2040_BOARD_H

#include "app/drive.h"
#include "app/modbus.h"
#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

#define BOARD_TICK_US 1000u

extern const port_t board_port;

/// Returns why the chip was reset, as the drive's initial fault, with the number and address of an exception, otherwise 0.
/// Call it once, before everything else.
drive_fault_t board_reset_fault(uint32_t *exception, uint32_t *address);

/// Leaves a record and resets the chip, with the outputs off. Does not return.
__attribute__((noreturn)) void board_reset(uint32_t exception, uint32_t address);

/// Sets up clocks, pins (outputs off) and peripherals. Interrupts stay off. The levels of `config` hold until the next power-up.
/// Returns false if the crystal or a PLL does not start; nothing else may run then.
bool board_init(const drive_config_t *config);

/// Starts interrupts, TIMER, PWM and the watchdog. Call board_kick at least every 20 ms from now on.
void board_start(void);

/// Turns the driver off and the current to 0. Safe at any time, even in a fault handler.
void board_off(void);

/// Kicks the watchdog after a new tick. The background calls this, so that the watchdog monitors both.
void board_kick(void);

/// Releases the line once everything is sent. The background calls this.
void board_release_line(void);

/// UART0, the line of the drive's bus.
extern const modbus_line_t board_line;

/// The tick, defined in main.c; the timer's interrupt calls it.
void board_tick(void);

#endif
