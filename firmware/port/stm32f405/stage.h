/// The power stage and the converters. An image has one of two stages:
///
///     stage_analog.c    a separate power stage takes a command from the DAC
///     stage_bridge.c    the board is the bridge: TIM1 and the current loop of bridge/
///
/// board.c has the parts that both share: enable, stops, the supply. STAGE_BRIDGE is 1 in an image with the bridge.

#ifndef STM32F405_STAGE_H
#define STM32F405_STAGE_H

#include "app/config.h"
#include "app/loop.h"
#include "convert.h"
#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

#if STAGE_BRIDGE
#define STAGE_OUTPUT_RANGE CONVERT_BRIDGE_RANGE ///< in amperes
#define STAGE_OWN_INPUTS   PORT_INPUT_NOT_READY ///< inputs that come from the stage and not from a pin
#define STAGE_SLOW_CLOCK   false                ///< 16 MHz are too slow for the current loop
#else
#define STAGE_OUTPUT_RANGE CONVERT_OUTPUT_RANGE
#define STAGE_OWN_INPUTS   0u
#define STAGE_SLOW_CLOCK   true
#endif

/// Sets up the pins, with the command at no current and nothing switched on. Keeps the fields of `config` that it needs
/// until the next power-up.
void stage_init(const drive_config_t *config, loop_force_t no_current);

/// Starts converters, timer and interrupt. `apb_hz` is APB2's clock.
void stage_start(uint32_t apb_hz);

/// Turns the current to 0 and all switches off. Call it at any priority, even in a fault handler.
void stage_off(void);

/// Returns true if no switch can be on.
bool stage_is_off(void);

void stage_enable(bool on);
void stage_command(loop_force_t output);

/// Returns the PORT_INPUT_ bits that the stage finds itself.
uint32_t stage_inputs(void);

bool stage_read_sensor(loop_force_t *reading);
void stage_measure(port_measured_t *measured);

/// Returns whether `config` suits this stage, in addition to the port's ranges.
bool stage_suits(const drive_config_t *config, drive_config_error_t *error);

#endif
