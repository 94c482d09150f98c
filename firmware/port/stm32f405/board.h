/// A board with an STM32F405: its connections, and the drive's port to it.
///
///     PA0   ADC1_IN0    force sensor; 0.33 to 2.97 V are -2 to 2 N in rig_config.h. A reading within 80 mV of a rail is out of
///                       range; a resistor pulls a broken wire there, to ground
///     PA4   DAC_OUT1    current command to the voltage-to-current converter: 1.65 V at 0 A; not buffered, 15 kOhm. 0 V is
///                       full reverse: two resistors at the converter's input hold an open wire at 1.65 V (README.md)
///     PB0   output      power stage on when high; a resistor to ground keeps it off through reset
///     PB1   input       emergency stop: closed to ground when released; open (or a broken wire) is active
///     PB12  input       the power stage's fault output, active at drive_config_t.fault_level, to which an internal resistor of
///                       40 kOhm pulls an open wire: an open-drain output needs 4.7 kOhm to 3.3 V at the power stage
///     PB13  input       the power stage's ready output, if ready_ms is not 0; an open wire is not ready
///     PA1   ADC2_IN1    the motor's current, if drive_config_t.over_current_a is not 0; 0.2 V/A around 1.65 V (convert.h)
///     PA2   ADC2_IN2    the power stage's supply, for bus_low_v and bus_high_v; a twentieth of it
///     PA3   ADC2_IN3    its temperature, for temperature_max_c; 10 mV/degC
///     PA8   output      high while USART1 sends: the driver-enable of an RS-485 transceiver
///     PA9, PA10         USART1, log and commands, 115200 8N1
///
/// PB1, PB12 and a supply below 2.9 V interrupt any code and turn the outputs off; the next tick raises the fault. Pulses
/// between two ticks are detected, too. PB0 is read back in each tick, and a ready output that has not fallen 100 ms after it is
/// off is a fault of the power stage.
///
/// TIM2 triggers the ticks at 1 kHz and TIM5 counts time at 1 MHz, both from one clock. The sensor is converted
/// continuously, 42 times a tick at 168 MHz, and a tick reads the mean of the conversions since the last one.

#ifndef STM32F405_BOARD_H
#define STM32F405_BOARD_H

#include "app/modbus.h"
#include "clock.h"
#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

#define BOARD_TICK_US 1000u

extern const port_t board_port;

/// Sets up pins (outputs off), clock and peripherals. Interrupts stay off. The levels and the crystal of `config` hold until
/// the next power-up. `no_current` is the output for zero current.
board_clock_t board_init(const drive_config_t *config, loop_force_t no_current);

/// Starts MPU, interrupts, TIM2, the converter and the watchdog. Call board_kick at least every 20 ms from now on.
void board_start(void);

/// Power stage off, command at zero current; safe at any time, also from a fault handler.
void board_off(void);

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
