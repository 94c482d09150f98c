// Friction compensator of Fig. 11. This text serves both arithmetics and is included by compensator_f32.h or
// compensator_q31.h. One tick:
//
//     u ---> n = u - F^ + g ---> friction ---> f^ ---> the loop adds gain f^ to u at the next tick
//            ^                      |
//            '---- F^ <--- arm <----' d = n - f^
//
//     1. F^ = K theta^, the force of the arm model. The force sensor is not used: its noise would look like a reversal of n
//     2. f^ = friction(n, F^)
//     3. the arm model advances one sample with u and f^ held
//
// The caller has checked u. Not synchronized: one state, one tick.

typedef NAME(compensator, params_t) compensator_params_t;
typedef NAME(compensator, state_t) compensator_state_t;
typedef NAME(compensator, signals_t) compensator_signals_t;

/// f^ for the net force `n` at the arm's force `F`. The arm advances to the next tick.
static inline force_t compensator_advance(const compensator_params_t *params,
                                          compensator_state_t        *state,
                                          force_t                     n,
                                          force_t                     F,
                                          compensator_signals_t      *signals)
{
    signals->OF(force) = F;
    const force_t f    = INNER(friction, step)(&params->friction, &state->friction, n, F, &signals->friction);
    // The drive d = u + g - F^ - f^ cannot overflow: |f^| <= |n|, with the same sign. Below breakaway f^ = n, so d is
    // exactly 0 and the arm sticks.
    INNER(arm, step)(&params->arm, &state->arm, n - f);
    return f;
}

/// f^ for this tick. The arm advances to the next one.
static inline force_t compensator_tick(const compensator_params_t *params,
                                       compensator_state_t        *state,
                                       force_t                     u,
                                       compensator_signals_t      *signals)
{
    const force_t F = force_of_arm(&state->arm);
    const force_t n = INNER(friction, net_force)(&params->friction, &state->friction, u, F);
    return compensator_advance(params, state, n, F, signals);
}

/// The f^ that `params` would give for `u` in this tick. No state advances: what the step changes is restored.
static inline force_t compensator_peek(const compensator_params_t *params, compensator_state_t *state, force_t u)
{
    NAME(friction, signals_t) unseen;
    NAME(friction, state_t) *const friction = &state->friction;
    const tribo_relay_latch_t      latch    = friction->relay.latch;
    const uint8_t                  head     = friction->relay.edge.head; // the next step overwrites this one's entry
    const force_t                  n_before = friction->OF(n);
    const uint32_t                 counted  = *friction_counter(friction);

    const force_t f = NAME(friction, step)(&params->friction, friction, u, force_of_arm(&state->arm), &unseen);

    friction->relay.latch       = latch;
    friction->relay.edge.head   = head;
    friction->OF(n)             = n_before;
    *friction_counter(friction) = counted;
    return f;
}

/// Starts with an arm at rest at `F` under `u`. Returns the f^ that holds the arm there, as far as L allows.
static inline force_t compensator_enter(const compensator_params_t *params,
                                        compensator_state_t        *state,
                                        force_t                     u,
                                        force_t                     F)
{
    const force_t n = INNER(friction, net_force)(&params->friction, &state->friction, u, F);
    NAME(compensator, reset)(state);
    place_arm(&state->arm, F);
    state->friction.OF(n) = n;
    return compensator_peek(params, state, u);
}
