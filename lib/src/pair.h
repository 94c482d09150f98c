// Two words that stand side by side, read at once. Where it says TRIBO_THUMB2, here and elsewhere, instructions are named:
// gcc seldom or never makes those of what C has for it.

#ifndef TRIBO_PAIR_H
#define TRIBO_PAIR_H

#include <stdint.h>

#if defined(__thumb2__) && !defined(__ARMEB__) && defined(__GNUC__) && !defined(__clang__) && !defined(TRIBO_PORTABLE)
#define TRIBO_THUMB2
#endif

typedef struct
{
    int32_t first, second;
} pair_t;

/// The word at `from` and the next.
static inline pair_t pair_load(const void *from)
{
#ifdef TRIBO_THUMB2
    typedef int64_t __attribute__((may_alias, aligned(4))) words_t;
    int32_t                                                first;
    int32_t                                                second;
    // Not into its own base: an early M3 may lose that in an interrupt (erratum 602117).
    __asm__("ldrd %0, %1, %2" : "=&r"(first), "=&r"(second) : "m"(*(const words_t *)from));
    return (pair_t){.first = first, .second = second};
#else
    const int32_t *const words = (const int32_t *)from;
    return (pair_t){.first = words[0], .second = words[1]};
#endif
}

#endif
