/// Checks a whole scenario beyond its single keys (sim_scenario_check). Some commands need only parts of these checks.

#ifndef SIM_CHECK_H
#define SIM_CHECK_H

#include "loop/loop_check.h"
#include "scenario/config.h"

/// Checks that the scenario has a loop, and that the drive's firmware has this loop.
bool sim_check_has_firmware(const common_scenario_t *scenario, common_error_t *error);

#endif
