/// Force controller in Q31. controller_f32.h says how anti-windup and change of params work. What
/// anti-windup takes back is rounded down to 16 units of the first node, 2^-27 of its full scale, and to a unit of later ones.
/// Not synchronized: one state, one tick.

#ifndef TRIBO_CONTROLLER_Q31_H
#define TRIBO_CONTROLLER_Q31_H

#include "tribo/biquad_q31.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What a step reads, made by the functions of quantize_q31.h.
typedef struct
{
    tribo_biquad_q31_params_t cascade;
    int32_t                   anti_windup;  ///< c/D between the last and the input node: mantissa ...
    int32_t                   taken_max;    ///< of the last node, what a limit may take: its correction fits any
    int32_t                   u_min, u_max; ///< Q31
    uint8_t anti_windup_shift;              ///< ... and its exponent, 1 to 31: anti_windup 2^(anti_windup_shift - 32)
} tribo_controller_q31_params_t;

typedef struct
{
    tribo_biquad_q31_state_t cascade;       ///< with the values saturated in it
    uint32_t                 limited_ticks; ///< since reset; stops at UINT32_MAX
} tribo_controller_q31_state_t;

/// What one step saw, for logging.
typedef struct
{
    int32_t v;       ///< the cascade's output, Q31, saturated
    int32_t u;       ///< the limited sum, Q31
    bool    limited; ///< u is not v + feedforward
} tribo_controller_q31_signals_t;

/// Cascade at rest, counters 0.
void tribo_controller_q31_reset(tribo_controller_q31_state_t *state);

/// One tick: error `e` and feedforward give u within u_min to u_max, all Q31. Cannot fail.
/// `signals` is written whole and must not be null.
int32_t tribo_controller_q31_step(const tribo_controller_q31_params_t *params,
                                  tribo_controller_q31_state_t        *state,
                                  int32_t                              e,
                                  int32_t                              feedforward,
                                  tribo_controller_q31_signals_t      *signals);

/// Between two ticks: takes the state over from params `from` to `to`, so that for error `e` v is and moves as it would
/// have under `from`, plus `offset` (Q31). Cannot fail. Costs up to two ticks of the loop.
void tribo_controller_q31_change(const tribo_controller_q31_params_t *from,
                                 const tribo_controller_q31_params_t *to,
                                 tribo_controller_q31_state_t        *state,
                                 int32_t                              e,
                                 int32_t                              offset);

#ifdef __cplusplus
}
#endif

#endif
