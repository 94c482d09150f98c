/// A scenario, for the other parts of the extension.

#ifndef NATIVE_SCENARIO_H
#define NATIVE_SCENARIO_H

#include "native.h"

#include "scenario/config.h"

struct native_scenario
{
    common_scenario_t *scenario;
};

const common_loop_keys_t *native_scenario_loop(const native_scenario_t *scenario);

/// That it closes the loop.
bool native_scenario_has_loop(const native_scenario_t *scenario, common_error_t *error);

#endif
