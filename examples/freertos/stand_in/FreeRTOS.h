/// A stand-in for FreeRTOS: only the part that force_task.c uses.

#ifndef EXAMPLES_STAND_IN_FREERTOS_H
#define EXAMPLES_STAND_IN_FREERTOS_H

#include <stdint.h>

typedef uint32_t TickType_t;
typedef long     BaseType_t;

#define pdFALSE           ((BaseType_t)0)
#define pdMS_TO_TICKS(ms) ((TickType_t)(ms))

#endif
