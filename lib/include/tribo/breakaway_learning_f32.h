/// Learns breakaway L(F) in each direction while the arm slides, single precision: a Kalman filter over newton travelled.
///
///     L(F) = (1 + scale) prior(F) + offset
///
/// The four states are scale and offset of each direction, 0 with the spread that the config gives them before anything is
/// learned; P is their covariance. What is learned in one direction moves the other by their correlation. For a measurement z at F
/// after `travel` newton of slide, with a = (prior, 1) for that direction and q = P a:
///
///     gain = travel/(weight prior^2 + travel a q)      x += gain q (z - L(F))      P -= gain q q'
///     fade = min(1, forgetting travel)                 P += fade (P_prior - P)
///
/// so nothing moves while the arm stands. The doubt, a'P a over what it was at first, from 1 to 0, says how much of the prior's
/// spread is left at F. A feed-forward takes L weighted: (1 - (1 - trust) doubt) L.
/// One division a step and one an estimate; no loops. Not synchronized: one state, one tick.
/// Source: Kalman, "A new approach to linear filtering and prediction problems", 1960.

#ifndef TRIBO_BREAKAWAY_LEARNING_F32_H
#define TRIBO_BREAKAWAY_LEARNING_F32_H

#include "tribo/force_f32.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Directions, as in the laws of friction_f32.h.
#define TRIBO_BREAKAWAY_POSITIVE 0u
#define TRIBO_BREAKAWAY_NEGATIVE 1u

/// Slides in succession that end at a bound, in one direction, until that is latched.
#define TRIBO_BREAKAWAY_BOUND_SLIDES 4u

typedef struct
{
    float spread_scale;      ///< prior standard deviation of the scale, 1e-3 to 2
    float spread_offset_n;   ///< prior standard deviation of the offset, 1e-9 to 1e6 N
    float correlation;       ///< of the directions before anything is learned, 0 to 0.99
    float correlation_faded; ///< of the directions once forgotten, 0 to 0.99
    float trust;             ///< weight of the prior before anything is learned, 0 to 1
    float doubt;    ///< before anything is learned, 1e-3 to 1: 1, or what was left of it where the prior was learned
    float weight_n; ///< of a measurement: distance over which noise averages out, 1e-9 to 1e6 N; larger is slower
    float forgetting_per_n; ///< share of the prior's doubt that comes back per newton, 0 to 1e6 1/N
    float scale_min;        ///< L stays above this share of the prior, 1e-3 to 1
    float scale_max;        ///< L stays below this multiple of the prior, 1 to 10
} tribo_breakaway_learning_f32_config_t;

/// What a step reads, made by tribo_breakaway_learning_f32_init. Const from then on; may be shared.
typedef struct
{
    float scale_most, offset_most_n;   ///< three spreads
    float scale_variance;              ///< of the prior
    float offset_variance;             ///< of the prior, N^2
    float scale_shared, offset_shared; ///< of both directions once forgotten
    float correlation;                 ///< of the directions before anything is learned
    float doubt;                       ///< before anything is learned
    float distrust;                    ///< 1 - trust
    float weight_n;
    float forgetting_per_n;
    float scale_min, scale_max;
} tribo_breakaway_learning_f32_params_t;

/// What was learned of one direction, and its covariance.
typedef struct
{
    float scale, offset_n; ///< within three spreads
    float ss, so, oo;      ///< scale with scale, with offset, offset with offset
} tribo_breakaway_learned_f32_t;

/// What is known where F has the other sign.
typedef struct
{
    tribo_breakaway_learned_f32_t of[2];
    float                         shared[4];
    float                         travel_n[2];
} tribo_breakaway_across_f32_t;

typedef struct
{
    tribo_breakaway_learned_f32_t of[2]; ///< the directions
    float   shared[4];                   ///< covariance: L+'s scale with L-'s, with its offset; L+'s offset likewise
    float   travel_n[2];       ///< learned from, by direction; stands still once a tick's travel is below its last bit
    uint8_t slid;              ///< 1: something was learned since the last slide ended
    uint8_t bound_slides[2];   ///< slides in succession that ended at a bound, by direction; stops at 255
    uint8_t stays_at_bound[2]; ///< 1: TRIBO_BREAKAWAY_BOUND_SLIDES of them were seen; latched until reset or restore
    tribo_breakaway_across_f32_t across;
} tribo_breakaway_learning_f32_state_t;

