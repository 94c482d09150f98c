// The part of the guard's set-up that both arithmetics share.

#ifndef TRIBO_GUARD_PREPARE_H
#define TRIBO_GUARD_PREPARE_H

#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

/// Does all of tribo_guard_f32_init except the pointer to the step, which Q31 does not need.
tribo_status_t tribo_guard_f32_prepare(tribo_guard_f32_params_t       *params,
                                       const tribo_guard_f32_config_t *config,
                                       float                           sample_time_s);

#endif
