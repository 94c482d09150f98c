// The compensator in Q31: what compensator.h needs. All forces are Q31 of one full scale, except that the arm holds F
// in Q59.

#ifndef TRIBO_FRICTION_COMPENSATOR_Q31_H
#define TRIBO_FRICTION_COMPENSATOR_Q31_H

#include "tribo/friction_q31.h"

#include "../number/words_q31.h"
#include "arm_q31.h"
#include "law_q31.h"

static inline force_t force_of_arm(const tribo_arm_q31_state_t *arm)
{
    return tribo_arm_q31_force(arm);
}

static inline void place_arm(tribo_arm_q31_state_t *arm, force_t F)
{
    arm->force = (int64_t)F * (INT64_C(1) << ARM_Q31_FRACTION);
}

/// The counter that a step of friction may change, for compensator_peek.
static inline uint32_t *friction_counter(tribo_friction_q31_state_t *friction)
{
    return &friction->saturated;
}

#include "compensator.h"

#endif
