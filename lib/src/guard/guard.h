// A guard's verdict at a reversal of friction, for both arithmetics; see guard_f32.h.

#ifndef TRIBO_GUARD_GUARD_H
#define TRIBO_GUARD_GUARD_H

#include "tribo/force_loop_f32.h"

#include <stdbool.h>
#include <stdint.h>

#define GUARD_TURNS  16u
#define GUARD_STRAYS 4u

/// The number in succession, including this one.
static inline uint8_t guard_count(uint8_t before, bool one_more, uint8_t most)
{
    const uint8_t after = before < most ? (uint8_t)(before + 1u) : most;
    return one_more ? after : 0u;
}

static inline tribo_guard_cause_t guard_judge(tribo_guard_cause_t latched, uint8_t turns, uint8_t strays)
{
    if (latched != TRIBO_GUARD_NONE)
    {
        return latched == TRIBO_GUARD_HUNTING ? latched : TRIBO_GUARD_OVERSHOOT; // also for a corrupt one
    }
    if (turns >= GUARD_TURNS)
    {
        return TRIBO_GUARD_HUNTING;
    }
    return strays >= GUARD_STRAYS ? TRIBO_GUARD_OVERSHOOT : TRIBO_GUARD_NONE;
}

#endif
