/// The constrained arm, single precision, Eq. (2) with F = K theta:
///
///     I theta'' = u + g - K theta - b theta' - f
///
/// With the net force n = u - F + g the drive is d = n - f, which is exactly 0 while the arm sticks.
/// The state is F itself, in N, and G, its change a tick, so that the step is the exact zero-order-hold
/// solution written in differences (nothing is lost at a short sample time):
///
///     F += phi_d d + phi_g G
///     G  = gamma_d d + gamma_g G
///
/// F stays within +-TRIBO_F32_FORCE_MAX_N; where it is held there, G starts again from 0, and so does an F that is a NaN. F
/// recovers after clamping or corruption.
/// No loops, no divisions. Not synchronized: one state, one tick.

#ifndef TRIBO_ARM_F32_H
#define TRIBO_ARM_F32_H

#include "tribo/force_f32.h"
#include "tribo/status.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Any one unit of displacement serves: degrees (the paper), radians, metres.
typedef struct
{
    float inertia;   ///< I, over 0, N s^2 per unit
    float damping;   ///< b, 0 or more, N s per unit
    float stiffness; ///< K, over 0, N per unit; K h^2/I from 1e-9 to 1e4, b h/I at most 1e4
} tribo_arm_f32_config_t;

/// What a step reads, made by tribo_arm_f32_init. Const from then on; may be shared.
typedef struct
{
    float phi_d, phi_g;     ///< one sample's change of F
    float gamma_d, gamma_g; ///< the next G
} tribo_arm_f32_params_t;

typedef struct
{
    float    force_n;        ///< F = K theta
    float    force_change_n; ///< G = K theta' h
    uint32_t bad_inputs;     ///< since reset; stops at UINT32_MAX
    uint32_t clamped;        ///< F held at its end since reset; stops at UINT32_MAX
} tribo_arm_f32_state_t;

/// The paper's arm, Eq. (10), in degrees.
tribo_arm_f32_config_t tribo_arm_f32_paper(void);

/// Checks `config` and discretises it for a sample time of 1e-6 to 0.1 s. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_INERTIA, TRIBO_ERR_DAMPING, TRIBO_ERR_STIFFNESS or
/// TRIBO_ERR_ARM_TOO_FAST. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_arm_f32_init(tribo_arm_f32_params_t       *params,
                                  const tribo_arm_f32_config_t *config,
                                  float                         sample_time_s);

/// At rest at F = 0, counters 0.
void tribo_arm_f32_reset(tribo_arm_f32_state_t *state);

/// Advances one sample with the drive `drive_n` = n - f, in N, held, and returns the new F in N. Cannot
/// fail: a bad drive (NaN, or beyond 1e7 N) counts as 0 and is counted.
float tribo_arm_f32_step(const tribo_arm_f32_params_t *params, tribo_arm_f32_state_t *state, float drive_n);

#ifdef __cplusplus
}
#endif

#endif
