// Worst-case gains of a quantised cascade, and the scales of its nodes.

#ifndef TRIBO_CONTROLLER_HEADROOM_Q31_H
#define TRIBO_CONTROLLER_HEADROOM_Q31_H

#include "tribo/controller_f32.h"
#include "tribo/controller_q31.h"

/// Quantises the cascade in `f32` (headroom_q31.c) for |e| <= `e_peak` and |u - term| <= `s_peak`, both as a fraction
/// of full scale. The scale of each node comes from its worst-case peak, so that no node can overflow. `f32` is then
/// rebuilt from the quantised numbers, which checks their stability: with `config` and its `conditioned_by`, or as a
/// bare cascade if `config` is null. Both steps run twice, so that scales and report belong to the final numbers.
/// `headroom` may be null.
tribo_status_t tribo_headroom_q31_quantize(tribo_biquad_q31_params_t           *out,
                                           tribo_controller_f32_params_t       *f32,
                                           const tribo_controller_f32_config_t *config,
                                           float                               *conditioned_by,
                                           float                                e_peak,
                                           float                                s_peak,
                                           tribo_headroom_q31_t                *headroom);

#endif
