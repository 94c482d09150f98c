/// Learns breakaway L(F) in each direction while the arm slides, in fixed point: the twin of breakaway_learning_f32.h.
/// The states are in units of their prior spread, t = scale/spread_scale and offset/spread_offset, so that t and their
/// covariance P have a known range. For the direction and force in question all forces are shifted left until the prior l is
/// between 1/2 and 1, which gives what is computed from them a known range too, without a division:
///
///     a = (spread_scale l, spread_offset)      L = l + a t      q = P a
///
///     quantity                                  format   range        room     how it keeps to it
///     l; a                                      Q31      1; 1, 1      x 1      an offset spread of at most l counts
///     t                                         Q28      +-3          x 2.6    limited
///     P                                         Q30      +-1          x 2
///     q                                         Q29      +-2          x 2
///     a q; l^2                                  Q28; Q30 0 to 4; 1    x 4      unsigned
///     gain = travel/(weight l^2 + travel a q)   Q29      0 to 4       x 1      limited
///     gain q                                    Q29      +-2          x 2      q^2 <= a q <= 1/gain
///     gain q[i] q[j]                            Q26      +-1          x 32
///     z - L                                     Q27      +-11         x 1.4    z counts up to 4 l
///     gain (z - L)                              Q24      +-44         x 2.9    then limited to +-1, Q30
///     L                                         Q27      -5 to 7      x 2.2    then limited, scale_min l to scale_max l
///     fade                                      Q32      0 to 1/4     x 2      forgetting and travel are limited
///     weight, travel, their sum                 1/16 units, 2^29, 2^24, 2^30
///
/// Forces and travel are in one unit, 0 to 2^29 of them, travel up to 2^20. Products are rounded down, in the same order
/// whichever the direction: mirrored forces give the same bits. With no travel nothing changes, to the last bit.
/// One division of 32 bits a step and one an estimate; no loops. Not synchronized: one state, one tick.

#ifndef TRIBO_BREAKAWAY_LEARNING_Q31_H
#define TRIBO_BREAKAWAY_LEARNING_Q31_H

#include "tribo/breakaway_learning_f32.h"
#include "tribo/q31.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What a step reads, made by tribo_breakaway_learning_q31_init (quantize_feedforward_q31.h).
typedef struct
{
    uint32_t spread_scale;      ///< Q32
    uint32_t spread_offset;     ///< in units
    int32_t  doubt;             ///< before anything is learned, Q30
    int32_t  correlation;       ///< times that, Q30
    uint32_t correlation_faded; ///< Q32
    uint32_t distrust;          ///< 1 - trust, Q32
    uint32_t weight;            ///< in 1/16 units
    uint32_t forgetting;        ///< of a unit, Q56
    uint32_t scale_min;         ///< Q28
    uint32_t scale_max;         ///< Q28
} tribo_breakaway_learning_q31_params_t;

/// What was learned of one direction, and its covariance.
typedef struct
{
    int32_t scale, offset; ///< in prior spreads, Q28
    int32_t ss, so, oo;    ///< scale with scale, with offset, offset with offset, Q30
} tribo_breakaway_learned_q31_t;

/// What is known where F has the other sign.
typedef struct
{
    tribo_breakaway_learned_q31_t of[2];
    int32_t                       shared[4];
    uint64_t                      travel[2];
} tribo_breakaway_across_q31_t;

typedef struct
{
    tribo_breakaway_learned_q31_t of[2]; ///< the directions
    int32_t  shared[4]; ///< covariance, Q30: L+'s scale with L-'s, with its offset; L+'s offset likewise
    uint64_t travel[2]; ///< learned from, by direction, in units
    uint8_t  slid, bound_slides[2], stays_at_bound[2]; ///< see the twin
    tribo_breakaway_across_q31_t across;
} tribo_breakaway_learning_q31_state_t;

/// A force: what follows from the prior there, whatever is learned.
typedef struct
{
    uint32_t l;        ///< prior, shifted left until it is between 1/2 and 1, Q31
    int32_t  a0, a1;   ///< spreads of scale and offset, shifted likewise
    uint32_t variance; ///< of L before anything is learned, Q28
    uint32_t inverse;  ///< 2^63 over the variance shifted left until its first bit is set
    uint8_t  shift;    ///< of l to Q29
    uint8_t  lift;     ///< of the variance
} tribo_breakaway_learning_q31_place_t;

/// L in one direction at one force, in units.
typedef struct
{
    uint32_t L;        ///< estimate, within scale_min to scale_max of the prior, up to 2^29
    uint32_t doubt;    ///< 0 to 1, Q31
    uint32_t weighted; ///< (1 - (1 - trust) doubt) L
} tribo_breakaway_learning_q31_signals_t;

/// Nothing learned. Call it before the first step: a zeroed state has no doubt.
void tribo_breakaway_learning_q31_reset(const tribo_breakaway_learning_q31_params_t *params,
                                        tribo_breakaway_learning_q31_state_t        *state);

/// What is known of L in `direction` where the prior is `prior`, 1 to 2^29 - 1 units; another prior counts as the nearest.
tribo_breakaway_learning_q31_signals_t tribo_breakaway_learning_q31_at(
    const tribo_breakaway_learning_q31_params_t *params,
    const tribo_breakaway_learning_q31_state_t  *state,
    uint32_t                                     direction,
    uint32_t                                     prior);

/// True when what was learned in `direction` is at a bound; see the twin.
bool tribo_breakaway_learning_q31_is_at_bound(const tribo_breakaway_learning_q31_params_t *params,
                                              const tribo_breakaway_learning_q31_state_t  *state,
                                              uint32_t                                     direction,
                                              uint32_t                                     prior);

/// Learns that in `direction` breakaway is `measured` where the prior is `prior`, from `travel` of slide. Cannot fail: a prior
/// beyond 1 to 2^29 - 1, a measurement beyond +-2^30 and travel beyond 2^20 count as the nearest that are not.
void tribo_breakaway_learning_q31_step(const tribo_breakaway_learning_q31_params_t *params,
                                       tribo_breakaway_learning_q31_state_t        *state,
                                       uint32_t                                     direction,
                                       uint32_t                                     travel,
                                       uint32_t                                     prior,
                                       int32_t                                      measured);

/// Changes to the other side of F = 0; see the twin.
void tribo_breakaway_learning_q31_change_side(tribo_breakaway_learning_q31_state_t *state);

/// Says that the slide in `direction` has ended, at a force where the prior is `prior`; see the twin.
void tribo_breakaway_learning_q31_slide_ends(const tribo_breakaway_learning_q31_params_t *params,
                                             tribo_breakaway_learning_q31_state_t        *state,
                                             uint32_t                                     direction,
                                             uint32_t                                     prior);

/// Clears what slide_ends has counted and latched; what was learned stays.
void tribo_breakaway_learning_q31_restore(tribo_breakaway_learning_q31_state_t *state);

#ifdef __cplusplus
}
#endif

#endif
