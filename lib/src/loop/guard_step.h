// The functions of a running guard. This text serves both arithmetics.

#define guard_reset   NAME(guard, reset)
#define guard_restore NAME(guard, restore)
#define guard_step    NAME(guard, step)

void guard_reset(guard_state_t *state)
{
    *state = (guard_state_t){.fade = ALL};
}

void guard_restore(guard_state_t *state)
{
    state->cause   = TRIBO_GUARD_NONE;
    state->turns   = 0;
    state->strays  = 0;
    state->running = 0;
    guard_begin(state);
}

fade_t guard_step(const guard_params_t *params, guard_state_t *state, force_t r, force_t y, force_t f, bool good)
{
    if (params->on == 0u)
    {
        guard_restore(state);
    }
    else if (good && guard_is_credible(r, y, f))
    {
        guard_watch(params, state, r, y, f);
    }
    state->fade = guard_next_fade(state->fade, params->fade_step, state->cause == TRIBO_GUARD_NONE);
    return state->fade;
}
