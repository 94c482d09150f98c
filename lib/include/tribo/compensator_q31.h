/// Friction compensator of Fig. 11 in Q31, as compensator_f32.h has it. Not synchronized: one state, one tick.

#ifndef TRIBO_COMPENSATOR_Q31_H
#define TRIBO_COMPENSATOR_Q31_H

#include "tribo/arm_q31.h"
#include "tribo/friction_q31.h"
#include "tribo/lugre_q31.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct
{
    tribo_friction_q31_params_t friction;
    tribo_arm_q31_params_t      arm;
} tribo_compensator_q31_params_t;

/// Of the friction model that the compensator has. The first two members of both are alike.
typedef union
{
    tribo_friction_q31_state_t paper;
    tribo_lugre_q31_state_t    lugre; ///< compensator_lugre_q31.h
} tribo_compensator_friction_q31_state_t;

typedef struct
{
    tribo_compensator_friction_q31_state_t friction; ///< counts the bad inputs
    tribo_arm_q31_state_t                  arm;
} tribo_compensator_q31_state_t;

/// What one step saw, for logging.
typedef struct
{
    int32_t                      force;    ///< F^ at the start of the tick, Q31
    tribo_friction_q31_signals_t friction; ///< with f^
} tribo_compensator_q31_signals_t;

/// Friction and arm at rest, counters 0.
void tribo_compensator_q31_reset(tribo_compensator_q31_state_t *state);

/// Estimated friction f^ for the manipulated input `u` as applied, after the actuator limit, both Q31. Cannot fail.
/// `signals` is written whole and must not be null.
int32_t tribo_compensator_q31_step(const tribo_compensator_q31_params_t *params,
                                   tribo_compensator_q31_state_t        *state,
                                   int32_t                               u,
                                   tribo_compensator_q31_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
