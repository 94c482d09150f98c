/// Judgement of a whole scenario beyond its single keys (sim_scenario_check), and the parts of it that a command needs alone.

#ifndef SIM_CHECK_H
#define SIM_CHECK_H

#include "scenario/config.h"
#include "tribo/status.h"

/// What the compensator's keys must be together.
bool sim_check_compensator(const sim_scenario_t *scenario, sim_error_t *error);

/// That the scenario is not open loop.
bool sim_check_has_loop(const sim_scenario_t *scenario, sim_error_t *error);

/// That, and that the drive's firmware has the loop.
bool sim_check_has_firmware(const sim_scenario_t *scenario, sim_error_t *error);

/// True for TRIBO_OK; else the error names the key that the library's status is about.
bool sim_check_status(const sim_scenario_t *scenario, tribo_status_t status, sim_error_t *error);

#endif
