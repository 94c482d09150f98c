/// The force loop whose compensator believes in LuGre friction, Eq. (12) (lugre_f32.h), in place of the paper's Eq. (3), single
/// precision.
///
///     tribo_force_loop_lugre_f32_init(&params, &lugre, &config, &lugre_config);
///     tribo_force_loop_f32_reset(&state);
///     u = tribo_force_loop_f32_step(&params, &state, r, y, &signals);
///
/// The loop is otherwise the paper's: gain f^ of the last tick is added, f^ comes from u and from the F^ of the arm model, and
/// breakaway L(F) (law or table) and gravity are those of config.compensator.friction; its k, m, v0 and relays are not read.
/// Its guarantees are the same: limits, anti-windup, bad inputs, change of params by pointer, between methods as well. A loop
/// that takes LuGre up starts at the force that the sensor says, with the bristles that hold the arm there; u goes on from where
/// it was. Of the signals, L is that on the side of f^, v and the relays are 0.
///
/// Nothing more is kept than by the paper's method. A corrupt state starts again from rest.
/// Not synchronized: one state, one tick.

#ifndef TRIBO_FORCE_LOOP_LUGRE_F32_H
#define TRIBO_FORCE_LOOP_LUGRE_F32_H

#include "tribo/force_loop_f32.h"

#ifdef __cplusplus
extern "C" {
#endif

/// params.method of a loop with LuGre.
extern const tribo_force_loop_f32_method_t tribo_force_loop_lugre_f32;

/// Makes `params` of a loop with LuGre, and LuGre's own, to which `params` will point: they must live as long. Returns what
/// tribo_force_loop_f32_init and then tribo_lugre_f32_init say. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_force_loop_lugre_f32_init(tribo_force_loop_f32_params_t       *params,
                                               tribo_lugre_f32_params_t            *lugre,
                                               const tribo_force_loop_f32_config_t *config,
                                               const tribo_lugre_f32_config_t      *lugre_config);

#ifdef __cplusplus
}
#endif

#endif
