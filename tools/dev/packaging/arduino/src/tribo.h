/// What a sketch includes: the force loop with the feed-forward, in float32 and in Q31.

#ifndef TRIBO_H
#define TRIBO_H

#include "tribo/feedforward_f32.h"
#include "tribo/feedforward_q31.h"

#endif
