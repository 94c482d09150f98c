/// The drive's port to a board with an STM32F405, wired as in wiring.h.
///
/// Emergency stop, power fault and a supply below 2.9 V interrupt any code and turn the outputs off. The next tick raises the
/// fault, even after a pulse between two ticks. Enable is read back in each tick. A ready output that has not fallen 100 ms after
/// enable is off is a fault of the power stage.
///
/// TIM2 triggers the ticks at 1 kHz and TIM5 counts time at 1 MHz, both from one clock. The sensor is converted continuously
/// (stage.h), 42 times a tick at 168 MHz, or 20 times with the bridge. A tick reads the mean since the last one.

#ifndef STM32F405_BOARD_H
#define STM32F405_BOARD_H

#include "app/modbus.h"
#include "clock.h"
#include "device.h"
#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

#define BOARD_TICK_US 1000u

// Priorities of interrupts, 0 to 15.
#define BOARD_LINE_PRIORITY  12u
#define BOARD_TICK_PRIORITY  8u ///< a tick interrupts the reception of bytes
#define BOARD_STAGE_PRIORITY 4u ///< the current loop interrupts a tick
#define BOARD_STOP_PRIORITY  0u ///< stops interrupt everything

extern const port_t board_port;

/// Sets up pins (outputs off), clock and peripherals. Interrupts stay off. The levels and the crystal of `config` hold until
/// the next power-up. `no_current` is the output for zero current.
board_clock_t board_init(const drive_config_t *config, loop_force_t no_current);

/// Starts MPU, interrupts, TIM2, the converter and the watchdog. Call board_kick at least every 20 ms from now on.
void board_start(void);

/// Turns the power stage off and the command to zero current. Safe at any time, even in a fault handler.
void board_off(void);

/// Returns true if the power stage is off.
bool board_is_off(void);

void board_start_interrupt(IRQn_Type interrupt, uint32_t priority);

/// Kicks the watchdog after a new tick. The background calls this, so that the watchdog monitors both.
void board_kick(void);

#define BOARD_NO_BYTE  (-1)
#define BOARD_BAD_BYTE (-2)

/// Returns a byte from USART1; BOARD_NO_BYTE if there is none, BOARD_BAD_BYTE if it has an error or others were lost.
int board_read_byte(void);

/// Releases the line once everything is sent. The background calls this.
void board_release_line(void);

/// USART1, the line of the drive's bus, without `stray`.
extern const modbus_line_t board_line;

/// The tick, defined in main.c; the timer's interrupt calls it.
void board_tick(void);

#endif
