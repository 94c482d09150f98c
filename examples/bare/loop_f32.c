// The loop on a core with an FPU.

#include "board.h"
// [add
#include "rig_1khz_f32.h"

static tribo_force_loop_f32_state_t   loop;
static tribo_feedforward_f32_memory_t memory; // what the loop has learned

void loop_start(void)
{
    loop.memory = &memory.state.tick;
    (void)tribo_force_loop_f32_start(&loop, &rig_params, false);
}

void loop_tick(void)
{
    board_command(tribo_force_loop_f32_step(&rig_params, &loop, board_reference(), board_force(), NULL));
    tribo_feedforward_f32_learn(&rig_params, &memory);
}
// add]
