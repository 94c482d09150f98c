// What the set-up of both arithmetics shares.

#ifndef TRIBO_LOOP_PREPARE_H
#define TRIBO_LOOP_PREPARE_H

#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

/// All of tribo_force_loop_f32_init but the method and the guard.
tribo_status_t tribo_force_loop_f32_prepare(tribo_force_loop_f32_params_t       *params,
                                            const tribo_force_loop_f32_config_t *config);

#endif
