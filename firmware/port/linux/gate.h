/// Lets another thread read what the tick writes without making the tick wait. The reader waits for the end of a tick, reads, and
/// reads again if a tick has begun meanwhile.

#ifndef LINUX_GATE_H
#define LINUX_GATE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <time.h>

typedef struct
{
    atomic_uint count; ///< number of begins and ends of ticks, odd within a tick
} gate_t;

/// The tick calls these at its begin and at its end.
static inline void gate_pass(gate_t *gate)
{
    (void)atomic_fetch_add(&gate->count, 1u);
    atomic_thread_fence(memory_order_release); // nothing the tick writes comes before its begin
}

#define GATE_LOOK_NS 20000

/// The reader calls this. It returns between two ticks, when everything that earlier ticks have written is complete.
static inline unsigned gate_wait(gate_t *gate)
{
    const struct timespec look  = {.tv_nsec = GATE_LOOK_NS};
    unsigned              count = atomic_load(&gate->count);
    while (count % 2u != 0u)
    {
        (void)nanosleep(&look, NULL);
        count = atomic_load(&gate->count);
    }
    return count;
}

/// Returns whether a tick has begun since gate_wait returned `count`.
static inline bool gate_has_passed(gate_t *gate, unsigned count)
{
    atomic_thread_fence(memory_order_acquire);
    return atomic_load(&gate->count) != count;
}

#endif
