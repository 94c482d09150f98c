/// Hub friction of a constrained arm in Q31: the twin of friction_f32.h, equation for equation.
///
/// Forces are Q31 of one full scale FS. The net force saturates at FS (counted), where friction has long reached its
/// breakaway. The rate v enters as the change of |n| a tick, exact to the last bit.
///
///     k(v)        6 k 2^-S in Q31, S the smallest that fits k_max; tanh(m (v/v0 - 1)) from its argument over 6, in Q31
///     n / (6 k L) in Q31, bounded by 1: beyond, f is at its breakaway for every k over 1
///     tanh(x)/x   the minimax rational of friction_f32.c in (x/6)^2, coefficients Q26
///
/// Against the model in double: f within 5e-7 N at a full scale of 2 N for the paper's parameters (tests/contract).
/// Over all 2^31 arguments up to |x| = 6, against libm: tanh(x)/x within 3.3e-7 of itself, tanh(x) within 3.2e-7 and
/// below 1; beyond, tanh is held 1.2e-5 below 1. Hence k L tanh(n/(k L)) is within 3.3e-7 of itself and 4 LSB, k(v) within
/// 1.2e-5 (k_max - k_min)/2 (tests/unit/test_friction_q31.c searches both densely).
/// Symmetric parameters give f(-u, -F) = -f(u, F) exactly, and |f| <= |n|, |f| <= L always.
/// Three 32-bit divisions, no loop but the one over a table's points. Not synchronized: one state, one tick.

#ifndef TRIBO_FRICTION_Q31_H
#define TRIBO_FRICTION_Q31_H

#include "tribo/q31.h"
#include "tribo/relay.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Breakaway in one direction, L(F) = offset + slope |F|, at most FS.
typedef struct
{
    int32_t offset; ///< Q31, over 0
    int32_t slope;  ///< Q27, 0 to 10
} tribo_breakaway_q31_t;

/// One point of a breakaway table, all Q31.
typedef struct
{
    int32_t force;    ///< |F|, strictly rising from point to point
    int32_t positive; ///< L+, over 0
    int32_t negative; ///< L-, over 0
} tribo_breakaway_point_q31_t;

/// What a step reads, made by tribo_force_loop_q31_init or its kin (quantize_q31.h).
typedef struct
{
    int32_t                            rate;   ///< m h^-1 / (6 v0) per FS: mantissa ...
    int32_t                            m;      ///< m / 6, Q26
    int32_t                            k_mean; ///< 6 (k_max + k_min)/2 2^-S, Q31
    int32_t                            k_half; ///< 6 (k_max - k_min)/2 2^-S, Q31
    tribo_breakaway_q31_t              positive, negative;
    const tribo_breakaway_point_q31_t *table;       ///< null: the affine laws
    int32_t                            set_level;   ///< c1, Q30
    int32_t                            reset_level; ///< c2, Q30
    int32_t                            gravity;     ///< Q31
    uint8_t                            rate_shift;  ///< ... and its exponent: rate 2^-rate_shift, 0 to 62
    uint8_t                            k_shift;     ///< S
    uint8_t                            table_length;
    uint8_t                            pulse_width; ///< samples
} tribo_friction_q31_params_t;

typedef struct
{
    int32_t             n;         ///< n[k-1], Q31
    uint32_t            saturated; ///< net forces clamped since reset; stops at UINT32_MAX
    tribo_relay_state_t relay;
} tribo_friction_q31_state_t;

/// What one step saw, for logging.
typedef struct
{
    int32_t n;         ///< net force, Q31
    int32_t L;         ///< breakaway on the side of n, Q31
    int32_t rise;      ///< |n[k]| - |n[k-1]|, which is v h, Q31
    int32_t f;         ///< friction, Q31
    bool    q1, q2, q; ///< relays and Eq. (8)
} tribo_friction_q31_signals_t;

/// At rest: n[-1] = 0, relays low, counter 0.
void tribo_friction_q31_reset(tribo_friction_q31_state_t *state);

/// Friction at manipulated input `u` and end-point force `force`, all Q31. Cannot fail.
/// `signals` is written whole and must not be null.
int32_t tribo_friction_q31_step(const tribo_friction_q31_params_t *params,
                                tribo_friction_q31_state_t        *state,
                                int32_t                            u,
                                int32_t                            force,
                                tribo_friction_q31_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
