#include "tribo/guard_f32.h"

#include "guard_f32_step.h"
#include "tribo/force_f32.h"

#include <stddef.h>

tribo_guard_f32_config_t tribo_guard_f32_default(void)
{
    const tribo_guard_f32_config_t standard = {.turn_n       = 0.05f,
                                               .quick_time_s = 0.2f,
                                               .stray_n      = 0.01f,
                                               .fade_time_s  = 0.5f};
    return standard;
}

tribo_status_t tribo_guard_f32_init(tribo_guard_f32_params_t       *params,
                                    const tribo_guard_f32_config_t *config,
                                    float                           sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!within(sample_time_s, 1.0e-6f, 0.1f))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    if (!within(config->turn_n, 1.0e-9f, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_GUARD_TURN;
    }
    if (!within(config->quick_time_s, 1.0e-6f, 1.0e5f * sample_time_s) ||
        !within(config->quick_time_s, 1.0e-6f, 1.0e3f) || !within(config->fade_time_s, 1.0e-6f, 1.0e3f))
    {
        return TRIBO_ERR_GUARD_TIME;
    }
    if (!within(config->stray_n, 1.0e-9f, TRIBO_F32_FORCE_MAX_N))
    {
        return TRIBO_ERR_GUARD_STRAY;
    }
    params->half_n      = 0.5f * config->turn_n;
    params->stray_n     = config->stray_n;
    params->work_n2     = config->turn_n * config->stray_n;
    params->fade        = limit_f32(sample_time_s / config->fade_time_s, 0.0f, 1.0f);
    params->quick_ticks = (uint32_t)(config->quick_time_s / sample_time_s + 0.5f) + 1u;
    return TRIBO_OK;
}

void tribo_guard_f32_reset(tribo_guard_f32_state_t *state)
{
    *state = (tribo_guard_f32_state_t){.share = 1.0f};
}

void tribo_guard_f32_restore(tribo_guard_f32_state_t *state)
{
    state->cause   = TRIBO_GUARD_NONE;
    state->turns   = 0;
    state->strays  = 0;
    state->running = false;
    guard_f32_begin(state);
}

float tribo_guard_f32_step(const tribo_guard_f32_params_t *params,
                           tribo_guard_f32_state_t        *state,
                           float                           r_n,
                           float                           y_n,
                           float                           f_n)
{
    if (!exceeds(r_n, TRIBO_F32_FORCE_MAX_N) && !exceeds(y_n, TRIBO_F32_FORCE_MAX_N) &&
        !exceeds(f_n, TRIBO_F32_FORCE_MAX_N))
    {
        guard_f32_watch(params, state, r_n, y_n, f_n);
    }
    return guard_f32_fade(params, state);
}
