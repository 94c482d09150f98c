// The set-up of a loop in float32 without its parts, for both arithmetics.

#ifndef TRIBO_LOOP_PREPARE_H
#define TRIBO_LOOP_PREPARE_H

#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

/// All of tribo_force_loop_f32_init but the method and the guard. `controller` is the config's, with sections; those of a PI are in
/// `section`, which outlives it.
tribo_status_t tribo_force_loop_f32_prepare(tribo_force_loop_f32_params_t       *params,
                                            const tribo_force_loop_f32_config_t *config,
                                            tribo_controller_f32_config_t       *controller,
                                            tribo_biquad_f32_section_t          *section);

#endif
