/// How the board is wired: its oscillator and its pins. A board of your own changes them here.
///
///     PA0   ADC1_IN0    force sensor; 0.33 to 2.97 V are -2 to 2 N in rig_config.h. A reading within 80 mV of a rail is out of
///                       range; a resistor pulls a broken wire there, to ground
///     PB0   output      power stage on when high; a resistor to ground keeps it off through reset
///     PB1   input       emergency stop: closed to ground when released; open (or a broken wire) is active
///     PB12  input       the power stage's fault output, active at drive_config_t.fault_level, to which an internal resistor of
///                       40 kOhm pulls an open wire: an open-drain output needs 4.7 kOhm to 3.3 V at the power stage
///     PA6, PA7          TIM3_CH1, _CH2, an incremental encoder at the arm, if drive_config_t.speed_max_units_per_s is not 0: a unit is an
///                       edge, four a line. Internal resistors pull up open-collector outputs; a broken wire looks like an arm at rest
///     PA1   ADC2_IN1    the motor's current; 0.2 V/A around 1.65 V (convert.h); a resistor to 3.3 V makes a broken wire an over-current
///     PA2   ADC2_IN2    the power stage's supply, for bus_low_v and bus_high_v; a twentieth of it; a resistor to ground makes a
///                       broken wire an under-voltage
///     PA3   ADC2_IN3    the power stage's temperature, for temperature_max_c; 10 mV/degC; a resistor to 3.3 V makes a broken wire too
///                       hot. Without it the wire may read 0 degC, which no level finds
///     PB5   output      high while USART1 sends: the driver-enable of an RS-485 transceiver
///     PB6, PB7          USART1, log and commands, 115200 8N1
///
/// A separate power stage that takes a command (tribo-stm32f405-*.elf):
///
///     PA4   DAC_OUT1    current command to the voltage-to-current converter: 1.65 V at 0 A; not buffered, 15 kOhm. 0 V is
///                       full reverse: two resistors at the converter's input hold an open wire at 1.65 V (README.md)
///     PB8   input       the power stage's ready output, if ready_ms is not 0; an open wire is not ready
///
/// A bridge that the board drives (tribo-stm32f405-bridge-*.elf), by TIM1. Each gate input needs a resistor to ground:
///
///     PA8, PB13         TIM1_CH1, TIM1_CH1N: high and low side of the leg at the motor's positive terminal
///     PA9, PB14         TIM1_CH2, TIM1_CH2N: the same of the other leg
///     PA10, PB15        TIM1_CH3, TIM1_CH3N: the same of a third leg, if WIRING_LEGS is 3
///     PB12  TIM1_BKIN   as above: the timer itself turns all switches off
///     PA4   ADC2_IN4    current of the second phase of a three-phase motor
///
/// The chip ties its converters to PA0 to PA4, and TIM1 to its pins.

#ifndef STM32F405_WIRING_H
#define STM32F405_WIRING_H

// Bypass is 0 with a crystal between OSC_IN and OSC_OUT, and 1 with a clock at OSC_IN, e.g. the 8 MHz of a Nucleo's ST-LINK.
#define WIRING_OSCILLATOR_HZ 8000000u ///< crystal_hz of rig_config.h; a multiple of CLOCK_CRYSTAL_STEP_HZ
#define WIRING_HSE_BYPASS    0u

// Pins of port A.
#define WIRING_ENCODER_A_PIN 6 ///< TIM3's are 6 and 7
#define WIRING_ENCODER_B_PIN 7

// Pins of port B.
#define WIRING_ENABLE_PIN  0
#define WIRING_STOP_PIN    1 ///< its interrupt is EXTI1's
#define WIRING_DRIVES_PIN  5
#define WIRING_SEND_PIN    6 ///< USART1's are 6 and 7
#define WIRING_RECEIVE_PIN 7
#define WIRING_READY_PIN   8
#define WIRING_FAULT_PIN   12 ///< TIM1's break input; 10 to 15 share an interrupt

#ifndef WIRING_LEGS
#define WIRING_LEGS 2 ///< legs of the bridge: 2, or 3 with a law of three phases (bridge/bridge.h)
#endif

#endif
