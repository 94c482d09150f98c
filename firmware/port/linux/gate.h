/// Lets another thread look at what the tick writes, without making the tick wait: that thread waits for the end of a tick, looks,
/// and if a tick began meanwhile, looks again.

#ifndef LINUX_GATE_H
#define LINUX_GATE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <time.h>

typedef struct
{
    atomic_uint count; ///< of begins and ends of ticks: odd within one
} gate_t;

/// The tick's, at its begin and at its end.
static inline void gate_pass(gate_t *gate)
{
    (void)atomic_fetch_add(&gate->count, 1u);
    atomic_thread_fence(memory_order_release); // nothing the tick writes comes before its begin
}

#define GATE_LOOK_NS 20000

/// The other thread's. Returns once there is no tick: what a tick of before has begun is done.
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

/// Whether a tick has begun since gate_wait returned `count`.
static inline bool gate_has_passed(gate_t *gate, unsigned count)
{
    atomic_thread_fence(memory_order_acquire);
    return atomic_load(&gate->count) != count;
}

#endif
