// The part of a loop's set-up in float32 that both arithmetics share.

#ifndef TRIBO_LOOP_PREPARE_H
#define TRIBO_LOOP_PREPARE_H

#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

/// Does all of tribo_force_loop_f32_init except the method and the guard. Writes the config's controller to
/// `controller`, always with sections. A PI becomes one section in `section`, to which `controller` then points: keep
/// it as long as `controller`.
tribo_status_t tribo_force_loop_f32_prepare(tribo_force_loop_f32_params_t       *params,
                                            const tribo_force_loop_f32_config_t *config,
                                            tribo_controller_f32_config_t       *controller,
                                            tribo_biquad_f32_section_t          *section);

#endif
