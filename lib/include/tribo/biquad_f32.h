/// Cascade of second-order sections, single precision, in the delta operator d = z - 1:
///
///              b0 d^2 + b1 d + b2         y   = b0 x + w1
///     H(d)  =  ------------------         w1 += b1 x - a1 y + w2
///                d^2 + a1 d + a2          w2 += b2 x - a2 y
///
/// Why not z: a pole p near z = 1 is stored as 1 - p, which keeps its 24 bits however slow it is. A pole of
/// 0.002 rad/s at 1 kHz (0.999998) moves by up to 20 % when 1 + a1 z^-1 + a2 z^-2 is rounded to float; here
/// by 1e-7. What is rounded off when w2 accumulates is carried into the next sample, so nothing stalls.
/// A first-order section has its second pole and zero at z = 0: TRIBO_BIQUAD_F32(b0, b1, 0, a1, 0).
///
/// An output beyond 1e15, far above any credible one, means a corrupt state: the cascade starts again from rest, gives 0
/// and counts it with the bad inputs.
/// No loop but the one over the sections. Not synchronized: one state, one tick.
/// Source: Middleton & Goodwin, "Digital Control and Estimation: A Unified Approach", ch. 13.

#ifndef TRIBO_BIQUAD_F32_H
#define TRIBO_BIQUAD_F32_H

#include "tribo/status.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TRIBO_BIQUAD_SECTIONS_MAX 4u

/// A section in the delta operator. Stable when 0 < a2 < a1 and 4 - 2 a1 + a2 > 0 (poles inside the
/// unit circle); a2 = 0, one pole at z = 1, is accepted as an integrator.
typedef struct
{
    float b0, b1, b2; ///< each within +-1e6
    float a1, a2;
} tribo_biquad_f32_section_t;

/// Initialiser of a section from the coefficients in z, (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2),
/// e.g. a row of MATLAB's sos matrix without its fourth column. Write constants with all their digits: the
/// conversion is done in double by the compiler, and nothing in double remains in the program.
#define TRIBO_BIQUAD_F32(b0_, b1_, b2_, a1_, a2_)                                                                      \
    {(float)(b0_),                                                                                                     \
     (float)(2.0 * (b0_) + (b1_)),                                                                                     \
     (float)((double)(b0_) + (b1_) + (b2_)),                                                                           \
     (float)(2.0 + (a1_)),                                                                                             \
     (float)(1.0 + (double)(a1_) + (a2_))}

/// What a step reads, made by tribo_biquad_f32_init. Const from then on; may be shared.
typedef struct
{
    tribo_biquad_f32_section_t section[TRIBO_BIQUAD_SECTIONS_MAX]; ///< the first is nearest to the input
    uint32_t                   count; ///< 2 to 4: a lone section is followed by one that passes its input on
} tribo_biquad_f32_params_t;

typedef struct
{
    float w1, w2;
    float w2_carry; ///< rounded off w2 so far
} tribo_biquad_f32_section_state_t;

typedef struct
{
    tribo_biquad_f32_section_state_t section[TRIBO_BIQUAD_SECTIONS_MAX];
    uint32_t                         bad_inputs; ///< since reset; stops at UINT32_MAX
} tribo_biquad_f32_state_t;

/// The outputs of two sections in one tick, on their way from the first half of a step to the second. Those of more are
/// computed again.
typedef struct
{
    float y[2];
} tribo_biquad_f32_outputs_t;

/// Checks `count` sections and copies them. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SECTION_COUNT,
/// TRIBO_ERR_SECTION_COEFFICIENT or TRIBO_ERR_SECTION_UNSTABLE. Writes nothing unless TRIBO_OK.
tribo_status_t tribo_biquad_f32_init(tribo_biquad_f32_params_t        *params,
                                     const tribo_biquad_f32_section_t *sections,
                                     uint32_t                          count);

/// All states 0, counter 0.
void tribo_biquad_f32_reset(tribo_biquad_f32_state_t *state);

/// Filters one sample. Cannot fail: a bad input (NaN, or beyond 1e7) counts as 0 and is counted.
float tribo_biquad_f32_step(const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x);

/// The first half of a step: the output for `x` (which must be finite), with no w advanced.
float tribo_biquad_f32_output(const tribo_biquad_f32_params_t *params,
                              tribo_biquad_f32_state_t        *state,
                              float                            x,
                              tribo_biquad_f32_outputs_t      *outputs);

/// The second half: advances the states as if the input had been x + `correction`. With correction 0 and the
/// same `x`, output and advance are one step; the controller's anti-windup is what needs them apart.
void tribo_biquad_f32_advance(const tribo_biquad_f32_params_t  *params,
                              tribo_biquad_f32_state_t         *state,
                              float                             x,
                              const tribo_biquad_f32_outputs_t *outputs,
                              float                             correction);

/// Changes a running cascade over from params `from` to `to` (of the same number of sections or another): after
/// it, `to` gives for input `x` the outputs, section by section, and the first change of each output that
/// `from` would have given. Sections that `to` has no more are dropped, new ones start at rest; the last one's output
/// is then moved so that the cascade's is what it was, plus `offset`. Not for every tick.
void tribo_biquad_f32_change(const tribo_biquad_f32_params_t *from,
                             const tribo_biquad_f32_params_t *to,
                             tribo_biquad_f32_state_t        *state,
                             float                            x,
                             float                            offset);

#ifdef __cplusplus
}
#endif

#endif
