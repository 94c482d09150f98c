// arith.h in q31.

#ifndef TESTS_CONTRACT_ARITH_Q31_H
#define TESTS_CONTRACT_ARITH_Q31_H

#define TRIBO_ARITHMETIC_Q31
#include "arith.h"

#endif
