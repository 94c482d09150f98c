/// The functions that a board provides to the loop. simulated_board.c implements them for QEMU; replace it with your own.
/// The tick calls all of them at 1 kHz.

#ifndef EXAMPLES_BARE_BOARD_H
#define EXAMPLES_BARE_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#ifdef BOARD_Q31
typedef int32_t board_force_t; ///< 2^31 is RIG_FULL_SCALE_N
#define BOARD_NO_FORCE INT32_MIN
#else
typedef float board_force_t; ///< N
#define BOARD_NO_FORCE (1e9f)
#endif

#define BOARD_CORE_HZ 25000000u ///< clock of SysTick

board_force_t board_reference(void);          ///< the target force
board_force_t board_force(void);              ///< reading; BOARD_NO_FORCE, which leaves u open loop, if there is none
void          board_command(board_force_t u); ///< force at the end point; times A/N it is the motor's current
bool board_is_healthy(void); ///< current and bus voltage are within limits, and the sensor has answered recently
void board_off(void);        ///< no current until the next reset

void loop_start(void);
void loop_tick(void);

#endif
