/// LuGre friction of a constrained arm in Q31: the twin of lugre_f32.h, equation for equation.
///
/// Forces are Q31 of one full scale FS. The net force saturates at FS (counted). Where L(F) is beyond FS, it is FS. Symmetric
/// parameters give f(-u, -F) = -f(u, F) exactly, and |f| <= L, |Z| <= the largest L seen, always.
/// f is within 1e-7 N of the f32 module's at a full scale of 2 N, for the paper's parameters at 1 kHz
/// (tests/unit/test_lugre_q31.c holds 2e-7).
/// Three 32-bit divisions, no loops but that over a breakaway table's points, with one division more. Not synchronized: one state, one tick.

#ifndef TRIBO_LUGRE_Q31_H
#define TRIBO_LUGRE_Q31_H

#include "tribo/friction_q31.h"
#include "tribo/q31.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What a step reads, made by tribo_lugre_q31_init (quantize_q31.h). Const from then on; may be shared.
typedef struct
{
    uint32_t a, b_and_1; ///< of the divisor 1 + b + a/D*, together below 2^31
    uint32_t one;        ///< 1 in their format, 2^10 to 2^30
    int32_t  beta;       ///< Q20, 0 to 1000
    uint32_t c;          ///< c 2^c_shift
    uint32_t stuck;      ///< c/(1 + a + b), Q32
    int32_t  gamma_g;    ///< Q28
    uint8_t  c_shift;    ///< 11 to 50
} tribo_lugre_q31_params_t;

typedef struct
{
    int32_t  bristle;   ///< Z, Q31
    uint32_t saturated; ///< n or r clamped since reset; stops at UINT32_MAX
    int32_t  drive;     ///< r, Q31
} tribo_lugre_q31_state_t;

/// At rest, bristles relaxed, counter 0.
void tribo_lugre_q31_reset(tribo_lugre_q31_state_t *state);

/// Friction at manipulated input `u` and end-point force `force`, all Q31, to be held over the tick. Of `friction` it reads
/// L(F), by law or table, and gravity. Cannot fail. `signals` is written whole and must not be null: L is that on the side of f,
/// rise and the relays are 0.
int32_t tribo_lugre_q31_step(const tribo_lugre_q31_params_t    *params,
                             const tribo_friction_q31_params_t *friction,
                             tribo_lugre_q31_state_t           *state,
                             int32_t                            u,
                             int32_t                            force,
                             tribo_friction_q31_signals_t      *signals);

#ifdef __cplusplus
}
#endif

#endif
