#include "loop_f32.h"

#include "own.h"
