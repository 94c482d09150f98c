/// learned.yaml: what a run has learned of breakaway, as keys of `compensator` to begin another run or a drive with.

#ifndef SIM_LEARNED_H
#define SIM_LEARNED_H

#include "scenario/summary.h"

#include <stdio.h>

void sim_learned_write(FILE *file, const sim_result_t *result);

#endif
