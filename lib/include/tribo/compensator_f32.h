/// Friction compensator of Fig. 11, single precision. One step:
///
///     1. F^ = K theta^, the force of the arm model, never the noisy sensor
///     2. f^ = friction(u, F^)
///     3. the arm model advances one sample with u and f^ held
///
/// The caller adds gain * f^ to u at the next tick. Not synchronized: one state, one tick.

#ifndef TRIBO_COMPENSATOR_F32_H
#define TRIBO_COMPENSATOR_F32_H

#include "tribo/arm_f32.h"
#include "tribo/friction_f32.h"
#include "tribo/lugre_f32.h"
#include "tribo/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct
{
    tribo_friction_f32_config_t friction;
    tribo_arm_f32_config_t      arm;
} tribo_compensator_f32_config_t;

typedef struct
{
    tribo_friction_f32_params_t friction;
    tribo_arm_f32_params_t      arm;
} tribo_compensator_f32_params_t;

/// Of the friction model that the compensator has. The first two members of both are alike.
typedef union
{
    tribo_friction_f32_state_t paper;
    tribo_lugre_f32_state_t    lugre; ///< compensator_lugre_f32.h
} tribo_compensator_friction_f32_state_t;

typedef struct
{
    tribo_compensator_friction_f32_state_t friction; ///< counts the bad inputs
    tribo_arm_f32_state_t                  arm;
} tribo_compensator_f32_state_t;

/// What one step saw, for logging.
typedef struct
{
    float                        force_n;  ///< F^ at the start of the tick
    tribo_friction_f32_signals_t friction; ///< with f^
} tribo_compensator_f32_signals_t;

/// The paper's parameters, Eqs. (7), (9), (10).
tribo_compensator_f32_config_t tribo_compensator_f32_paper(void);

/// Checks `config` and computes `params`. Returns TRIBO_OK, TRIBO_ERR_NULL or what
/// tribo_friction_f32_init and then tribo_arm_f32_init say. Writes nothing unless TRIBO_OK.
tribo_status_t tribo_compensator_f32_init(tribo_compensator_f32_params_t       *params,
                                          const tribo_compensator_f32_config_t *config,
                                          float                                 sample_time_s);

/// Friction and arm at rest, counters 0.
void tribo_compensator_f32_reset(tribo_compensator_f32_state_t *state);

/// Estimated friction f^ in N for the manipulated input `u_n` in N as applied, after the actuator limit.
/// Cannot fail: with a bad `u_n` the net force stays as it was and the step is counted. A corrupt F^ starts
/// again from 0.
/// `signals` is written whole and must not be null.
float tribo_compensator_f32_step(const tribo_compensator_f32_params_t *params,
                                 tribo_compensator_f32_state_t        *state,
                                 float                                 u_n,
                                 tribo_compensator_f32_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
