// The monitor in fixed point; monitor_f32.h has the equations. Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_MONITOR_Q31_H
#define TRIBO_FEEDFORWARD_MONITOR_Q31_H

#include "tribo/feedforward_q31.h"
#include "tribo/q31.h"

#include "../number/first_order_q31.h"
#include "bank_q31.h"
#include "constants.h"
#include "feedback.h"

static inline void monitor_q31_start(tribo_feedforward_monitor_q31_state_t *x)
{
    x->begun = false;
}

static inline void monitor_q31_step(const tribo_feedforward_q31_params_t  *params,
                                    tribo_feedforward_monitor_q31_state_t *x,
                                    int32_t                                v,
                                    uint32_t                               noise)
{
    const int32_t  half  = (int32_t)(params->effort_half + noise / BANK_Q31_NOISE_PER(0.5f * FEEDFORWARD_NOISE_GAIN));
    const int32_t  vf    = first_order_q31_step(x->v, v, params->effort_part);
    const int32_t  vp    = limit_q31(x->played, difference_q31(vf, half), sum_q31(vf, half));
    const uint32_t moved = tribo_q31_magnitude(difference_q31(vp, x->played));
    const uint32_t most  = (uint32_t)FEEDFORWARD_EFFORT_MAX * (uint32_t)params->constant_max;
    x->travel            = x->travel < most && moved < most - x->travel ? x->travel + moved : most;
    x->played            = vp;
    x->v                 = vf;
}

static inline void monitor_q31_begin(tribo_feedforward_monitor_q31_state_t *x, int32_t v)
{
    x->begun  = true;
    x->v      = v;
    x->played = v;
}

static inline void monitor_q31_judge(const tribo_feedforward_q31_params_t  *params,
                                     tribo_feedforward_monitor_q31_state_t *x,
                                     int32_t                                v,
                                     int32_t                                need)
{
    const int32_t now = limit_q31(need, 1 - 2 * BANK_Q31_ONE, 2 * BANK_Q31_ONE - 1);
    if (feedback_is_on(&x->feedback))
    {
        monitor_q31_begin(x, v);
        x->ratio = feedback_ends(&x->feedback) ? (uint32_t)BANK_Q31_Q29(FEEDFORWARD_PROBATION) : x->ratio;
    }
    else if (!x->begun)
    {
        monitor_q31_begin(x, v);
    }
    else
    {
        const uint32_t least = tribo_q31_high((uint32_t)params->constant_max, BANK_Q31_Q32(FEEDFORWARD_NEED_MIN));
        const uint32_t moved = tribo_q31_magnitude(difference_q31(now, x->need)) + least;
        const uint32_t ratio = ratio_q31(x->travel / 4u, moved); // Q29, below 4
        const uint32_t known = x->ratio <= (uint32_t)INT32_MAX ? x->ratio : 0u;
        x->ratio             = bank_q31_pass(known, ratio, BANK_Q31_Q32(FEEDFORWARD_EFFORT_PART));
        feedback_judge(&x->feedback, x->ratio > (uint32_t)BANK_Q31_Q29(FEEDFORWARD_HARM));
    }
    x->need   = now;
    x->travel = 0;
}

#endif
