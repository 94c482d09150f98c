/// A stand-in for FreeRTOS' task.h: only the part that force_task.c uses.

#ifndef EXAMPLES_STAND_IN_TASK_H
#define EXAMPLES_STAND_IN_TASK_H

#include "FreeRTOS.h"

#include <stddef.h>

TickType_t xTaskGetTickCount(void);
BaseType_t xTaskDelayUntil(TickType_t *woken, TickType_t ticks);
void       vTaskSuspend(void *task);

#endif
