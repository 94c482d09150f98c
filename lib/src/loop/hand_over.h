// A change of params between two ticks. u continues from its value under the old params, even if gain, controller,
// friction and method have changed. This text serves both arithmetics.

/// Converts the controller's state to the params `to`, for the error `e`, and adds `offset` to its output.
static void convert(const loop_params_t *from, const loop_params_t *to, loop_state_t *state, force_t e, wide_t offset)
{
    NAME(biquad, state_t) *const cascade = &state->controller.cascade;
    NAME(biquad, change)(&from->controller.cascade, &to->controller.cascade, cascade, e, narrow(offset));
}

/// The params of the last tick. After a start, or if their pointer is corrupt, returns `params`, which means no change.
static const loop_params_t *active(const loop_state_t *state, const loop_params_t *params)
{
    const bool good = state->active != NULL && loop_sealed(state->active, state->active_seal);
    return good ? state->active : params;
}

/// The term of the paper's method with the friction of the last tick.
static force_t paper_term(const loop_params_t *params, const loop_state_t *state)
{
    uint32_t not_counted = 0;
    return loop_term(params, loop_faded(params, state), &not_counted);
}

/// The value of a flag in a memory. A flipped bit may leave a byte that is no bool, so its byte is read.
static bool is_set(const bool *flag)
{
    return *(const unsigned char *)flag != 0u;
}

/// Error, reading and term of the last tick under the params `from`. Where the method had no tick, the error `e` and
/// the reading `y` take their place.
static loop_tick_t last_of(const loop_params_t *from, const loop_state_t *state, force_t e, force_t y)
{
    loop_tick_t              last = {.OF(e) = e, .OF(y) = y};
    const loop_tick_t *const tick = loop_memory(state);
    if (from->method == NULL)
    {
        last.OF(term) = paper_term(from, state);
    }
    else if (tick != NULL)
    {
        last.OF(e)    = is_set(&tick->has_e) ? tick->OF(e) : e;
        last.OF(y)    = is_set(&tick->has_e) && is_set(&tick->has_y) ? tick->OF(y) : y;
        last.OF(term) = tick->OF(term);
    }
    return last;
}

/// u of this tick under the params `from`, before its limit.
static force_t unsaturated(const loop_params_t *from, loop_state_t *state, force_t r, force_t y)
{
    const loop_tick_t last = last_of(from, state, minus(r, y), y);
    // The error of the last tick with the change of y since.
    const wide_t  y_before = last.OF(y);
    const force_t e        = loop_input_is_bad(from, r, y) ? 0 : narrow(last.OF(e) + (y_before - y));
    return plus(loop_output(&from->controller, &state->controller, e), last.OF(term));
}

/// Changes from another method to the compensator, which starts at the sensor's reading with the friction that holds
/// the arm there.
static void enter_compensator(const loop_params_t *from,
                              const loop_params_t *params,
                              loop_state_t        *state,
                              force_t              r,
                              force_t              y,
                              force_t              e)
{
    const force_t u_before = unsaturated(from, state, r, y);
    const force_t u        = within_of(u_before, params->controller.OF(u_min), params->controller.OF(u_max));
    const force_t F        = beyond(y, params->OF(input_max)) ? u : y;
    state->OF(friction)    = compensator_enter(&params->compensator, &state->compensator, u, F);

    const wide_t  offset = u_before;
    const force_t v      = loop_output(&from->controller, &state->controller, e);
    convert(from, params, state, e, offset - paper_term(params, state) - v);
}

/// Changes to a method, from another method or from other params of the same one.
static void enter_method(const loop_params_t *from,
                         const loop_params_t *params,
                         loop_state_t        *state,
                         force_t              r,
                         force_t              y,
                         force_t              e)
{
    void *const       memory   = loop_memory(state);
    const loop_tick_t last     = last_of(from, state, e, y);
    const force_t     u_before = unsaturated(from, state, r, y);
    const bool        anew     = from->method == NULL || from->method->functions != params->method->functions;
    // If only the params of the method change, convert with its error of the last tick, which is close to this tick's.
    convert(from, params, state, anew ? e : last.OF(e), 0);
    if (memory != NULL)
    {
        loop_functions_t functions;
        params->method->functions(&functions);
        const force_t v = loop_output(&params->controller, &state->controller, e);
        functions.enter(memory, anew ? minus(u_before, v) : last.OF(term), anew);
    }
}

void loop_change(const loop_params_t *params, loop_state_t *state, force_t r, force_t y, force_t e)
{
    const loop_params_t *const from = active(state, params);
    if (!loop_sealed(state->active, state->active_seal))
    {
        count_one(&state->bad_inputs);
    }
    if (from == params)
    {
        loop_activate(state, params); // nothing to take over
    }
    else if (params->method != NULL)
    {
        enter_method(from, params, state, r, y, e);
        loop_activate(state, params);
    }
    else if (from->method != NULL)
    {
        enter_compensator(from, params, state, r, y, e);
        loop_activate(state, params);
    }
    else // makes up for the new gain in this tick; loop_change_friction does so for the new friction
    {
        const wide_t will = paper_term(params, state);
        convert(from, params, state, e, -(will - paper_term(from, state)));
    }
}

void loop_change_friction(const loop_params_t *params, loop_state_t *state, force_t e, force_t u)
{
    const loop_params_t *const from = active(state, params);

    const force_t was  = compensator_peek(&from->compensator, &state->compensator, u);
    const force_t will = compensator_peek(&params->compensator, &state->compensator, u);
    convert(params, params, state, e, -loop_jump(params, was, will, loop_fade(params, state)));
    loop_activate(state, params);
}
