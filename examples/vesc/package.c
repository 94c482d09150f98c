// A native package for the VESC: a force loop at 1 kHz in its own thread. The load cell's amplifier is on ADC1.

#include "vesc_c_if.h"

HEADER

#define OFFSET_V     1.65f
#define N_PER_V      1.5f
#define AMPERE_PER_N 4.0f
#define PERIOD_S     0.001f
#define STACK        4096u
#define OFF_DELAY_S  0.02f // the current stays on for this time without a command
#define BAD_MAX      20u   // bad readings in succession before the thread ends

float reference_n(void); // write this: read an app, a CAN frame or a Lisp extension

// [add
#include "tribo/feedforward_f32.h"

typedef struct
{
    lib_thread                     thread;
    tribo_force_loop_f32_params_t  params; // made at run time: const pointers would need relocation
    tribo_feedforward_f32_params_t feedforward;
    tribo_guard_f32_params_t       guard_params;
    tribo_force_loop_f32_state_t   loop;
    tribo_feedforward_f32_memory_t memory;
    uint32_t                       bad;
} axis_t;

static bool make(axis_t *axis)
{
    tribo_force_loop_f32_config_t rig = tribo_force_loop_f32_paper(); // change every value that differs on your rig
    const tribo_feedforward_f32_config_t method = tribo_feedforward_f32_default();
    const tribo_guard_f32_config_t       limits = tribo_guard_f32_default();
    rig.sample_time_s = PERIOD_S; // the paper's controller is refused at every other sample time
    rig.method        = tribo_feedforward_f32_use(&axis->feedforward, &method);
    rig.guard         = tribo_guard_f32_use(&axis->guard_params, &limits);
    axis->bad         = 0;
    axis->loop        = (tribo_force_loop_f32_state_t){.memory = &axis->memory.state.tick};
    return tribo_force_loop_f32_init(&axis->params, &rig) == TRIBO_OK &&
           tribo_force_loop_f32_start(&axis->loop, &axis->params, false) == TRIBO_OK;
}

static void tick(axis_t *axis)
{
    const uint32_t before = axis->loop.bad_inputs;
    const float    y      = (VESC_IF->io_read_analog(VESC_PIN_ADC1) - OFFSET_V) * N_PER_V;
    const float    u      = tribo_force_loop_f32_step(&axis->params, &axis->loop, reference_n(), y, NULL);
    tribo_feedforward_f32_learn(&axis->params, &axis->memory);
    axis->bad = axis->loop.bad_inputs != before ? axis->bad + 1u : 0u;
    VESC_IF->timeout_reset();
    VESC_IF->mc_set_current_off_delay(OFF_DELAY_S);
    VESC_IF->mc_set_current(u * AMPERE_PER_N);
}
// add]

/// Sleeps for most of the remaining period and busy-waits for the rest, because a sleep ends on a 100 us tick.
static void wait(uint32_t since)
{
    const float most = PERIOD_S - 0.0002f - VESC_IF->timer_seconds_elapsed_since(since);
    if (most > 0.0f)
    {
        VESC_IF->sleep_us((uint32_t)(most * 1e6f));
    }
    const float rest = PERIOD_S - VESC_IF->timer_seconds_elapsed_since(since);
    if (rest > 0.0f)
    {
        VESC_IF->timer_sleep(rest);
    }
}

static void run(void *argument)
{
    axis_t *axis = argument;
    bool    good = make(axis);
    for (uint32_t start = VESC_IF->timer_time_now(); good && !VESC_IF->should_terminate();
         start          = VESC_IF->timer_time_now())
    {
        tick(axis);
        wait(start);
        good = VESC_IF->mc_get_fault() == FAULT_CODE_NONE && axis->bad < BAD_MAX;
    }
    VESC_IF->mc_set_current(0.0f);
}

static void stop(void *argument)
{
    axis_t *axis = argument;
    VESC_IF->request_terminate(axis->thread);
    VESC_IF->free(axis);
}

INIT_FUN(lib_info *info)
{
    INIT_START
    axis_t *axis = VESC_IF->malloc(sizeof *axis);
    if (axis == NULL)
    {
        return false;
    }
    info->stop_fun = stop;
    info->arg      = axis;
    axis->thread   = VESC_IF->spawn(run, STACK, "tribo", axis);
    return axis->thread != NULL;
}
