/// Judgement of a whole scenario beyond its single keys (sim_scenario_check), and the parts of it that a command needs alone.

#ifndef SIM_CHECK_H
#define SIM_CHECK_H

#include "loop/loop_check.h"
#include "scenario/config.h"

/// That the scenario has a loop, and that the drive's firmware has it.
bool sim_check_has_firmware(const common_scenario_t *scenario, common_error_t *error);

#endif
