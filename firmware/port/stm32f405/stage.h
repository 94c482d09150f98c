/// The power stage and the converters, of which an image has one of two:
///
///     stage_analog.c    somebody else's stage takes a command from the DAC
///     stage_bridge.c    the board is the bridge: TIM1 and the current loop of bridge/
///
/// board.c has what both share: enable, stops, the supply. STAGE_BRIDGE is 1 in an image with the bridge.

#ifndef STM32F405_STAGE_H
#define STM32F405_STAGE_H

#include "app/config.h"
#include "app/loop.h"
#include "convert.h"
#include "port/port.h"

#include <stdbool.h>
#include <stdint.h>

#if STAGE_BRIDGE
#define STAGE_OUTPUT_RANGE CONVERT_BRIDGE_RANGE ///< ampere
#define STAGE_OWN_INPUTS   PORT_INPUT_NOT_READY ///< that no pin says
#define STAGE_SLOW_CLOCK   false                ///< 16 MHz are too slow for the current loop
#else
#define STAGE_OUTPUT_RANGE CONVERT_OUTPUT_RANGE
#define STAGE_OWN_INPUTS   0u
#define STAGE_SLOW_CLOCK   true
#endif

/// Pins, with the command at no current and nothing switched on. Keeps what it needs of `config` until the next power-up.
void stage_init(const drive_config_t *config, loop_force_t no_current);

/// Converters, timer and interrupt. `apb_hz` is APB2's clock.
void stage_start(uint32_t apb_hz);

/// No current, nothing switched on; from any priority, also from a fault handler.
void stage_off(void);

/// True if no switch can be on.
bool stage_is_off(void);

void stage_enable(bool on);
void stage_command(loop_force_t output);

/// PORT_INPUT_ bits that it finds itself.
uint32_t stage_inputs(void);

bool stage_read_sensor(loop_force_t *reading);
void stage_measure(port_measured_t *measured);

/// Whether `config` suits this stage beyond what the port's ranges say.
bool stage_suits(const drive_config_t *config, drive_config_error_t *error);

#endif
