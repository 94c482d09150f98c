// Which way a condition mostly goes and what stays out of line, for the layout of the code.

#ifndef TRIBO_USUAL_H
#define TRIBO_USUAL_H

#include <stdbool.h>

#ifdef __GNUC__
#define TRIBO_OUT_OF_LINE      __attribute__((noinline))
#define TRIBO_ALL_INLINE       __attribute__((flatten)) // gcc: all that it calls, where that is not out of line
#define TRIBO_FROM_HERE()      __asm__ volatile("") // gcc: what follows is not begun earlier, where registers are short
#define TRIBO_USUAL(condition) __builtin_expect((condition), 1)
#define TRIBO_RARE(condition)  __builtin_expect((condition), 0)
#else
#define TRIBO_OUT_OF_LINE
#define TRIBO_ALL_INLINE
#define TRIBO_FROM_HERE()      ((void)0)
#define TRIBO_USUAL(condition) (condition)
#define TRIBO_RARE(condition)  (condition)
#endif

#if defined(__thumb__) && !defined(__thumb2__) // a call keeps its caller's frame on the stack
#define TRIBO_OWN_FRAME TRIBO_OUT_OF_LINE
#else
#define TRIBO_OWN_FRAME inline
#endif

/// `condition`, usually true, for a way that is there for speed alone: not when the compiler is asked for small code.
#ifdef __OPTIMIZE_SIZE__
#define TRIBO_FAST_WAY(condition) false
#else
#define TRIBO_FAST_WAY(condition) TRIBO_USUAL(condition)
#endif

#endif
