/// learned.yaml: the breakaway learned in a run, as keys of `compensator`, with which another run or a drive can start.

#ifndef SIM_LEARNED_H
#define SIM_LEARNED_H

#include "scenario/summary.h"

#include <stdio.h>

void sim_learned_write(FILE *file, const sim_result_t *result);

#endif
