// A force loop as a task of FreeRTOS, at 1 kHz.

#include "FreeRTOS.h"
#include "task.h"

#include <stdbool.h>

#define AMPERE_PER_N 0.8f
#define BAD_MAX      20u // readings in succession

float reference_n(void);          // yours
float read_force_n(void);         // yours; NAN if there is no reading
void  command_ampere(float i);    // yours
void  motor_off(void);            // yours
bool  motor_is_healthy(void);     // yours: current, bus voltage, temperature
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
    // A tick that is due already when the last one has ended: xTaskDelayUntil does not wait, and says so.
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
