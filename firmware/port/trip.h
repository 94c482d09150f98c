/// Passes stops from an interrupt to the next tick: the interrupt counts them, the tick takes them.

#ifndef DRIVE_TRIP_H
#define DRIVE_TRIP_H

#include <stdbool.h>
#include <stdint.h>

/// Only the interrupt writes `count`, and only the tick `seen`.
typedef struct
{
    volatile uint8_t count;
    uint8_t          seen;
} trip_t;

static inline void trip_count(trip_t *trip)
{
    trip->count = (uint8_t)(trip->count + 1u);
}

static inline bool trip_has_come(const trip_t *trip)
{
    return trip->count != trip->seen;
}

/// Returns true if a stop has come since the last call. It reads `count` once: a stop that comes between two reads would be
/// seen by neither.
static inline bool trip_take(trip_t *trip)
{
    const uint8_t count   = trip->count;
    const bool    tripped = count != trip->seen;
    trip->seen            = count;
    return tripped;
}

#endif
