// Made by tribo-design; see paper_controller.h. Input: paper.yaml, SHA-256
// e296fafb681c2c259aa3f884bc98d63099046c99f2955777a305ba4f044cea26.

#include "tribo/biquad_f32.h"
#include "tribo/controller_q31.h"

#include "tribo/paper_controller.h"

// clang-format off
const tribo_biquad_f32_section_t tribo_paper_controller_f32[TRIBO_PAPER_CONTROLLER_SECTION_COUNT] = TRIBO_PAPER_CONTROLLER_F32;
const tribo_controller_q31_params_t tribo_paper_controller_q31 = TRIBO_PAPER_CONTROLLER_Q31;
// clang-format on
