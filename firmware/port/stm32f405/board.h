/// A board with an STM32F405, wired as in wiring.h: the drive's port to it.
///
/// Emergency stop, power fault and a supply below 2.9 V interrupt any code and turn the outputs off; the next tick raises the
/// fault. Pulses between two ticks are detected, too. Enable is read back in each tick, and a ready output that has not fallen
/// 100 ms after it is off is a fault of the power stage.
///
/// TIM2 triggers the ticks at 1 kHz and TIM5 counts time at 1 MHz, both from one clock. The sensor is converted again and again
/// (stage.h), 42 times a tick at 168 MHz, with the bridge 20 times, and a tick reads the mean since the last one.

#ifndef STM32F405_BOARD_H
#define STM32F405_BOARD_H

#include "app/modbus.h"
#include "clock.h"
#include "device.h"
#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

#define BOARD_TICK_US 1000u

// Of interrupts, 0 to 15.
#define BOARD_LINE_PRIORITY  12u
#define BOARD_TICK_PRIORITY  8u ///< a tick interrupts what is received
#define BOARD_STAGE_PRIORITY 4u ///< the current loop interrupts a tick
#define BOARD_STOP_PRIORITY  0u ///< stops interrupt all

extern const port_t board_port;

/// Sets up pins (outputs off), clock and peripherals. Interrupts stay off. The levels and the crystal of `config` hold until
/// the next power-up. `no_current` is the output for zero current.
board_clock_t board_init(const drive_config_t *config, loop_force_t no_current);

/// Starts MPU, interrupts, TIM2, the converter and the watchdog. Call board_kick at least every 20 ms from now on.
void board_start(void);

/// Power stage off, command at zero current; safe at any time, also from a fault handler.
void board_off(void);

/// True if the power stage is off.
bool board_is_off(void);

void board_start_interrupt(IRQn_Type interrupt, uint32_t priority);

/// Background: kicks the watchdog after a new tick, so that it monitors both.
void board_kick(void);

#define BOARD_NO_BYTE  (-1)
#define BOARD_BAD_BYTE (-2)

/// A byte from USART1; BOARD_NO_BYTE if there is none, BOARD_BAD_BYTE if it has an error or others were lost.
int board_read_byte(void);

/// Background: leaves the line to others once all is sent.
void board_release_line(void);

/// USART1 as the drive's bus, without `stray`.
extern const modbus_line_t board_line;

/// The tick, defined in main.c; the timer's interrupt calls it.
void board_tick(void);

#endif
