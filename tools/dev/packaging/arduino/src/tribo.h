/// What a sketch includes: a force axis, a joint without a force sensor, and the force loop with the feed-forward, in float32 and in Q31.

#ifndef TRIBO_H
#define TRIBO_H

#include "tribo/axis_f32.h"
#include "tribo/axis_q31.h"
#include "tribo/feedforward_f32.h"
#include "tribo/feedforward_q31.h"
#include "tribo/joint_f32.h"
#include "tribo/joint_q31.h"

#endif
