/// learned.yaml: the breakaway learned in a run, as keys of `compensator`, the start of another run or of a drive.

#ifndef SIM_LEARNED_H
#define SIM_LEARNED_H

#include "scenario/summary.h"

#include <stdio.h>

void sim_learned_write(FILE *file, const sim_result_t *result);

#endif
