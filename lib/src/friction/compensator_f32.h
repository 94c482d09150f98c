// The compensator in single precision: what compensator.h needs. The arm keeps F^ within TRIBO_F32_FORCE_MAX_N.

#ifndef TRIBO_FRICTION_COMPENSATOR_F32_H
#define TRIBO_FRICTION_COMPENSATOR_F32_H

#include "tribo/friction_f32.h"

#include "../number/words_f32.h"
#include "arm_f32.h"
#include "law_f32.h"

static inline force_t force_of_arm(const tribo_arm_f32_state_t *arm)
{
    return arm->force_n;
}

static inline void place_arm(tribo_arm_f32_state_t *arm, force_t F)
{
    arm->force_n = F;
}

/// The counter that a step of friction may change, for compensator_peek.
static inline uint32_t *friction_counter(tribo_friction_f32_state_t *friction)
{
    return &friction->bad_inputs;
}

#include "compensator.h"

#endif
