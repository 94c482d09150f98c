/// What the loop needs of a board. simulated_board.c is one; yours takes its place. All are called from the tick, at 1 kHz.

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

board_force_t board_reference(void);          ///< the force that is wanted
board_force_t board_force(void);              ///< the sensor's; BOARD_NO_FORCE if it does not answer: then u coasts
void          board_command(board_force_t u); ///< force at the end point; times A/N it is the motor's current
bool          board_is_healthy(void); ///< current and bus voltage within limits, and the sensor has answered lately
void          board_off(void);        ///< no current until the next reset

void loop_start(void);
void loop_tick(void);

#endif
