// Every wait has a time-out, counted in loop turns of about 10 cycles. Each caller handles the time-out.

#ifndef STM32F405_WAIT_H
#define STM32F405_WAIT_H

#include "device.h"
#include "registers.h"

#include <stdbool.h>
#include <stdint.h>

#define WAIT_TURNS 100000u

static inline bool wait_for_turns(const reg_t *reg, uint32_t mask, uint32_t value, uint32_t turns)
{
    for (uint32_t turn = 0; turn < turns; turn++)
    {
        if ((*reg & mask) == value)
        {
            return true;
        }
    }
    return false;
}

static inline bool wait_for(const reg_t *reg, uint32_t mask, uint32_t value)
{
    return wait_for_turns(reg, mask, value, WAIT_TURNS);
}

/// Turns a peripheral's clock on and waits. A peripheral may ignore a write in the first cycles of its clock (RM0090), and the
/// read-back alone is too short a wait.
static inline void clock_on(reg_t *enable, uint32_t bits)
{
    *enable |= bits;
    (void)*enable;
    __DSB();
}

#endif
