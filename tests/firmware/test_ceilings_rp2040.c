// What the RP2040's ceilings leave of its detectors.

#include "port/rp2040/convert.h"
#include "port/rp2040/rig_config.h"

#define RIG_CONFIG rig_config()
#include "ceilings.h"
