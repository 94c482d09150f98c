// The feed-forward's tick and its call to learn, in single precision.

#include "learner.h"
#include "words_f32.h"

#include "reference.h"

#include "tick.h"

#include "learn.h"
