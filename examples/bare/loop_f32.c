// The loop on a core with an FPU.

#include "board.h"
// [add
#include "rig_1khz_f32.h"

static tribo_force_loop_f32_state_t   loop;
static tribo_feedforward_f32_memory_t memory; // what it has learned
static tribo_guard_f32_state_t        guard;

void loop_start(void)
{
    tribo_force_loop_f32_reset(&loop);
    tribo_feedforward_f32_reset(&memory.state);
    tribo_force_loop_feedforward_f32_attach(&loop, &memory);
    tribo_guard_f32_reset(&guard);
    tribo_guard_f32_attach(&loop, &guard);
}

void loop_tick(void)
{
    board_command(tribo_force_loop_f32_step(&rig_params, &loop, board_reference(), board_force(), NULL));
    tribo_feedforward_f32_learn(&rig_params, &memory);
}
// add]
