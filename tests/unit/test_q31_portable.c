// The same tests of what a compiler without __builtin_clz gets, and a processor without long multiplication.

#define TRIBO_PORTABLE_BUILTINS
#define TRIBO_Q31_SHORT_PRODUCTS
#include "test_q31.c" // NOLINT(bugprone-suspicious-include)
