/// A ring of samples of chosen forces, filled in the tick. It stops by itself a chosen number of samples after a trigger, so
/// that it keeps the samples before it. It can be read while it is being filled.
///
/// A tick costs the same for all signals: one comparison for the trigger, and one copy per channel for a sample. The tick calls
/// trace_step; the background calls the rest and sees a consistent trace between two ticks.

#ifndef DRIVE_TRACE_H
#define DRIVE_TRACE_H

#include "app/loop.h"

#include <stdbool.h>
#include <stdint.h>

#define TRACE_CHANNELS_MAX 8u

typedef enum
{
    TRACE_NEVER,    ///< runs until it is stopped
    TRACE_FAULT,    ///< the drive enters its fault
    TRACE_REVERSAL, ///< the watched force turns around
    TRACE_RISE,     ///< the watched force reaches the level from below
    TRACE_FALL,     ///< ... from above
    TRACE_TRIGGERS
} trace_trigger_t;

typedef enum
{
    TRACE_STOPPED,   ///< holds a recording, or nothing yet
    TRACE_ARMED,     ///< records, waits for its trigger
    TRACE_TRIGGERED, ///< records the samples after it
    TRACE_DONE       ///< recorded the samples after the trigger, and stopped
} trace_state_t;

/// The forces and the trigger. The forces must outlive the trace.
typedef struct
{
    const loop_force_t *channels[TRACE_CHANNELS_MAX];
    uint32_t            channel_count; ///< 1 to TRACE_CHANNELS_MAX
    uint32_t            decimation;    ///< ticks from sample to sample, 1 or more
    uint32_t            after;         ///< samples after the trigger's own, at most `capacity` - 1
    trace_trigger_t     trigger;
    const loop_force_t *watched; ///< for a reversal or a level
    loop_force_t        level;
} trace_setup_t;

typedef struct
{
    uint32_t     *ring;
    uint32_t      ring_words;
    trace_setup_t setup;
    uint32_t      capacity; ///< samples that fit

    volatile trace_state_t state;
    volatile uint32_t count; ///< samples since it was armed, wraps; sample n was taken n * decimation ticks after 0
    volatile uint32_t held;  ///< of these, not yet overwritten

    uint32_t     first_tick;     ///< of sample 0
    uint32_t     trigger_sample; ///< once triggered
    uint32_t     place;          ///< of the next sample in the ring, in words
    uint32_t     wait;           ///< ticks to the next sample
    uint32_t     left;           ///< samples, once triggered
    loop_force_t last;           ///< of the watched force
    int          direction;      ///< of its last move; 0: none yet
    bool         was_fault;
    bool         begun; ///< there was a tick since it was armed
} trace_t;

/// `ring` of `ring_words` words must outlive the trace.
void trace_init(trace_t *trace, uint32_t *ring, uint32_t ring_words);

/// Restarts with `setup`; false, and nothing changes, if it is out of range.
bool trace_arm(trace_t *trace, const trace_setup_t *setup);

void trace_stop(trace_t *trace);

/// In tick number `tick`, after the drive's.
void trace_step(trace_t *trace, uint32_t tick, bool is_fault);

/// The oldest sample in the ring; trace->count is the one after the newest.
uint32_t trace_first(const trace_t *trace);

/// Copies `count` words, from channel 0 of sample `number` on, across samples. False if some of them are not in the ring.
bool trace_read(const trace_t *trace, uint32_t number, uint32_t *words, uint32_t count);

#endif
