#include "app/selftest.h"

// Volatile, so that the compiler does not assume the contents; not zero, so that they are stored in the image, not in .bss.
const volatile selftest_seal_t selftest_seal = {.magic = ~SELFTEST_MAGIC};
