/// Hub friction of a constrained arm in Q31, with the equations of friction_f32.h.
///
/// Forces are Q31 of one full scale FS. The net force saturates at FS and is counted; friction is at breakaway there.
/// The rate v enters as the change of |n| in a tick, exact to the last bit.
///
///     k(v)       exponent (2/ln 2) m (v/v0 - 1) in Q22; 2^-|exponent| in Q32 by the polynomial of src/friction/law_f32.h;
///                k 2^-S in Q32, S the smallest that fits k_max + k_min
///     n/(k L)    as a fraction of two numbers of 32 bits, the larger one normalised
///     f          n less the rational function of friction_f32.h, coefficients Q32
///
/// Against the model in double: f within 5e-7 N at a full scale of 2 N for the paper's parameters (tests/contract). By
/// dense search: the error of k L tanh(n/(k L)) is within 9e-7 of it plus 4 LSB (23 at k_max/k_min = 900), k(v) within
/// the bound of friction_f32.h: 1.5e-6 of k_max - k_min up to m = 20, 4.5e-6 at m = 100
/// (tests/unit/test_friction_q31.c). Symmetric parameters give f(-u, -F) = -f(u, F) exactly, and |f| <= |n|, |f| <= L
/// always. If offset + slope |F| is beyond FS, L is FS. One 32-bit division, two with a table. The only loop is over a
/// table's points. Not synchronized: one state, one tick.

#ifndef TRIBO_FRICTION_Q31_H
#define TRIBO_FRICTION_Q31_H

#include "tribo/friction_f32.h"
#include "tribo/q31.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_friction_q31_params    tribo_friction_q31_params_t;
typedef struct tribo_friction_q31_state     tribo_friction_q31_state_t;
typedef struct tribo_arm_q31_params         tribo_arm_q31_params_t;
typedef struct tribo_arm_q31_state          tribo_arm_q31_state_t;
typedef struct tribo_compensator_q31_params tribo_compensator_q31_params_t;
typedef struct tribo_compensator_q31_state  tribo_compensator_q31_state_t;

/// One point of a breakaway table, all Q31.
typedef struct
{
    int32_t force;    ///< |F|, strictly rising from point to point
    int32_t positive; ///< L+, over 0
    int32_t negative; ///< L-, over 0
} tribo_breakaway_point_q31_t;

/// Signals of one step, for logging.
typedef struct
{
    int32_t n;      ///< net force, Q31
    int32_t L;      ///< breakaway for the sign of n, Q31
    int32_t rise;   ///< |n[k]| - |n[k-1]|, which is v h, Q31
    int32_t f;      ///< friction, Q31
    uint8_t relays; ///< TRIBO_RELAY_Q1, _Q2 and, for Eq. (8), _Q
} tribo_friction_q31_signals_t;

/// Signals of one step, for logging.
typedef struct
{
    int32_t                      force;    ///< F^ at the start of the tick, Q31
    tribo_friction_q31_signals_t friction; ///< contains f^
} tribo_compensator_q31_signals_t;

/// Does what tribo_friction_f32_init does, in Q31. `table` receives the config's table in Q31: config->table_length
/// points that must outlive the params, or null for a config without a table. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// TRIBO_ERR_FULL_SCALE or a status of tribo_friction_f32_init.
tribo_status_t tribo_friction_q31_init(tribo_friction_q31_params_t       *params,
                                       tribo_breakaway_point_q31_t       *table,
                                       const tribo_friction_f32_config_t *config,
                                       float                              sample_time_s,
                                       float                              full_scale_n);

/// Resets the friction to rest: n[-1] = 0, relays low, counter 0.
void tribo_friction_q31_reset(tribo_friction_q31_state_t *state);

/// Returns the friction at the manipulated input `u` and the end-point force `force`, all Q31. Cannot fail. Writes all
/// of `signals`, which must not be null.
int32_t tribo_friction_q31_step(const tribo_friction_q31_params_t *params,
                                tribo_friction_q31_state_t        *state,
                                int32_t                            u,
                                int32_t                            force,
                                tribo_friction_q31_signals_t      *signals);

/// Resets the arm to rest at F = 0 and its counter to 0.
void tribo_arm_q31_reset(tribo_arm_q31_state_t *state);

