// The feed-forward's tick and its call to learn, in fixed point.

#include "learner.h"
#include "words_q31.h"

#include "reference.h"

#include "tick.h"

#include "learn.h"
