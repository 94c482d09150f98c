/// The board around an STM32F405: who is connected where, and the drive's port to it.
///
///     PA0   ADC1_IN0    force sensor: 1.65 V at 0 N, 0.33 to 2.97 V for -2 to 2 N; what is beyond that is out of range,
///                       a broken wire too, by a resistor to ground
///     PA4   DAC_OUT1    current command to the voltage-to-current converter: 1.65 V at 0 A, 0 to 3.3 V for -2 to 2 N; not
///                       buffered, 15 kOhm
///     PB0   output      power stage on when high; a resistor to ground keeps it off through reset
///     PB1   input       emergency stop: closed to ground when released; open (or a broken wire) is active
///     PB12  input       the power stage's fault output: low when healthy; high (or a broken wire) is active. Of either
///                       input a pulse between two ticks counts as well
///     PA9, PA10         USART1, log and commands, 115200 8N1
///
/// Ticks come from TIM2, 1 kHz, time from TIM5, 1 MHz, both from one clock. Sensor conversions run all the time, 42 in a
/// tick at 168 MHz, and a tick takes the mean of those since the last one.

#ifndef STM32F405_BOARD_H
#define STM32F405_BOARD_H

#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

#define BOARD_TICK_US 1000u

typedef enum
{
    BOARD_CLOCK_HSE, ///< 168 MHz from the 8 MHz crystal
    BOARD_CLOCK_HSI, ///< 168 MHz from the internal oscillator, as the crystal does not start
    BOARD_CLOCK_SLOW ///< 16 MHz, the internal oscillator itself, as the PLL does not lock
} board_clock_t;

extern const port_t board_port;

/// Pins with the outputs off, clocks, and everything but the interrupts.
board_clock_t board_init(void);

/// TIM2 and the converter begin, with the watchdog: from now on board_kick must come every 20 ms.
void board_start(void);

/// Power stage off, command at zero current; safe at any time, also from a fault handler.
void board_off(void);

void board_kick(void);

/// Whether the watchdog has reset the chip since this was asked last: a tick or the background hung, or Default_Handler was
/// reached. A reset by the supply forgets it.
bool board_was_reset_by_watchdog(void);

#define BOARD_NO_BYTE    (-1)
#define BOARD_BYTES_LOST (-2)

/// A byte from USART1, BOARD_NO_BYTE if there is none or not a good one, BOARD_BYTES_LOST when more came than were read.
int board_read_byte(void);

/// In the timer's interrupt: the tick, which is main's. Returns when it is done.
void board_tick(void);

#endif
