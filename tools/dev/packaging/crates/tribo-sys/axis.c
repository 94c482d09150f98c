// An axis of one rig, whose size Rust knows. In Rust a value may move at any time, so each step sets the pointers into itself anew.

#include RIG

#define AXIS_BYTES 1024u // of Axis in src/lib.rs

typedef struct
{
    tribo_force_loop_f32_state_t   loop;
    tribo_feedforward_f32_memory_t memory;
    tribo_guard_f32_state_t        guard;
} tribo_axis_t;

_Static_assert(sizeof(tribo_axis_t) <= AXIS_BYTES, "Axis in src/lib.rs is too small");
_Static_assert(_Alignof(tribo_axis_t) <= 8, "Axis in src/lib.rs is not aligned enough");

const float tribo_axis_period_s = RIG_SAMPLE_TIME_S;

void  tribo_axis_start(tribo_axis_t *axis);
float tribo_axis_step(tribo_axis_t *axis, float r, float y);
int   tribo_axis_guard(const tribo_axis_t *axis);

void tribo_axis_start(tribo_axis_t *axis)
{
    tribo_force_loop_f32_reset(&axis->loop);
    tribo_feedforward_f32_reset(&axis->memory.state);
    tribo_force_loop_feedforward_f32_attach(&axis->loop, &axis->memory);
    tribo_guard_f32_reset(&axis->guard);
    tribo_guard_f32_attach(&axis->loop, &axis->guard);
}

float tribo_axis_step(tribo_axis_t *axis, float r, float y)
{
    axis->loop.memory      = &axis->memory;
    axis->loop.memory_seal = ~(uintptr_t)axis->loop.memory;
    axis->loop.guard       = &axis->guard;
    axis->loop.guard_seal  = ~(uintptr_t)axis->loop.guard;
    const float u          = tribo_force_loop_f32_step(&rig_params, &axis->loop, r, y, NULL);
    tribo_feedforward_f32_learn(&rig_params, &axis->memory);
    return u;
}

int tribo_axis_guard(const tribo_axis_t *axis)
{
    return (int)axis->guard.cause;
}
