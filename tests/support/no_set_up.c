// What a test program gets that has no setUp or tearDown of its own.

#include "unity.h"

__attribute__((weak)) void setUp(void)
{
}

__attribute__((weak)) void tearDown(void)
{
}
