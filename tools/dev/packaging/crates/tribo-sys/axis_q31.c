// axis.c once more, in Q31.
#define TRIBO_ARITHMETIC_Q31
#include "axis.c"
