// What friction fed forward buys, single precision: the monitor of docs/feedforward.md. No loops; one division at a reversal.
// Not synchronized: one state, one tick.

#ifndef TRIBO_FEEDFORWARD_MONITOR_F32_H
#define TRIBO_FEEDFORWARD_MONITOR_F32_H

#include "tribo/feedforward_f32.h"

#include "../number/first_order_f32.h"
#include "constants.h"
#include "feedback.h"

static inline void monitor_f32_start(tribo_feedforward_monitor_f32_state_t *x)
{
    x->begun = false; // the rest with the first motion
}

/// Once a sample: the travel of `v`, apart from the noise of y.
static inline void monitor_f32_step(const tribo_feedforward_f32_params_t  *params,
                                    tribo_feedforward_monitor_f32_state_t *x,
                                    float                                  v,
                                    float                                  noise)
{
    const float half = params->effort_half_n + 0.5f * FEEDFORWARD_NOISE_GAIN * noise;
    const float vf   = first_order_f32_step(x->v_n, v, params->effort_part);
    const float vp   = limit_f32(x->played_n, vf - half, vf + half);
    const float most = FEEDFORWARD_EFFORT_MAX * params->constant_max_n;
    x->travel_n      = limit_f32(x->travel_n + magnitude(vp - x->played_n), 0.0f, most);
    x->played_n      = vp;
    x->v_n           = exceeds(vf, FEEDFORWARD_FORCE_MAX_N) ? 0.0f : vf;
}

/// The travel of v begins here: a controller that runs already has a `v`, and has not travelled there.
static inline void monitor_f32_begin(tribo_feedforward_monitor_f32_state_t *x, float v)
{
    x->begun    = true;
    x->v_n      = v;
    x->played_n = v;
}

/// At a reversal: that travel, over the change of what overcomes friction since the last, `need`; or one less to be fed back.
static inline void monitor_f32_judge(const tribo_feedforward_f32_params_t  *params,
                                     tribo_feedforward_monitor_f32_state_t *x,
                                     float                                  v,
                                     float                                  need)
{
    if (feedback_is_on(&x->feedback))
    {
        monitor_f32_begin(x, v);
        x->ratio = feedback_ends(&x->feedback) ? FEEDFORWARD_PROBATION : x->ratio;
    }
    else if (!x->begun)
    {
        monitor_f32_begin(x, v);
    }
    else
    {
        const float least = FEEDFORWARD_NEED_MIN * params->constant_max_n;
        const float ratio = x->travel_n / (magnitude(need - x->need_n) + least);
        const float now   = limit_f32(ratio, 0.0f, FEEDFORWARD_EFFORT_MAX);
        const float xi    = first_order_f32_step(x->ratio, now, FEEDFORWARD_EFFORT_PART);
        x->ratio          = within(xi, 0.0f, FEEDFORWARD_EFFORT_MAX) ? xi : 0.0f;
        feedback_judge(&x->feedback, x->ratio > FEEDFORWARD_HARM);
    }
    x->need_n   = need;
    x->travel_n = 0.0f;
}

#endif
