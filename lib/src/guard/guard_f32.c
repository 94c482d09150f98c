#include "guard_f32.h"

#include "tribo/force_loop_f32.h"
#include "tribo/status.h"

#include "../number/ranges.h"

#include <stddef.h>

#define ROW(...) PARAMETERS_ROW(tribo_guard_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_guard_parameters[] = {TRIBO_GUARD_PARAMETERS(ROW)};
#undef ROW

tribo_guard_f32_config_t tribo_guard_f32_default(void)
{
    const tribo_guard_f32_config_t standard = {TRIBO_GUARD_PARAMETERS(PARAMETERS_DEFAULT)};
    return standard;
}

tribo_status_t tribo_guard_f32_init(tribo_guard_f32_params_t       *params,
                                    const tribo_guard_f32_config_t *config,
                                    float                           sample_time_s)
{
    const tribo_status_t status = tribo_guard_f32_prepare(params, config, sample_time_s);
    if (status == TRIBO_OK)
    {
        params->step = tribo_guard_f32_step;
    }
    return status;
}

tribo_status_t tribo_guard_f32_prepare(tribo_guard_f32_params_t       *params,
                                       const tribo_guard_f32_config_t *config,
                                       float                           sample_time_s)
{
    if (params == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    if (!sample_time_ok(sample_time_s))
    {
        return TRIBO_ERR_SAMPLE_TIME;
    }
    const tribo_status_t status = PARAMETERS_CHECK(tribo_guard_parameters, config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (!(config->quick_time_s <= 1.0e5f * sample_time_s))
    {
        return TRIBO_ERR_GUARD_QUICK_TIME;
    }
    if (!(config->fade_time_s <= 1.0e6f * sample_time_s)) // of 1 less a smaller step only 1 would be left
    {
        return TRIBO_ERR_GUARD_FADE_TIME;
    }
    params->on          = 1;
    params->half_n      = 0.5f * config->turn_n;
    params->stray_n     = config->stray_n;
    params->work_n2     = config->turn_n * config->stray_n;
    params->fade_step   = limit_f32(sample_time_s / config->fade_time_s, 0.0f, 1.0f);
    params->quick_ticks = (uint32_t)(config->quick_time_s / sample_time_s + 0.5f) + 1u;
    return TRIBO_OK;
}

void tribo_guard_f32_reset(tribo_guard_f32_state_t *state)
{
    *state = (tribo_guard_f32_state_t){.fade = 1.0f};
}

void tribo_guard_f32_restore(tribo_guard_f32_state_t *state)
{
    state->cause   = TRIBO_GUARD_NONE;
    state->turns   = 0;
    state->strays  = 0;
    state->running = 0;
    guard_f32_begin(state);
}

void tribo_guard_f32_attach(tribo_force_loop_f32_state_t *loop, tribo_guard_f32_state_t *guard)
{
    loop->guard      = guard;
    loop->guard_seal = ~(uintptr_t)guard;
    loop->fade       = guard != NULL ? guard->fade : 1.0f;
}

float tribo_guard_f32_step(const tribo_guard_f32_params_t *params,
                           tribo_guard_f32_state_t        *state,
                           float                           r_n,
                           float                           y_n,
                           float                           f_n,
                           bool                            good)
{
    if (params->on == 0u)
    {
        tribo_guard_f32_restore(state);
    }
    else if (good && !exceeds(r_n, TRIBO_F32_FORCE_MAX_N) && !exceeds(y_n, TRIBO_F32_FORCE_MAX_N) &&
             !exceeds(f_n, TRIBO_F32_FORCE_MAX_N))
    {
        guard_f32_watch(params, state, r_n, y_n, f_n);
    }
    return guard_f32_fade(params, state);
}
