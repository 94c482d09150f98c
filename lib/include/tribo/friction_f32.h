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
/// While f balances n the arm sticks: f = n. Breakaway L grows with the applied force F.
/// After the net force has been large with the other sign (Q), f stays below n as n returns:
/// the hysteresis inside stiction. Symmetric parameters give f(-u, -F) = -f(u, F) exactly.
///
/// Eq. (5) is computed as the same curve in the form k = (k_max + k_min E)/(1 + E), E = e^(2 m (v/v0 - 1)), and Eq. (3)
/// as n less a rational function of (n/(k L))^2. The relative error of f for that k is within 1.2e-6. The error of k is
/// within (1 + m/12) 1e-6 of k_max - k_min and 2e-7 of k: the rounding of E's exponent grows with the steepness of
/// k(v). That is 2e-6 up to m = 20 and 7.8e-6 at m = 100 (tests/unit/test_friction_f32.c measures both). |f| <= L and
/// |f| <= |n| always. One division (two with a table). The only loop is over a breakaway table's points, always all of
/// them. Not synchronized: one state, one tick.

#ifndef TRIBO_FRICTION_F32_H
#define TRIBO_FRICTION_F32_H

#include "tribo/parameters.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_friction_f32_params    tribo_friction_f32_params_t;
typedef struct tribo_friction_f32_state     tribo_friction_f32_state_t;
typedef struct tribo_arm_f32_params         tribo_arm_f32_params_t;
typedef struct tribo_arm_f32_state          tribo_arm_f32_state_t;
typedef struct tribo_compensator_f32_params tribo_compensator_f32_params_t;
typedef struct tribo_compensator_f32_state  tribo_compensator_f32_state_t;

/// Events of one sample. At rest the set lines are high and the reset lines are low.
#define TRIBO_RELAY_SET1   1u ///< n <  c1 L+
#define TRIBO_RELAY_SET2   2u ///< n > -c1 L-
#define TRIBO_RELAY_RESET1 4u ///< n rises and n[k-1] < -c2 L-
#define TRIBO_RELAY_RESET2 8u ///< n falls and n[k-1] >  c2 L+

/// Outputs of the relays.
#define TRIBO_RELAY_Q1 1u ///< armed for a fall: n was high
#define TRIBO_RELAY_Q2 2u ///< armed for a rise: n was low
#define TRIBO_RELAY_Q  4u ///< Eq. (8), in signals only: |n| rises with its relay armed

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
    TRIBO_FRICTION_PARAMETERS(
        TRIBO_FLOAT_MEMBER)                      ///< a float each, k_min to gravity_n; tribo/parameters.h explains them
    tribo_breakaway_f32_t              positive; ///< L+; ignored with a table
    tribo_breakaway_f32_t              negative; ///< L-; ignored with a table
    const tribo_breakaway_point_f32_t *table;    ///< null, or points that outlive the params;
                                                 ///< linear between them, clamped at both ends
    uint32_t         table_length; ///< points in the table, 1 to TRIBO_BREAKAWAY_POINTS_MAX; 0 without one
    tribo_refusal_t *refusal;      ///< the init writes it if it refuses a point of the table; may be null
} tribo_friction_f32_config_t;

/// Signals of one step, for logging.
typedef struct
{
    float   n_n;       ///< net force
    float   L_n;       ///< breakaway for the sign of n
    float   v_n_per_s; ///< net-force rate
    float   f_n;       ///< friction
    uint8_t relays;    ///< TRIBO_RELAY_Q1, _Q2 and, for Eq. (8), _Q
} tribo_friction_f32_signals_t;

/// The arm. Choose one unit of displacement: degrees (as the paper), radians or metres.
typedef struct
{
    float inertia;   ///< I, 1e-12 to 1e12 N s^2 per unit
    float damping;   ///< b, 0 to 1e12 N s per unit; b h/I at most 1e4
    float stiffness; ///< K, 1e-12 to 1e12 N per unit; K h^2/I 1e-9 to 1e4
} tribo_arm_f32_config_t;

typedef struct
{
    tribo_friction_f32_config_t friction;
    tribo_arm_f32_config_t      arm;
} tribo_compensator_f32_config_t;

/// Signals of one step, for logging.
typedef struct
{
    float                        force_n;  ///< F^ at the start of the tick
    tribo_friction_f32_signals_t friction; ///< contains f^
} tribo_compensator_f32_signals_t;

/// Checks `config` field by field and computes `params` for a sample time of 1e-6 to 0.1 s.
/// Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME or the status of the first wrong field.
/// Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_friction_f32_init(tribo_friction_f32_params_t       *params,
                                       const tribo_friction_f32_config_t *config,
                                       float                              sample_time_s);

/// Resets the friction to rest: n[-1] = 0, relays low, counters 0.
void tribo_friction_f32_reset(tribo_friction_f32_state_t *state);

