// arith.h in f32.

#ifndef TESTS_CONTRACT_ARITH_F32_H
#define TESTS_CONTRACT_ARITH_F32_H

#include "arith.h"

#endif
