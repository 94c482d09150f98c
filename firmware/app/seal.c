#include "app/selftest.h"

// Volatile and not zero, so that the compiler neither knows the contents nor moves them out of the image.
const volatile selftest_seal_t selftest_seal = {.magic = ~SELFTEST_MAGIC};
