/// The force loop whose compensator believes in LuGre friction, in Q31: the twin of force_loop_lugre_f32.h, which says how it is
/// used and what it keeps to. tribo_force_loop_lugre_q31_init is in quantize_q31.h.
/// Not synchronized: one state, one tick.

#ifndef TRIBO_FORCE_LOOP_LUGRE_Q31_H
#define TRIBO_FORCE_LOOP_LUGRE_Q31_H

#include "tribo/force_loop_q31.h"

#ifdef __cplusplus
extern "C" {
#endif

/// params.method of a loop with LuGre.
extern const tribo_force_loop_q31_method_t tribo_force_loop_lugre_q31;

#ifdef __cplusplus
}
#endif

#endif
