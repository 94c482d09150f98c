/// What the types of a scenario cannot say: ranges, and values that must fit each other.

#ifndef SIM_CHECK_H
#define SIM_CHECK_H

#include "scenario/config.h"
#include "tribo/status.h"

/// Every number within its range in schema.c.
bool sim_check_ranges(const sim_scenario_t *scenario, sim_error_t *error);

/// Keys that must be there, and values that must go together; at the end the library's own judgement, under the
/// name of the key that its status means.
bool sim_check_together(const sim_scenario_t *scenario, sim_error_t *error);

/// The part of it that is about the compensator's keys alone.
bool sim_check_compensator(const sim_scenario_t *scenario, sim_error_t *error);

/// True for TRIBO_OK; else the error names the key that the library's status is about.
bool sim_check_status(const sim_scenario_t *scenario, tribo_status_t status, sim_error_t *error);

#endif
