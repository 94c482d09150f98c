// The part of the set-up of a loop and its guard in float32 that both arithmetics share. Whatever these functions return,
// they may have written `made`.

#ifndef TRIBO_LOOP_PREPARE_H
#define TRIBO_LOOP_PREPARE_H

#include "tribo/force_loop_f32.h"
#include "tribo/force_loop_q31.h"
#include "tribo/status.h"

/// The status of the controller's init. Of a PI's section it is about the gains, because the user has given no section.
tribo_status_t tribo_force_loop_f32_controller_status(const tribo_force_loop_f32_config_t *config,
                                                      tribo_status_t                       status);

/// Does all of tribo_force_loop_f32_init except the method and the guard. Writes the config's controller to
/// `controller`, always with sections. A PI becomes one section in `section`, to which `controller` then points: keep
/// it as long as `controller`.
tribo_status_t tribo_force_loop_f32_prepare(tribo_force_loop_f32_params_t       *made,
                                            const tribo_force_loop_f32_config_t *config,
                                            tribo_controller_f32_config_t       *controller,
                                            tribo_biquad_f32_section_t          *section);

/// Makes a controller of sections or a PI's only section. Returns TRIBO_OK or the status of the first bad field.
typedef tribo_status_t(tribo_controller_f32_make_t)(tribo_controller_f32_params_t       *made,
                                                    const tribo_controller_f32_config_t *controller,
                                                    float                                sample_time_s);

/// Makes any controller, with all of the checks of tribo_force_loop_f32_init.
tribo_controller_f32_make_t tribo_force_loop_f32_make_sections;

/// Does what tribo_force_loop_f32_prepare does, for a config that names a method, without linking the paper's. Of the
/// compensator's params it sets the breakaway and gravity, which other methods read; it does not check the arm. It
/// checks sections itself, because a pointer to a function of another source, as tribo_force_loop_f32_init_method takes,
/// needs an absolute address.
tribo_status_t tribo_force_loop_f32_prepare_method(tribo_force_loop_f32_params_t       *made,
                                                   const tribo_force_loop_f32_config_t *config,
                                                   tribo_controller_f32_config_t       *controller,
                                                   tribo_biquad_f32_section_t          *section);

/// Does what tribo_force_loop_f32_init does, for a config that names a method, without linking the paper's. `make` is
/// tribo_force_loop_f32_make_sections, or null for a PI with accepted limits of u, which needs little of the check.
tribo_status_t tribo_force_loop_f32_init_method(tribo_force_loop_f32_params_t       *made,
                                                const tribo_force_loop_f32_config_t *config,
                                                tribo_controller_f32_make_t         *make);

/// Does what tribo_force_loop_q31_init does, for a config that names a method, without linking the paper's.
tribo_status_t tribo_force_loop_q31_init_method(tribo_force_loop_q31_params_t       *made,
                                                const tribo_force_loop_q31_config_t *config);

/// Does all of tribo_guard_f32_init except the pointer to the step, which Q31 does not need.
tribo_status_t tribo_guard_f32_prepare(tribo_guard_f32_params_t       *params,
                                       const tribo_guard_f32_config_t *config,
                                       float                           sample_time_s);

#endif
