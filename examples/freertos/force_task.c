// A FreeRTOS task that runs the force loop at 1 kHz.

#include "FreeRTOS.h"
#include "task.h"

#include <stdbool.h>

#define AMPERE_PER_N 0.8f
#define BAD_MAX      20u // consecutive bad readings before the task stops

// Write these five functions.
float reference_n(void);
float read_force_n(void); // returns NAN if there is no reading
void  command_ampere(float i);
void  motor_off(void);
bool  motor_is_healthy(void);     // checks current, bus voltage and temperature
void  force_task(void *argument); // xTaskCreate(force_task, "force", 512, NULL, configMAX_PRIORITIES - 1, NULL)

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

void force_task(void *argument)
{
    (void)argument;
    TickType_t woken = xTaskGetTickCount();
    unsigned   bad   = 0;
    start();
    // If the next tick is already due when the last one ends, xTaskDelayUntil does not wait and returns pdFALSE.
    while (xTaskDelayUntil(&woken, pdMS_TO_TICKS(1)) != pdFALSE && motor_is_healthy() && bad < BAD_MAX)
    {
        const uint32_t before = loop.bad_inputs;
        // [add
        command_ampere(AMPERE_PER_N *
                       tribo_force_loop_f32_step(&rig_params, &loop, reference_n(), read_force_n(), NULL));
        tribo_feedforward_f32_learn(&rig_params, &memory);
        // add]
        bad = loop.bad_inputs != before ? bad + 1u : 0u;
    }
    motor_off();
    vTaskSuspend(NULL);
}
