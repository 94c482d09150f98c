/// Hub friction of a constrained arm, single precision, Eqs. (3) to (6), (8), (9):
///
///     n = u - F + g                                     net force
///     v = (|n[k]| - |n[k-1]|) / h                       net-force rate, Eq. (6)
///     k = (k_max + k_min)/2 - (k_max - k_min)/2 tanh(m (v/v0 - 1))             Eq. (5)
///     f = sat( k L tanh(n / (k L)) )   when Q           Eq. (3)
///     f = sat( n )                     otherwise
///     Q = v > 0 and ((n > 0 and Q2) or (n < 0 and Q1))  Eq. (8)
///     sat(x) = min(L+, max(-L-, x)); L is L+ for n >= 0, else L-               Eq. (4)
///
/// While f holds against n the arm sticks: f = n. Breakaway L grows with the applied force F.
/// After the net force has been deep on the other side (Q), f falls short of n on its way back:
/// the hysteresis inside stiction. Symmetric parameters give f(-u, -F) = -f(u, F) exactly.
///
/// Eq. (5) is computed as the same curve in the form k = (k_max + k_min E)/(1 + E), E = e^(2 m (v/v0 - 1)), and Eq. (3) as
/// n less a rational function of (n/(k L))^2. f is within 1.2e-6 of itself for that k. k is within (1 + m/12) 1e-6 of
/// k_max - k_min and 2e-7 of itself: the steeper k(v), the more the rounding of E's exponent counts. That is 2e-6 up to
/// m = 20 and 7.8e-6 at m = 100 (tests/unit/test_friction_f32.c measures both). |f| <= L and |f| <= |n| always.
/// One division (two with a table), no loop but the one over a breakaway table's points, always all of them.
/// Not synchronized: one state, one tick.

#ifndef TRIBO_FRICTION_F32_H
#define TRIBO_FRICTION_F32_H

#include "tribo/force_f32.h"
#include "tribo/relay.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TRIBO_BREAKAWAY_POINTS_MAX 32u ///< longest breakaway table

/// Breakaway in one direction as an affine law, L(F) = offset + slope |F|.
typedef struct
{
    float offset_n; ///< 1e-6 to 1e6 N
    float slope;    ///< 0 to 10
} tribo_breakaway_f32_t;

/// One point of a breakaway table: at applied force |F|, the breakaway in both directions.
typedef struct
{
    float force_n;    ///< |F|, 0 to 1e6 N, strictly rising from point to point
    float positive_n; ///< L+, 1e-6 to 1e6 N
    float negative_n; ///< L-, 1e-6 to 1e6 N
} tribo_breakaway_point_f32_t;

typedef struct
{
    float                              k_min;      ///< 1.01 to k_max; hysteresis is widest here
    float                              k_max;      ///< 1.01 to 1000
    float                              m;          ///< 0 to 100; steepness of k(v)
    float                              v0_n_per_s; ///< 1e-6 to 1e6 N/s; centre of k(v)
    tribo_breakaway_f32_t              positive;   ///< L+; not read when there is a table
    tribo_breakaway_f32_t              negative;   ///< L-; not read when there is a table
    const tribo_breakaway_point_f32_t *table;      ///< null, or points that live as long as the params;
                                                   ///< linear between them, clamped at both ends
    uint32_t table_length;                         ///< points in the table, 1 to TRIBO_BREAKAWAY_POINTS_MAX
    float    set_level;                            ///< c1, over 0 to 1, as a fraction of L
    float    reset_level;                          ///< c2, over 0 to 1, as a fraction of L
    float    pulse_width_s;                        ///< of the edge detectors, 1 to 63 samples once rounded
    float    gravity_n;                            ///< g, -1e6 to 1e6 N
} tribo_friction_f32_config_t;

/// k(v) 1.57 (1 + p) / 8 = at_0 + per_power p / 8, p = 2^-|exponent|; see friction_f32_step.h.
typedef struct
{
    float at_0, per_power;
} tribo_friction_f32_k_t;

/// What a step reads, made by tribo_friction_f32_init. Const from then on; may be shared.
typedef struct
{
    float                  rate_hz;                             ///< 1/h
    float                  exponent_per_rise, exponent_at_rest; ///< of E = 2^(exponent_per_rise v h - exponent_at_rest)
    tribo_friction_f32_k_t k[2];                                ///< for an exponent from 0, and below
    tribo_breakaway_f32_t  law[2];                              ///< L+, L-
    const tribo_breakaway_point_f32_t *table;                   ///< null: the affine laws
    float                              set_level, reset_level;
    float                              gravity_n;
    uint8_t                            table_length;
    uint8_t                            pulse_width; ///< samples
} tribo_friction_f32_params_t;

typedef struct
{
    float               n_n;        ///< n[k-1]
    uint32_t            bad_inputs; ///< steps with a bad input since reset; stops at UINT32_MAX
    tribo_relay_state_t relay;
} tribo_friction_f32_state_t;

/// What one step saw, for logging.
typedef struct
{
    float   n_n;       ///< net force
    float   L_n;       ///< breakaway on the side of n
    float   v_n_per_s; ///< net-force rate
    float   f_n;       ///< friction
    uint8_t relays;    ///< TRIBO_RELAY_Q1, _Q2 and, for Eq. (8), _Q
} tribo_friction_f32_signals_t;

/// The paper's parameters, Eqs. (7), (9), (10), and its 3 ms pulse.
tribo_friction_f32_config_t tribo_friction_f32_paper(void);

/// Checks `config` field by field and computes `params` for a sample time of 1e-6 to 0.1 s.
/// Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME or the status of the first field that is
/// wrong. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_friction_f32_init(tribo_friction_f32_params_t       *params,
                                       const tribo_friction_f32_config_t *config,
                                       float                              sample_time_s);

/// At rest: n[-1] = 0, relays low, counters 0.
void tribo_friction_f32_reset(tribo_friction_f32_state_t *state);

/// Friction in N at manipulated input `u_n` and end-point force `force_n`, both in N. Cannot fail:
/// with a bad input (NaN, or beyond TRIBO_F32_FORCE_MAX_N) n stays as it was, a bad force counts as 0
/// in L(F), and the step is counted. `signals` is written whole and must not be null.
float tribo_friction_f32_step(const tribo_friction_f32_params_t *params,
                              tribo_friction_f32_state_t        *state,
                              float                              u_n,
                              float                              force_n,
                              tribo_friction_f32_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
