// The set-up of a loop without its parts, for its init and for the search for what was refused.

#ifndef TRIBO_LOOP_PREPARE_H
#define TRIBO_LOOP_PREPARE_H

#include "tribo/force_loop_f32.h"
#include "tribo/force_loop_q31.h"
#include "tribo/status.h"

/// All of tribo_force_loop_f32_init but the method and the guard.
tribo_status_t tribo_force_loop_f32_prepare(tribo_force_loop_f32_params_t       *params,
                                            const tribo_force_loop_f32_config_t *config);

/// The same of tribo_force_loop_q31_init. `headroom` may be null.
tribo_status_t tribo_force_loop_q31_prepare(tribo_force_loop_q31_params_t       *made,
                                            const tribo_force_loop_q31_config_t *config,
                                            tribo_headroom_q31_t                *headroom);

#endif
