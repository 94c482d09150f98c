/// Judgement of a scenario's loop beyond its single keys.

#ifndef SIM_LOOP_CHECK_H
#define SIM_LOOP_CHECK_H

#include "loop/scenario.h"
#include "tribo/status.h"

/// "SOURCE: KEY: WHAT". Always false.
bool sim_check_complain(const sim_scenario_t *scenario, const char *key, const char *what, sim_error_t *error);

/// That all required keys are there.
bool sim_check_present(const sim_scenario_t *scenario, sim_error_t *error);

/// What the keys of friction must be together, in the group `whose`.
bool sim_check_friction(const sim_scenario_t        *scenario,
                        const sim_friction_config_t *friction,
                        const char                  *whose,
                        sim_error_t                 *error);

/// Likewise the compensator's.
bool sim_check_compensator(const sim_scenario_t *scenario, sim_error_t *error);

/// That, the controller's keys, and what the library says of the loop as a whole.
bool sim_check_loop(const sim_scenario_t *scenario, sim_error_t *error);

/// That the scenario is not open loop.
bool sim_check_has_loop(const sim_scenario_t *scenario, sim_error_t *error);

/// True for TRIBO_OK; else the error names the key that the library's status is about.
bool sim_check_status(const sim_scenario_t *scenario, tribo_status_t status, sim_error_t *error);

#endif
