#include "app/selftest.h"

// Volatile, so that the compiler does not assume the contents. Not zero, so that the seal is in the image and not in .bss.
const volatile selftest_seal_t selftest_seal = {.magic = ~SELFTEST_MAGIC};
