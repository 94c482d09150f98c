/// Checks of a scenario's loop that involve several keys.

#ifndef COMMON_LOOP_CHECK_H
#define COMMON_LOOP_CHECK_H

#include "loop/scenario.h"
#include "tribo/status.h"

/// "SOURCE: KEY: WHAT". Always false.
bool common_check_complain(const common_scenario_t *scenario, const char *key, const char *what, common_error_t *error);

/// That all required keys are present.
bool common_check_present(const common_scenario_t *scenario, common_error_t *error);

/// That the keys of friction in the group `whose` agree with each other.
bool common_check_friction(const common_scenario_t        *scenario,
                           const common_friction_config_t *friction,
                           const char                     *whose,
                           common_error_t                 *error);

/// Likewise the compensator's.
bool common_check_compensator(const common_scenario_t *scenario, common_error_t *error);

/// The same, the controller's keys, and the library's own checks of the whole loop.
bool common_check_loop(const common_scenario_t *scenario, common_error_t *error);

/// That the scenario closes the loop.
bool common_check_has_loop(const common_scenario_t *scenario, common_error_t *error);

/// True for TRIBO_OK; else the error names the key that the library's status is about.
bool common_check_status(const common_scenario_t *scenario, tribo_status_t status, common_error_t *error);

#endif
