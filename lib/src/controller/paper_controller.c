// Made by tribo-design; see paper_controller.h. Input: paper.yaml, SHA-256
// 913234c6dce60bf29bb06d12e94b6322d8e15eca24864d499df0b9dee508b476.

#include "tribo/controller_f32.h"
#include "tribo/controller_q31.h"

#include "tribo/paper_controller.h"

// clang-format off
const tribo_biquad_f32_section_t tribo_paper_controller_f32[TRIBO_PAPER_CONTROLLER_SECTION_COUNT] = TRIBO_PAPER_CONTROLLER_F32;
const tribo_controller_q31_params_t tribo_paper_controller_q31 = TRIBO_PAPER_CONTROLLER_Q31;
// clang-format on
