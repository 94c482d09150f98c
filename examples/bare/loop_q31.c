// The loop on a core without an FPU.

#include "board.h"
// [add
#include "rig_1khz_q31.h"

static tribo_force_loop_q31_state_t   loop;
static tribo_feedforward_q31_memory_t memory; // what the loop has learned

void loop_start(void)
{
    loop.memory = &memory.state.tick;
    (void)tribo_force_loop_q31_start(&loop, &rig_params, false);
}

void loop_tick(void)
{
    board_command(tribo_force_loop_q31_step(&rig_params, &loop, board_reference(), board_force(), NULL));
    tribo_feedforward_q31_learn(&rig_params, &memory); // or in the background, with interrupts on
}
// add]
