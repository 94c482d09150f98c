/// The paper's bristles, Eq. (12).

#ifndef LUGRE_PAPER_H
#define LUGRE_PAPER_H

#include "tribo/friction_f32.h"

static inline tribo_lugre_f32_config_t lugre_paper(void)
{
    return (tribo_lugre_f32_config_t){.stiffness = 1e5f, .damping = 316.227766f, .viscous = 0.4f}; // s1 = 10^2.5
}

#endif
