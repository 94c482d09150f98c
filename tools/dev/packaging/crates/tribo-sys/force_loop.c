// The loop of one rig, whose size Rust knows. In Rust a value may move at any time, so each step sets the pointers into itself anew.

#include RIG

#define FORCE_LOOP_BYTES 1024u // of ForceLoop in src/lib.rs

typedef struct
{
    tribo_force_loop_f32_state_t   state;
    tribo_feedforward_f32_memory_t memory;
} force_loop_t;

_Static_assert(sizeof(force_loop_t) <= FORCE_LOOP_BYTES, "ForceLoop in src/lib.rs is too small");
_Static_assert(_Alignof(force_loop_t) <= 8, "ForceLoop in src/lib.rs is not aligned enough");

const float tribo_sys_loop_period_s = RIG_SAMPLE_TIME_S;

void  tribo_sys_loop_start(force_loop_t *loop);
float tribo_sys_loop_step(force_loop_t *loop, float r, float y);
int   tribo_sys_loop_guard(const force_loop_t *loop);

void tribo_sys_loop_start(force_loop_t *loop)
{
    loop->state.memory = &loop->memory.state.tick;
    (void)tribo_force_loop_f32_start(&loop->state, &rig_params, false); // its memory is there
}

float tribo_sys_loop_step(force_loop_t *loop, float r, float y)
{
    loop->state.memory      = &loop->memory.state.tick;
    loop->state.memory_seal = ~(uintptr_t)loop->state.memory;
    const float u           = tribo_force_loop_f32_step(&rig_params, &loop->state, r, y, NULL);
    tribo_feedforward_f32_learn(&rig_params, &loop->memory);
    return u;
}

int tribo_sys_loop_guard(const force_loop_t *loop)
{
    return (int)loop->state.guard.cause;
}