/// Returns the friction in N at the manipulated input `u_n` and the end-point force `force_n`, both in N. Cannot fail:
/// with a bad input (NaN, or beyond TRIBO_F32_FORCE_MAX_N) n stays unchanged, a bad force counts as 0 in L(F), and the
/// step is counted. Writes all of `signals`, which must not be null.
float tribo_friction_f32_step(const tribo_friction_f32_params_t *params,
                              tribo_friction_f32_state_t        *state,
                              float                              u_n,
                              float                              force_n,
                              tribo_friction_f32_signals_t      *signals);

/// Resets the arm to rest at F = 0 and its counter to 0.
void tribo_arm_f32_reset(tribo_arm_f32_state_t *state);

/// Runs one sample of the arm, Eq. (2), during which the force `drive_n` = u - F + g - f is constant and finite.
/// Returns F at the end of the sample, within TRIBO_F32_FORCE_MAX_N. Cannot fail. `params` are part of
/// tribo_compensator_f32_params_t.
float tribo_arm_f32_step(const tribo_arm_f32_params_t *params, tribo_arm_f32_state_t *state, float drive_n);

/// Checks `config` and computes `params`. Returns TRIBO_OK, TRIBO_ERR_NULL, a status of tribo_friction_f32_init, or of
/// the arm. Writes nothing unless TRIBO_OK.
tribo_status_t tribo_compensator_f32_init(tribo_compensator_f32_params_t       *params,
                                          const tribo_compensator_f32_config_t *config,
                                          float                                 sample_time_s);

/// Resets friction and arm to rest and the counters to 0.
void tribo_compensator_f32_reset(tribo_compensator_f32_state_t *state);

/// Returns the estimated friction f^ in N for the applied manipulated input `u_n` in N, after the actuator's limit.
/// Cannot fail: with a bad `u_n` the net force stays unchanged and the step is counted. A corrupt F^ restarts from 0.
/// Writes all of `signals`, which must not be null.
float tribo_compensator_f32_step(const tribo_compensator_f32_params_t *params,
                                 tribo_compensator_f32_state_t        *state,
                                 float                                 u_n,
                                 tribo_compensator_f32_signals_t      *signals);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

#define TRIBO_EDGE_WIDTH_MAX 63u ///< longest pulse, in samples

typedef struct
{
    uint8_t line[TRIBO_EDGE_WIDTH_MAX + 1u]; ///< ring of past inputs
    uint8_t head;                            ///< index of the next input
} tribo_edge_state_t;

/// The two sample-and-hold elements.
typedef struct
{
    uint8_t held; ///< outputs; from bit 4 on the last triggers (set or reset of each element), to detect their rise
} tribo_relay_latch_t;

typedef struct
{
    tribo_edge_state_t  edge;
    tribo_relay_latch_t latch;
} tribo_relay_state_t;

/// k(v) 1.57 (1 + p) / 8 = at_0 + per_power p / 8, p = 2^-|exponent|; see src/friction/law_f32.h.
typedef struct
{
    float at_0, per_power;
} tribo_friction_f32_k_t;

/// Constants of a step, computed by tribo_friction_f32_init. Constant from then on; several loops may share them.
struct tribo_friction_f32_params
{
    float                  rate_hz;                             ///< 1/h
    float                  exponent_per_rise, exponent_at_rest; ///< E = 2^(exponent_per_rise v h - exponent_at_rest)
    tribo_friction_f32_k_t k[2];                                ///< for an exponent of 0 or more, and below 0
    tribo_breakaway_f32_t  law[2];                              ///< L+, L-
    const tribo_breakaway_point_f32_t *table;                   ///< null: the affine laws
    float                              set_level, reset_level;  ///< c1, c2
    float                              gravity_n;
    uint8_t                            table_length;
    uint8_t                            pulse_width; ///< samples
};

struct tribo_friction_f32_state
{
    float               n_n;        ///< n[k-1]
    uint32_t            bad_inputs; ///< steps with a bad input since reset; stops at UINT32_MAX
    tribo_relay_state_t relay;
};

/// The arm of tribo_compensator_f32_params_t; src/friction/arm_f32.h has the equations.
struct tribo_arm_f32_params
{
    float phi_d, phi_g;     ///< the change of F in a sample
    float gamma_d, gamma_g; ///< the next G
};

struct tribo_arm_f32_state
{
    float    force_n;        ///< F = K theta
    float    force_change_n; ///< G = K theta' h
    uint32_t clamped;        ///< samples with F at its limit since reset; stops at UINT32_MAX
};

struct tribo_compensator_f32_params
{
    tribo_friction_f32_params_t friction;
    tribo_arm_f32_params_t      arm;
};

struct tribo_compensator_f32_state
{
    tribo_friction_f32_state_t friction; ///< counts the bad inputs
    tribo_arm_f32_state_t      arm;
};

/// Runs one step of the relays from pulses, for a caller with its own delay lines. Returns their outputs. Cannot fail.
uint8_t tribo_relay_latch_step(tribo_relay_latch_t *latch, uint8_t pulses);

#ifdef __cplusplus
}
#endif

#endif
