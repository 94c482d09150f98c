#include "loop_q31.h"

#include "hand_over.h"
