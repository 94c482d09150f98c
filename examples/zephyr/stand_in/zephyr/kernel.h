/// A stand-in for Zephyr: only the part that src/main.c uses.

#ifndef EXAMPLES_STAND_IN_KERNEL_H
#define EXAMPLES_STAND_IN_KERNEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef int64_t k_timeout_t;
struct k_timer
{
    uint32_t status;
};

#define K_MSEC(ms)                         ((k_timeout_t)(ms))
#define K_PRIO_COOP(x)                     (-16 + (x))
#define K_FP_REGS                          2u
#define ARG_UNUSED(x)                      (void)(x)
#define K_TIMER_DEFINE(name, expiry, stop) static struct k_timer name
#define K_THREAD_DEFINE(name, stack, entry, p1, p2, p3, prio, options, delay)                                          \
    void (*const name##_entry)(void *, void *, void *) = (entry)

void     k_timer_start(struct k_timer *timer, k_timeout_t duration, k_timeout_t period);
void     k_timer_stop(struct k_timer *timer);
uint32_t k_timer_status_sync(struct k_timer *timer);

#endif
