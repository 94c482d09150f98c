/// The two relays of Fig. 12, which remember on which side the net force last was.
///
///     Q2 = 1       +---->----+----        Q1 = 1   ----+----<----+
///                  ^         v                         v         ^
///     Q2 = 0   ----+----<----+           Q1 = 0        +---->----+----
///                 -L1        L2                      -L2       L1   n
///
/// Each output is a sample-and-hold of its set pulse, triggered by the rising edge of
/// (set pulse or reset pulse); the pulses come from the edge detectors of Fig. 13. The caller
/// compares numbers and hands in events, so this logic is one for f32, Q31 and the plant.
/// No loops. Not synchronized: one state, one tick. Reset a state before its first step: zeroing is not enough.

#ifndef TRIBO_RELAY_H
#define TRIBO_RELAY_H

#include "tribo/edge.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Events of one sample; the set lines rest high, the reset lines low.
#define TRIBO_RELAY_SET1   1u ///< n <  c1 L+
#define TRIBO_RELAY_SET2   2u ///< n > -c1 L-
#define TRIBO_RELAY_RESET1 4u ///< n rises and n[k-1] < -c2 L-
#define TRIBO_RELAY_RESET2 8u ///< n falls and n[k-1] >  c2 L+

/// Outputs.
#define TRIBO_RELAY_Q1 1u ///< armed for a fall: n has been high
#define TRIBO_RELAY_Q2 2u ///< armed for a rise: n has been low
#define TRIBO_RELAY_Q  4u ///< Eq. (8), in signals only: |n| rises from an armed side

/// The sample-and-hold pair alone.
typedef struct
{
    uint8_t held; ///< outputs, and from bit 4 the last trigger (set or reset of each), to see it rise
} tribo_relay_latch_t;

typedef struct
{
    tribo_edge_state_t  edge;
    tribo_relay_latch_t latch;
} tribo_relay_state_t;

/// Outputs low, set lines as if they had been high for ever, reset lines low.
void tribo_relay_reset(tribo_relay_state_t *state);

/// Takes the events of one sample (TRIBO_RELAY_SET1 ...), makes pulses of `width` samples of them
/// (1 to TRIBO_EDGE_WIDTH_MAX) and returns the outputs (TRIBO_RELAY_Q1, TRIBO_RELAY_Q2). Cannot fail.
uint8_t tribo_relay_step(tribo_relay_state_t *state, uint8_t width, uint8_t events);

/// The same from ready-made pulses, for a caller with delay lines of its own. Cannot fail.
uint8_t tribo_relay_latch_step(tribo_relay_latch_t *latch, uint8_t pulses);

#ifdef __cplusplus
}
#endif

#endif
