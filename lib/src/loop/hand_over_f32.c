#include "loop_f32.h"

#include "hand_over.h"
