/// Cascade of second-order sections in Q31, in the delta operator d = z - 1, as biquad_f32.h has it.
///
///     y   = w1 + b0 x                             b0: Q28, within +-4
///     w1 += b0 x + c1 x - a1 y + w2 2^-s          c1 = b1 - b0: Q28, within +-8; a1: Q28, within 4
///     w2 += c2 x + d2 y                           c2 = b2: Q(28 + s), within +-4 2^-s; d2 = -a2: Q(60 + s), two words
///
/// w1 is held in 64 bits, Q59, w2 in Q(59 + s). y is rounded, and what is rounded off it, the rest, stays in w1 and comes
/// out with the next sample: a constant input is integrated without an end and the noise at the output is one rounding,
/// whatever the poles. A y that saturates takes w1 with it, so a corrupt w1 is forgotten within a tick; w2 is clamped
/// to 4 2^-s of full scale and counted.
/// d2, the product of the poles' distances from z = 1, has a second word, so a slow pole keeps its time constant to 1e-7
/// while a2 is above 2^-(37 + s); of d2 y only what is below the last bit of w2 (2^-59 of full scale) is dropped.
///
/// Zero-input limit cycles: none in the paper's controller. Rounding noise has two zeros at z = 1, so a section's cycle stays
/// within half an LSB of its node times the L1 norm of (1 - z^-1)^2 / A(z): at most 52 LSB over 130,000 random pole pairs of
/// radius up to 0.99 and angle up to 2.7 rad (0.43 of the sampling frequency), but up to 480 LSB for poles nearer to z = -1,
/// which no force controller has (tests/unit/test_biquad_q31.c). A resonance sharper than that has larger ones.
///
/// Headroom: section i gives y 2^-scale[i], the scale being derived from the worst-case peak gain (L1 norm) so that no
/// node can overflow for any input in range; see quantize_q31.h. Sums below stay under 2^63 for accepted params.
///
/// No loop but the one over the sections. Not synchronized: one state, one tick.
/// Source: Middleton & Goodwin, "Digital Control and Estimation: A Unified Approach", ch. 13.

#ifndef TRIBO_BIQUAD_Q31_H
#define TRIBO_BIQUAD_Q31_H

#include "tribo/q31.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TRIBO_BIQUAD_Q31_SECTIONS_MAX 4u

typedef struct
{
    int32_t b0, c1;     ///< Q28, with the scales of both nodes in them
    int32_t minus_a1;   ///< Q28
    int32_t c2;         ///< Q(28 + shift), with the scales of both nodes in it
    int32_t d2, d2_low; ///< Q(28 + shift), and 2^-32 of that, to add
    uint8_t shift;      ///< s, 0 to 30
    uint8_t scale;      ///< 0 to 24, of this section's output node: y is held times 2^-scale
} tribo_biquad_q31_section_t;

/// What a step reads, made by the functions of quantize_q31.h. Const from then on; may be shared.
typedef struct
{
    tribo_biquad_q31_section_t section[TRIBO_BIQUAD_Q31_SECTIONS_MAX];
    uint8_t                    count;        ///< 2 to 4: a lone section is followed by one that passes its input on
    uint8_t                    input_scale;  ///< 0 to 24, of the input node: x is held times 2^-input_scale
    uint8_t                    output_scale; ///< that of the last section
} tribo_biquad_q31_params_t;

typedef struct
{
    int64_t w1, w2;
} tribo_biquad_q31_section_state_t;

typedef struct
{
    tribo_biquad_q31_section_state_t section[TRIBO_BIQUAD_Q31_SECTIONS_MAX];
    uint32_t                         carry;     ///< bits of the input dropped for its scale so far, from bit 31 down
    uint32_t                         saturated; ///< values clamped since reset; stops at UINT32_MAX
} tribo_biquad_q31_state_t;

/// The nodes of two sections in one tick, on their way from the first half of a step to the second. Of more sections only x is
/// kept: the others are computed again.
typedef struct
{
    int32_t  x;       ///< the input, at the input node's scale
    int32_t  y[2];    ///< the outputs of the first two sections, each at its node's scale
    uint32_t rest[2]; ///< what their rounding has left, Q59
} tribo_biquad_q31_outputs_t;

/// At rest, counter 0. A zeroed state is half a unit of its outputs away from rest.
void tribo_biquad_q31_reset(tribo_biquad_q31_state_t *state);

/// Filters one sample, Q31 in and out; an output beyond full scale is saturated and counted. Cannot fail.
int32_t tribo_biquad_q31_step(const tribo_biquad_q31_params_t *params, tribo_biquad_q31_state_t *state, int32_t x);

/// The first half of a step: the output for `x`, Q31, unsaturated (up to 2^scale of full scale), with no w advanced.
int64_t tribo_biquad_q31_output(const tribo_biquad_q31_params_t *params,
                                tribo_biquad_q31_state_t        *state,
                                int32_t                          x,
                                tribo_biquad_q31_outputs_t      *outputs);

/// The second half: advances the states as if the input had been `correction` larger, at the input node's scale.
void tribo_biquad_q31_advance(const tribo_biquad_q31_params_t  *params,
                              tribo_biquad_q31_state_t         *state,
                              const tribo_biquad_q31_outputs_t *outputs,
                              int32_t                           correction);

/// Changes a running cascade over from params `from` to `to`, as tribo_biquad_f32_change does: same outputs, section by
/// section, for input `x`, the last one plus `offset` (Q31), and the same first change of each. Not for every tick.
void tribo_biquad_q31_change(const tribo_biquad_q31_params_t *from,
                             const tribo_biquad_q31_params_t *to,
                             tribo_biquad_q31_state_t        *state,
                             int32_t                          x,
                             int32_t                          offset);

#ifdef __cplusplus
}
#endif

#endif
