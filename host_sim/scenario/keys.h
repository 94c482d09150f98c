/// The table of a scenario's keys, with unit, range, default, text and the place of each value. `tribo-sim list --keys` and
/// `--markdown` print it.

#ifndef SIM_KEYS_H
#define SIM_KEYS_H

#include "keys/table.h"
#include "scenario/config.h"

extern const common_key_t sim_keys[]; ///< keys of sim_config_t

#endif
