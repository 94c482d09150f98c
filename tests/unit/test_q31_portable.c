// The same tests of what a compiler without __builtin_clz gets.

#define TRIBO_PORTABLE
#include "test_q31.c" // NOLINT(bugprone-suspicious-include)
