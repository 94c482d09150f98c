// A Zephyr thread that runs the force loop at 1 kHz.

#include <zephyr/kernel.h>

#define AMPERE_PER_N 0.8f
#define BAD_MAX      20u // consecutive bad readings before the thread ends

// Write these five functions.
float reference_n(void);
float read_force_n(void); // returns NAN if there is no reading
void  command_ampere(float i);
void  motor_off(void);
bool  motor_is_healthy(void); // checks current, bus voltage and temperature

// [add
#include "rig_1khz_f32.h"

static tribo_force_loop_f32_state_t   loop;
static tribo_feedforward_f32_memory_t memory;

static void start(void)
{
    loop.memory = &memory.state.tick;
    (void)tribo_force_loop_f32_start(&loop, &rig_params, false);
}
// add]

K_TIMER_DEFINE(period, NULL, NULL);

static void force_thread(void *a, void *b, void *c)
{
    ARG_UNUSED(a);
    ARG_UNUSED(b);
    ARG_UNUSED(c);
    unsigned bad = 0;
    start();
    k_timer_start(&period, K_MSEC(1), K_MSEC(1));
    // More than one expiry since the last call means that a tick was missed.
    while (k_timer_status_sync(&period) == 1u && motor_is_healthy() && bad < BAD_MAX)
    {
        const uint32_t before = loop.bad_inputs;
        // [add
        command_ampere(AMPERE_PER_N *
                       tribo_force_loop_f32_step(&rig_params, &loop, reference_n(), read_force_n(), NULL));
        tribo_feedforward_f32_learn(&rig_params, &memory);
        // add]
        bad = loop.bad_inputs != before ? bad + 1u : 0u;
    }
    k_timer_stop(&period);
    motor_off();
}

K_THREAD_DEFINE(force, 2048, force_thread, NULL, NULL, NULL, K_PRIO_COOP(0), K_FP_REGS, 0);
