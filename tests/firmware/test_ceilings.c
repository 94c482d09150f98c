// What the STM32F405's ceilings leave of its detectors.

#include "port/stm32f405/convert.h"
#include "port/stm32f405/rig_config.h"

#define RIG_CONFIG rig_config
#include "ceilings.h"
