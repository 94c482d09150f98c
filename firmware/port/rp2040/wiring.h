/// How the board is wired; a board of your own changes it here.
///
///     GPIO26   ADC0    force sensor; 0.33 to 2.97 V are -2 to 2 N in rig_config.h. A reading within 80 mV of a rail is out of range;
///                      a resistor pulls a broken wire there, to ground
///     GPIO27   ADC1    the motor's current, if drive_config_t.over_current_a is not 0; 0.2 V/A around 1.65 V (convert.h)
///     GPIO28   ADC2    the bridge's supply, for bus_low_v and bus_high_v; a twentieth of it
///     GPIO2    PWM1A   IN1 of an H-bridge driver: high for a positive force
///     GPIO3    PWM1B   IN2: high for a negative one. Both low: the motor is open. The driver keeps its own dead time
///     GPIO4    output  the driver's enable; a resistor to ground keeps it off through reset
///     GPIO5    input   emergency stop: closed to ground when released; open (or a broken wire) is active
///     GPIO6    input   the driver's fault output, active at drive_config_t.fault_level, to which an internal resistor of 50 kOhm
///                      pulls an open wire
///     GPIO7    output  high while UART0 sends: the driver-enable of an RS-485 transceiver
///     GPIO8    input   the driver's ready output, if ready_ms is not 0; an open wire is not ready
///     GPIO0,1  UART0   log and Modbus, 115200 8N1

#ifndef RP2040_WIRING_H
#define RP2040_WIRING_H

#define WIRING_SEND_PIN     0
#define WIRING_RECEIVE_PIN  1
#define WIRING_FORWARD_PIN  2 ///< channel A of a PWM slice ...
#define WIRING_BACKWARD_PIN 3 ///< ... and its channel B
#define WIRING_ENABLE_PIN   4
#define WIRING_STOP_PIN     5 ///< stop and fault are within 0 to 7, which share a register of interrupts
#define WIRING_FAULT_PIN    6
#define WIRING_DRIVES_PIN   7
#define WIRING_READY_PIN    8
#define WIRING_SENSOR_PIN   26

#define WIRING_SLICE 1 ///< slice of the PWM

#define WIRING_OSCILLATOR_HZ 12000000u ///< the PLLs' dividers in board.c are for this frequency

#endif
