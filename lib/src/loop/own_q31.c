#include "loop_q31.h"

#include "own.h"
