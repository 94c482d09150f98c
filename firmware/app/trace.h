/// Records samples of chosen forces in a ring, in the tick. A trace stops by itself a chosen number of samples after its
/// trigger, so that it keeps the samples before the trigger. It can be read while it is being filled.
///
/// The cost of a tick does not depend on the signals: one comparison for the trigger, and one copy per channel for a sample.
/// The tick calls trace_step; the background calls the other functions and sees a consistent trace between two ticks.

#ifndef DRIVE_TRACE_H
#define DRIVE_TRACE_H

#include "app/loop.h"

#include <stdbool.h>
#include <stdint.h>

#define TRACE_CHANNELS_MAX 8u

typedef enum
{
    TRACE_NEVER,    ///< no trigger: the trace runs until it is stopped
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
    TRACE_TRIGGERED, ///< records the samples after the trigger
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
    volatile uint32_t
        count; ///< samples since it was armed, wraps; sample n was taken n * decimation ticks after sample 0
    volatile uint32_t held; ///< samples of these that are not yet overwritten

    uint32_t     first_tick;     ///< tick of sample 0
    uint32_t     trigger_sample; ///< sample of the trigger, once triggered
    uint32_t     place;          ///< place of the next sample in the ring, in words
    uint32_t     wait;           ///< ticks to the next sample
    uint32_t     left;           ///< samples still to take, once triggered
    loop_force_t last;           ///< last value of the watched force
    int          direction;      ///< sign of its last change; 0: none yet
    bool         was_fault;
    bool         begun; ///< there was a tick since it was armed
} trace_t;

/// Starts a stopped trace. `ring`, of `ring_words` words, must outlive it.
void trace_init(trace_t *trace, uint32_t *ring, uint32_t ring_words);

/// Returns how many samples of `channels` signals the ring holds, one signal or more. `after` must be less.
uint32_t trace_capacity(const trace_t *trace, uint32_t channels);

/// Returns whether `setup` is within its range for this trace.
bool trace_suits(const trace_t *trace, const trace_setup_t *setup);

/// Arms the trace anew with `setup`. Returns false and changes nothing if `setup` is out of range.
bool trace_arm(trace_t *trace, const trace_setup_t *setup);

void trace_stop(trace_t *trace);

/// Takes a sample if one is due, and looks for the trigger. Call it in each tick, after the drive's; `tick` is its number.
void trace_step(trace_t *trace, uint32_t tick, bool is_fault);

/// Returns the number of the oldest sample in the ring; trace->count is the number after the newest.
uint32_t trace_first(const trace_t *trace);

/// Copies `count` words, from channel 0 of sample `number` on, across samples. Returns false if some of them are not in the ring.
bool trace_read(const trace_t *trace, uint32_t number, uint32_t *words, uint32_t count);

#endif