/// A force: what follows from the prior there, whatever is learned.
typedef struct
{
    float prior_n;
    float variance; ///< of L before anything is learned, N^2
} tribo_breakaway_learning_f32_place_t;

/// L in one direction at one force.
typedef struct
{
    float L_n;        ///< estimate, within scale_min to scale_max of the prior
    float doubt;      ///< 0 to 1, but for rounding
    float weighted_n; ///< (1 - (1 - trust) doubt) L
} tribo_breakaway_learning_f32_signals_t;

/// The defaults of the design, for forces about 1 N.
tribo_breakaway_learning_f32_config_t tribo_breakaway_learning_f32_default(void);

/// Returns TRIBO_OK, TRIBO_ERR_NULL or the status of the first field that is wrong: TRIBO_ERR_LEARNING_SPREAD,
/// TRIBO_ERR_LEARNING_CORRELATION, TRIBO_ERR_LEARNING_TRUST, TRIBO_ERR_LEARNING_WEIGHT, TRIBO_ERR_LEARNING_FORGETTING or
/// TRIBO_ERR_LEARNING_BOUNDS. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_breakaway_learning_f32_init(tribo_breakaway_learning_f32_params_t       *params,
                                                 const tribo_breakaway_learning_f32_config_t *config);

/// Nothing learned. Call it before the first step: a zeroed state has no doubt.
void tribo_breakaway_learning_f32_reset(const tribo_breakaway_learning_f32_params_t *params,
                                        tribo_breakaway_learning_f32_state_t        *state);

/// What is known of L in `direction` where the prior is `prior_n`, 1e-6 to 2e7 N; a bad prior counts as 1e-6 N.
tribo_breakaway_learning_f32_signals_t tribo_breakaway_learning_f32_at(
    const tribo_breakaway_learning_f32_params_t *params,
    const tribo_breakaway_learning_f32_state_t  *state,
    uint32_t                                     direction,
    float                                        prior_n);

/// True when what was learned in `direction` is at a bound: a state at three spreads, or L at scale_min or scale_max of
/// `prior_n`. Then the prior is further off than the params allow, or what is measured is not friction. Not for every tick.
bool tribo_breakaway_learning_f32_is_at_bound(const tribo_breakaway_learning_f32_params_t *params,
                                              const tribo_breakaway_learning_f32_state_t  *state,
                                              uint32_t                                     direction,
                                              float                                        prior_n);

/// Learns that in `direction` breakaway is `measured_n` where the prior is `prior_n`, from `travel_n` of slide. Cannot fail:
/// with a bad input (NaN, or beyond TRIBO_F32_FORCE_MAX_N), or travel not above 0, nothing is learned.
void tribo_breakaway_learning_f32_step(const tribo_breakaway_learning_f32_params_t *params,
                                       tribo_breakaway_learning_f32_state_t        *state,
                                       uint32_t                                     direction,
                                       float                                        travel_n,
                                       float                                        prior_n,
                                       float                                        measured_n);

/// Changes to the other side of F = 0. Each side learns apart, but what is known on the side that is left counts on the other one as
/// well if it has slid both ways and both sides agree on the scale within a tenth of its spread in one direction (a command of the
/// wrong scale makes them differ in both, and differently), or if it is better known even though the sides may differ by half a
/// spread. What slide_ends counts is of both sides. Not for every tick.
void tribo_breakaway_learning_f32_change_side(const tribo_breakaway_learning_f32_params_t *params,
                                              tribo_breakaway_learning_f32_state_t        *state);

/// Says that the slide in `direction` has ended, at a force where the prior is `prior_n`: counts the slides that something was
/// learned from and that ended at a bound, and latches when there are TRIBO_BREAKAWAY_BOUND_SLIDES in succession. A single slide
/// is at a bound while a first wrong measurement is being corrected; one that stays there does not describe the friction.
void tribo_breakaway_learning_f32_slide_ends(const tribo_breakaway_learning_f32_params_t *params,
                                             tribo_breakaway_learning_f32_state_t        *state,
                                             uint32_t                                     direction,
                                             float                                        prior_n);

/// Clears what slide_ends has counted and latched; what was learned stays.
void tribo_breakaway_learning_f32_restore(tribo_breakaway_learning_f32_state_t *state);

#ifdef __cplusplus
}
#endif

#endif
