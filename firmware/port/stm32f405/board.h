/// A board with an STM32F405: its connections, and the drive's port to it.
///
///     PA0   ADC1_IN0    force sensor: 1.65 V at 0 N, 0.33 to 2.97 V for -2 to 2 N; a voltage beyond that is out of
///                       range, and so is a broken wire, which a resistor pulls to ground
///     PA4   DAC_OUT1    current command to the voltage-to-current converter: 1.65 V at 0 A, 0 to 3.3 V for -2 to 2 N; not
///                       buffered, 15 kOhm
///     PB0   output      power stage on when high; a resistor to ground keeps it off through reset
///     PB1   input       emergency stop: closed to ground when released; open (or a broken wire) is active
///     PB12  input       the power stage's fault output: low when healthy; high (or a broken wire) is active. A pulse on
///                       either input between two ticks is detected as well
///     PA9, PA10         USART1, log and commands, 115200 8N1
///
/// TIM2 triggers the ticks at 1 kHz and TIM5 counts time at 1 MHz, both from one clock. The sensor is converted
/// continuously, 42 times a tick at 168 MHz, and a tick reads the mean of the conversions since the last one.

#ifndef STM32F405_BOARD_H
#define STM32F405_BOARD_H

#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

#define BOARD_TICK_US 1000u

typedef enum
{
    BOARD_CLOCK_HSE, ///< 168 MHz from the 8 MHz crystal
    BOARD_CLOCK_HSI, ///< 168 MHz from the internal oscillator: the crystal does not start
    BOARD_CLOCK_SLOW ///< 16 MHz, the internal oscillator itself: the PLL does not lock
} board_clock_t;

extern const port_t board_port;

/// Sets up pins (outputs off), clocks and peripherals. Interrupts stay off.
board_clock_t board_init(void);

/// Starts TIM2, the converter and the watchdog: from now on board_kick must be called every 20 ms.
void board_start(void);

/// Power stage off, command at zero current; safe at any time, also from a fault handler.
void board_off(void);

void board_kick(void);

/// Whether the watchdog has reset the chip since the last call: a tick or the background hung, or Default_Handler ran. The
/// flag does not survive a loss of supply.
bool board_was_reset_by_watchdog(void);

#define BOARD_NO_BYTE  (-1)
#define BOARD_OVERRUN  (-2)
#define BOARD_BAD_BYTE (-3)

/// A byte from USART1; BOARD_NO_BYTE if there is none, BOARD_BAD_BYTE if it has an error, BOARD_OVERRUN if bytes were lost.
int board_read_byte(void);

/// The tick, defined in main.c; the timer's interrupt calls it.
void board_tick(void);

#endif
