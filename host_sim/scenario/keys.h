/// The table of a scenario's keys: what it may hold, with unit, range, default, text, and where each value goes. Made into `tribo-sim
/// list --keys` and `--markdown`.

#ifndef SIM_KEYS_H
#define SIM_KEYS_H

#include "keys/table.h"
#include "scenario/config.h"

extern const common_key_t sim_keys[]; ///< of sim_config_t

#endif