/// Runs one sample of the arm, during which the force `drive` = u - F + g - f is constant, all Q31. Returns F at the
/// end of the sample. Cannot fail.
int32_t tribo_arm_q31_step(const tribo_arm_q31_params_t *params, tribo_arm_q31_state_t *state, int32_t drive);

/// Does what tribo_compensator_f32_init does, in Q31. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_FULL_SCALE or a
/// status of tribo_compensator_f32_init. TRIBO_ERR_ARM_TOO_FAST and TRIBO_ERR_DAMPING also say that the quantised arm
/// overflows or is not stable. tribo_friction_q31_init explains `table`. Writes only the table unless TRIBO_OK. Not for
/// the tick.
tribo_status_t tribo_compensator_q31_init(tribo_compensator_q31_params_t       *params,
                                          tribo_breakaway_point_q31_t          *table,
                                          const tribo_compensator_f32_config_t *config,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n);

/// Resets friction and arm to rest and the counters to 0.
void tribo_compensator_q31_reset(tribo_compensator_q31_state_t *state);

/// Returns the estimated friction f^ for the applied manipulated input `u`, after the actuator's limit, both Q31.
/// Cannot fail. Writes all of `signals`, which must not be null.
int32_t tribo_compensator_q31_step(const tribo_compensator_q31_params_t *params,
                                   tribo_compensator_q31_state_t        *state,
                                   int32_t                               u,
                                   tribo_compensator_q31_signals_t      *signals);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

/// Breakaway in one direction, L(F) = offset + slope |F|, at most FS.
typedef struct
{
    uint32_t offset; ///< Q31, over 0
    uint32_t slope;  ///< its fraction, Q32
} tribo_breakaway_q31_t;

/// Constants of a step, computed by tribo_friction_q31_init.
struct tribo_friction_q31_params
{
    uint32_t                           rise_max;         ///< limit of the rise of |n|, at which E is 2^32 or more
    uint32_t                           exponent_rate;    ///< exponent of E per rise of |n|, times 2^rise_shift, Q54
    int32_t                            exponent_at_rest; ///< minus the exponent of E without a rise, Q22
    uint32_t                           k_min, k_max;     ///< k_min and k_max times 2^-S, Q32
    tribo_breakaway_q31_t              law[2];           ///< L+, L-
    const tribo_breakaway_point_q31_t *table;            ///< null: the affine laws
    uint32_t                           set_level, reset_level; ///< c1, c2, Q32; 1 becomes UINT32_MAX
    int32_t                            gravity;                ///< Q31
    uint8_t                            law_whole[2];           ///< the slopes' whole parts, 0 to 10
    uint8_t                            rise_shift;             ///< 1 to 31
    uint8_t                            k_shift;                ///< S
    bool                               is_shallow;             ///< no table, slopes below 1, no L beyond FS
    uint8_t                            table_length;
    uint8_t                            pulse_width; ///< samples
};

struct tribo_friction_q31_state
{
    int32_t             n;         ///< n[k-1], Q31
    uint32_t            saturated; ///< net forces clamped since reset; stops at UINT32_MAX
    tribo_relay_state_t relay;
};

/// The arm of tribo_compensator_q31_params_t; src/friction/arm_q31.h has the equations.
struct tribo_arm_q31_params
{
    int32_t phi_d, phi_g;     ///< Q28, together within +-4; phi_d with the 2^s of G in it
    int32_t gamma_d, gamma_g; ///< Q28, within +-4; gamma_d with the 2^s of G in it
    uint8_t shift;            ///< s, 0 to 15
};

struct tribo_arm_q31_state
{
    int64_t  force;        ///< F = K theta, Q59
    int32_t  force_change; ///< G 2^s, Q31
    uint32_t saturated;    ///< F or G clamped since reset; stops at UINT32_MAX
};

struct tribo_compensator_q31_params
{
    tribo_friction_q31_params_t friction;
    tribo_arm_q31_params_t      arm;
};

struct tribo_compensator_q31_state
{
    tribo_friction_q31_state_t friction; ///< counts the bad inputs
    tribo_arm_q31_state_t      arm;
};

#ifdef __cplusplus
}
#endif

#endif
