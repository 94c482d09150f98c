// The functions of a guard beside its init. This text serves both arithmetics.

void NAME(guard, reset)(guard_state_t *state)
{
    *state = (guard_state_t){.fade = ALL};
}

void NAME(guard, restore)(guard_state_t *state)
{
    state->cause   = TRIBO_GUARD_NONE;
    state->turns   = 0;
    state->strays  = 0;
    state->running = 0;
    guard_begin(state);
}

fade_t NAME(guard, step)(const guard_params_t *params, guard_state_t *state, force_t r, force_t y, force_t f, bool good)
{
    if (params->on == 0u)
    {
        NAME(guard, restore)(state);
    }
    else if (good && guard_is_credible(r, y, f))
    {
        guard_watch(params, state, r, y, f);
    }
    state->fade = next_fade(state->fade, params->fade_step, state->cause == TRIBO_GUARD_NONE);
    return state->fade;
}

static tribo_status_t part_make(const tribo_loop_part_t             *part,
                                const tribo_force_loop_f32_config_t *loop,
                                float                                full_scale_n,
                                NAME(force_loop, params_t) * made)
{
    guard_params_t *const params = (guard_params_t *)part->params;
    made->guard                  = params;
    (void)full_scale_n; // not used in float32
    return guard_init(params, (const tribo_guard_f32_config_t *)part->config, loop->sample_time_s, full_scale_n);
}

tribo_loop_guard_t NAME(guard, use)(guard_params_t *params, const tribo_guard_f32_config_t *config)
{
    tribo_loop_guard_t guard = {.part = {.config = config, .params = params}};
    guard.part.TYPED(make)   = part_make;
    return guard;
}
