// Counts executed instructions on an emulated target: exact, because QEMU's -icount makes its timers advance with them.
// The timer's rate against instructions is measured once, over a loop of known length.

#ifndef TESTS_TARGET_COUNTER_H
#define TESTS_TARGET_COUNTER_H

#include <stdint.h>

#define LOOPS 100000u // of two instructions

#if defined(__arm__)

#define SYST_CSR (*(volatile uint32_t *)0xe000e010u)
#define SYST_RVR (*(volatile uint32_t *)0xe000e014u)
#define SYST_CVR (*(volatile uint32_t *)0xe000e018u)

static inline uint32_t counter_read(void)
{
    __asm volatile("" ::: "memory");
    const uint32_t now = SYST_CVR;
    __asm volatile("" ::: "memory");
    return now;
}

static inline uint32_t counter_between(uint32_t from, uint32_t to)
{
    return (from - to) & 0xffffffu; // counts down, 24 bits
}

static inline void two_instructions_a_loop(void)
{
    uint32_t left = LOOPS;
    __asm volatile(".syntax unified\n1: subs %0, #1\n bne 1b" : "+l"(left)::"cc");
}

static inline void counter_start(void)
{
    SYST_RVR = 0xffffffu;
    SYST_CVR = 0u;
    SYST_CSR = 5u; // processor clock, no interrupt
}

#elif defined(__riscv)

static inline uint32_t counter_read(void)
{
    uint32_t now;
    __asm volatile(".option push\n.option arch, +zicsr\ncsrr %0, minstret\n.option pop" : "=r"(now)::"memory");
    return now;
}

static inline uint32_t counter_between(uint32_t from, uint32_t to)
{
    return to - from;
}

static inline void two_instructions_a_loop(void)
{
    uint32_t left = LOOPS;
    __asm volatile("1: addi %0, %0, -1\n bnez %0, 1b" : "+r"(left));
}

static inline void counter_start(void)
{
}

#else // the host, for the results only

static inline uint32_t counter_read(void)
{
    return 0;
}

static inline uint32_t counter_between(uint32_t from, uint32_t to)
{
    return from + to;
}

static inline void two_instructions_a_loop(void)
{
}

static inline void counter_start(void)
{
}

#endif

static uint32_t counter_loops; // timer counts of the loop
static uint32_t counter_empty; // instructions between two readings with nothing between

static uint32_t counter_instructions(uint32_t passed)
{
    if (counter_loops == 0u)
    {
        return 0;
    }
    const uint64_t instructions = (uint64_t)passed * (2u * LOOPS);
    return (uint32_t)((instructions + counter_loops / 2u) / counter_loops) - counter_empty;
}

static inline void counter_init(void)
{
    counter_start();
    (void)counter_read();
    const uint32_t from = counter_read();
    two_instructions_a_loop();
    const uint32_t to    = counter_read();
    const uint32_t again = counter_read();
    counter_loops        = counter_between(from, to);
    counter_empty        = counter_instructions(counter_between(to, again));
}

static uint32_t counter_passed; // timer counts of the last call that was counted

#ifdef __clang__
#define COUNTED_ALONE __attribute__((noinline))
#else
#define COUNTED_ALONE __attribute__((noipa)) // no copies for constant arguments either
#endif

/// Defines `name`, a function with `parameters` that makes `call` and notes what that takes, from the call instruction to
/// the return. Its arguments come in registers: what makes them is not counted.
#define COUNTED(type, name, parameters, call)                                                                          \
    static COUNTED_ALONE type name parameters                                                                          \
    {                                                                                                                  \
        const uint32_t from   = counter_read();                                                                        \
        const type     result = (call);                                                                                \
        const uint32_t to     = counter_read();                                                                        \
        counter_passed        = counter_between(from, to);                                                             \
        return result;                                                                                                 \
    }

typedef struct
{
    uint32_t min, max, calls;
    uint64_t sum;
} counts_t;

/// Adds the last call.
static inline void counts_add(counts_t *c)
{
    const uint32_t instructions = counter_instructions(counter_passed);
    c->min                      = c->calls == 0u || instructions < c->min ? instructions : c->min;
    c->max                      = instructions > c->max ? instructions : c->max;
    c->sum += instructions;
    c->calls++;
}

#endif
