// A cascade in fixed point with room for all that it can compute, measured on the numbers that run. Not for a step.

#ifndef TRIBO_HEADROOM_Q31_H
#define TRIBO_HEADROOM_Q31_H

#include "tribo/quantize_q31.h"

/// Quantises the cascade of `f32` for inputs within `e_peak` and `s_peak`, as a fraction of full scale, then makes `f32`
/// anew from the quantised numbers (by `config`, or as a plain cascade without one), which checks that they are stable. All
/// of it twice: the scales and the report are then those of the numbers that run. `headroom` may be null.
tribo_status_t headroom_q31_quantize(tribo_biquad_q31_params_t           *out,
                                     tribo_controller_f32_params_t       *f32,
                                     const tribo_controller_f32_config_t *config,
                                     float                                e_peak,
                                     float                                s_peak,
                                     tribo_headroom_q31_t                *headroom);

#endif
