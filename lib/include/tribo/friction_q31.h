/// Hub friction of a constrained arm in Q31, equation for equation as in friction_f32.h.
///
/// Forces are Q31 of one full scale FS. The net force saturates at FS (counted), where friction has long reached its
/// breakaway. The rate v enters as the change of |n| a tick, exact to the last bit.
///
///     k(v)       exponent (2/ln 2) m (v/v0 - 1) in Q22; 2^-|exponent| in Q32 by the polynomial of friction_f32_step.h;
///                k 2^-S in Q32, S the smallest that fits k_max + k_min
///     n/(k L)    as a fraction of two numbers of 32 bits, the larger one normalised
///     f          n less the rational function of friction_f32.h, coefficients Q32
///
/// Against the model in double: f within 5e-7 N at a full scale of 2 N for the paper's parameters (tests/contract).
/// By dense search: k L tanh(n/(k L)) is within 9e-7 of itself and 4 LSB (23 at k_max/k_min = 900), k(v) within the bound
/// that friction_f32.h gives: 1.5e-6 of k_max - k_min up to m = 20, 4.5e-6 at m = 100 (tests/unit/test_friction_q31.c).
/// Symmetric parameters give f(-u, -F) = -f(u, F) exactly, and |f| <= |n|, |f| <= L always.
/// Where offset + slope |F| is beyond FS, L is FS.
/// One 32-bit division, two with a table, and no loop but the one over a table's points. Not synchronized: one state,
/// one tick.

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
    uint32_t offset; ///< Q31, over 0
    uint32_t slope;  ///< its fraction, Q32
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
    uint32_t                           rise_max;         ///< a larger rise of |n| makes E 2^32 or more, as this does
    uint32_t                           exponent_rate;    ///< of E = 2^exponent, per rise 2^rise_shift, Q54
    int32_t                            exponent_at_rest; ///< minus the exponent of no rise, Q22
    uint32_t                           k_min, k_max;     ///< times 2^-S, Q32
    tribo_breakaway_q31_t              law[2];           ///< L+, L-
    const tribo_breakaway_point_q31_t *table;            ///< null: the affine laws
    uint32_t                           set_level;        ///< c1, Q32; 1 is a bit less
    uint32_t                           reset_level;      ///< c2, Q32
    int32_t                            gravity;          ///< Q31
    uint8_t                            law_whole[2];     ///< the slopes' whole parts, 0 to 10
    uint8_t                            rise_shift;       ///< 1 to 31
    uint8_t                            k_shift;          ///< S
    bool                               is_shallow;       ///< no table, slopes below 1, no L beyond FS
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
    int32_t n;      ///< net force, Q31
    int32_t L;      ///< breakaway on the side of n, Q31
    int32_t rise;   ///< |n[k]| - |n[k-1]|, which is v h, Q31
    int32_t f;      ///< friction, Q31
    uint8_t relays; ///< TRIBO_RELAY_Q1, _Q2 and, for Eq. (8), _Q
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
