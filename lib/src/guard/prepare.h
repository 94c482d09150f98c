// What the set-up of both arithmetics shares.

#ifndef TRIBO_GUARD_PREPARE_H
#define TRIBO_GUARD_PREPARE_H

#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

/// All of tribo_guard_f32_init but the pointer to the step, which Q31 has no use for.
tribo_status_t tribo_guard_f32_prepare(tribo_guard_f32_params_t       *params,
                                       const tribo_guard_f32_config_t *config,
                                       float                           sample_time_s);

#endif
