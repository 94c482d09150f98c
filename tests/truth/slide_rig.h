/// The rig of a test, with the model that it names TRUTH before it includes this, and a slide of the model's law.

#ifndef TRUTH_SLIDE_RIG_H
#define TRUTH_SLIDE_RIG_H

#include "rig.h"
#include "unity.h"

#define L 0.157 ///< breakaway at 0.5 N, in N

static rig_t       rig;
static rig_slide_t slide;

void setUp(void)
{
    rig_init(&rig, &TRUTH);
}

void tearDown(void)
{
    rig_slide_end(&slide);
}

#endif
