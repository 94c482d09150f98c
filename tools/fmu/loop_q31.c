// The loop's functions once more, in Q31: an FMU's sources are compiled with one set of options.
#define TRIBO_ARITHMETIC_Q31
#include "../scenario/loop_functions.c"
