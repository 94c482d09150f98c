// The loop of a generated header with the library behind it, for tests that drive a foreign rig with it.

#include LOOP_HEADER

#include <stddef.h>

static tribo_force_loop_f32_params_t  params;
static tribo_force_loop_f32_state_t   state;
static tribo_feedforward_f32_memory_t memory;

/// Nothing learned; without compensation the controller alone.
void loop_start(int compensated)
{
    params = loop_params;
    if (!compensated)
    {
        params.method = NULL; // the paper's, with a gain of 0
        params.gain   = 0.0f;
        params.guard  = NULL;
    }
    state.memory = &memory.state.tick;
    (void)tribo_force_loop_f32_start(&state, &params, false); // its memory is there
}

/// What the drive puts out.
double loop_step(double r, double y)
{
    const float u = tribo_force_loop_f32_step(&params, &state, (float)r, (float)y, NULL);
    (void)tribo_feedforward_f32_learn(&params, &memory);
    return (double)(LOOP_COMMAND_PER_N * u);
}
