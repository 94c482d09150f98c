// The loop of one rig as a shared library for force_loop.py. RIG is the header that tribo-sim params has made, with --name rig.

#include RIG

typedef struct
{
    tribo_force_loop_f32_state_t   loop;
    tribo_feedforward_f32_memory_t memory;
    tribo_guard_f32_state_t        guard;
} force_loop_t;

const float  force_loop_period_s = RIG_SAMPLE_TIME_S;
const size_t force_loop_size     = sizeof(force_loop_t);

void  force_loop_start(force_loop_t *self);
float force_loop_step(force_loop_t *self, float r, float y);
int   force_loop_guard(const force_loop_t *self);

void force_loop_start(force_loop_t *self)
{
    tribo_force_loop_f32_reset(&self->loop);
    tribo_feedforward_f32_reset(&self->memory.state);
    tribo_force_loop_feedforward_f32_attach(&self->loop, &self->memory);
    tribo_guard_f32_reset(&self->guard);
    tribo_guard_f32_attach(&self->loop, &self->guard);
}

float force_loop_step(force_loop_t *self, float r, float y)
{
    return tribo_force_loop_f32_step(&rig_params, &self->loop, r, y, NULL);
}

int force_loop_guard(const force_loop_t *self)
{
    return (int)self->guard.cause;
}
