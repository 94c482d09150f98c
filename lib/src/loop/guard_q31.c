#include "guard_q31.h"

#include "tribo/force_loop_f32.h"
#include "tribo/force_loop_q31.h"

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "prepare.h"

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

#define guard_init tribo_guard_q31_init

#include "guard_step.h"
