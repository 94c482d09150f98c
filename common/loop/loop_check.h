/// Checks of a scenario's loop that involve several keys.

#ifndef COMMON_LOOP_CHECK_H
#define COMMON_LOOP_CHECK_H

#include "loop/scenario.h"
#include "tribo/status.h"

/// Reports an error as "SOURCE: KEY: WHAT". Always returns false.
bool common_check_complain(const common_scenario_t *scenario, const char *key, const char *what, common_error_t *error);

/// Checks that all required keys are present.
bool common_check_present(const common_scenario_t *scenario, common_error_t *error);

/// Checks that the keys of friction in the group `whose` agree with each other.
bool common_check_friction(const common_scenario_t        *scenario,
                           const common_friction_config_t *friction,
                           const char                     *whose,
                           common_error_t                 *error);

/// Checks that the compensator's keys agree with each other.
bool common_check_compensator(const common_scenario_t *scenario, common_error_t *error);

/// Checks the compensator's keys, the controller's keys, and the whole loop by the library's own checks.
bool common_check_loop(const common_scenario_t *scenario, common_error_t *error);

/// Checks that the scenario closes the loop.
bool common_check_has_loop(const common_scenario_t *scenario, common_error_t *error);

/// Returns true for TRIBO_OK. Otherwise the error names the key that the library's status is about.
bool common_check_status(const common_scenario_t *scenario, tribo_status_t status, common_error_t *error);

#endif
