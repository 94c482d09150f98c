#include "guard_q31.h"

#include "tribo/force_loop_f32.h"
#include "tribo/force_loop_q31.h"

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "guard_f32.h"

#include <stddef.h>

tribo_status_t tribo_guard_q31_init(tribo_guard_q31_params_t       *params,
                                    const tribo_guard_f32_config_t *config,
                                    float                           sample_time_s,
                                    float                           full_scale_n)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_guard_f32_params_t f32;
    const tribo_status_t     status = tribo_guard_f32_prepare(&f32, config, sample_time_s);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    if (!within(config->turn_n / full_scale_n, FIXED_Q31_SMALLEST, FIXED_Q31_FULL))
    {
        return TRIBO_ERR_GUARD_TURN;
    }
    if (!within(config->stray_n / full_scale_n, FIXED_Q31_SMALLEST, FIXED_Q31_FULL))
    {
        return TRIBO_ERR_GUARD_STRAY;
    }
    params->step        = tribo_guard_q31_step;
    params->on          = 1;
    params->half        = fixed(f32.half_n / full_scale_n, 29);
    params->stray       = fixed(f32.stray_n / full_scale_n, 28);
    params->work        = (int64_t)fixed(f32.half_n / full_scale_n, 29) * fixed(f32.stray_n / full_scale_n, 28) / 8192;
    params->fade_step   = fixed_unsigned(f32.fade_step, 32);
    params->quick_ticks = f32.quick_ticks;
    return TRIBO_OK;
}

void tribo_guard_q31_reset(tribo_guard_q31_state_t *state)
{
    *state = (tribo_guard_q31_state_t){.fade = UINT32_MAX};
}

void tribo_guard_q31_restore(tribo_guard_q31_state_t *state)
{
    state->cause   = TRIBO_GUARD_NONE;
    state->turns   = 0;
    state->strays  = 0;
    state->running = 0;
    guard_q31_begin(state);
}

void tribo_guard_q31_attach(tribo_force_loop_q31_state_t *loop, tribo_guard_q31_state_t *guard)
{
    loop->guard      = guard;
    loop->guard_seal = ~(uintptr_t)guard;
    loop->fade       = guard != NULL ? guard->fade : UINT32_MAX;
}

uint32_t tribo_guard_q31_step(const tribo_guard_q31_params_t *params,
                              tribo_guard_q31_state_t        *state,
                              int32_t                         r,
                              int32_t                         y,
                              int32_t                         f,
                              bool                            good)
{
    if (params->on == 0u)
    {
        tribo_guard_q31_restore(state);
    }
    else if (good && !guard_q31_is_end(r) && !guard_q31_is_end(y))
    {
        guard_q31_watch(params, state, r, y, f);
    }
    return guard_q31_fade(params, state);
}
