// What the tick and a change of params share. This text serves both arithmetics and is included by loop_f32.h or
// loop_q31.h.

typedef NAME(force_loop, params_t) loop_params_t;
typedef NAME(force_loop, state_t) loop_state_t;
typedef NAME(force_loop, signals_t) loop_signals_t;
typedef NAME(force_loop, method_t) loop_method_t;
typedef NAME(force_loop, functions_t) loop_functions_t;
typedef NAME(force_loop, tick_t) loop_tick_t;

#define loop_change          NAME(force_loop, change)
#define loop_change_friction NAME(force_loop, change_friction)

/// True if `pointer` fits its seal. Each pointer in the state has its complement as a seal. A pointer with a flipped
/// bit is not used, and is counted where it is found.
static inline bool loop_sealed(const void *pointer, uintptr_t seal)
{
    return seal == ~(uintptr_t)pointer;
}

static inline void loop_activate(loop_state_t *state, const loop_params_t *params)
{
    state->active      = params;
    state->active_seal = ~(uintptr_t)params;
}

/// The memory of the method. Null if the state names none, or if its pointer is corrupt.
static inline void *loop_memory(const loop_state_t *state)
{
    return loop_sealed(state->memory, state->memory_seal) ? state->memory : NULL;
}

/// The guard's factor on friction: all of it without a guard.
static inline fade_t loop_fade(const loop_params_t *params, const loop_state_t *state)
{
    return params->guard != NULL ? state->guard.fade : ALL;
}

/// f^ of the last tick, faded by the guard.
static inline force_t loop_faded(const loop_params_t *params, const loop_state_t *state)
{
    return faded_by(state->OF(friction), loop_fade(params, state));
}

static inline bool loop_input_is_bad(const loop_params_t *params, force_t r, force_t y)
{
    return beyond(r, params->OF(input_max)) || beyond(y, params->OF(input_max));
}

/// Takes over from the old params without a jump of u. Call it in the first tick with `params`, before the controller's
/// step. If state.active is not `params` afterwards, loop_change_friction completes the change.
void loop_change(const loop_params_t *params, loop_state_t *state, force_t r, force_t y, force_t e);

/// Makes the controller subtract the jump of u that new friction would cause in the next tick. Call it before the
/// compensator's step.
void loop_change_friction(const loop_params_t *params, loop_state_t *state, force_t e, force_t u);
