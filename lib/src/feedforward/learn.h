// The public functions of the feed-forward that learn, and read or reset what is learned. None of them runs in the
// tick. This text serves both arithmetics and is included after words_f32.h or words_q31.h, and after reference.h.

bool FEEDFORWARD(learn)(const loop_params_t *loop, memory_t *memory)
{
    const params_t *const p = FEEDFORWARD(of)(loop);
    state_t *const        x = &memory->state;
    if (p == NULL || x->exchange.owner != TRIBO_FEEDFORWARD_OWNER_LEARNER)
    {
        return false;
    }
    const tribo_feedforward_learning_t *const   in = &p->learning;
    const volatile FEEDFORWARD(sample_t) *const of = &x->exchange.sample;

    const force_t          force  = of->force;
    const prior_t          prior  = prior_of(&loop->compensator.friction, force);
    const learner_sample_t sample = {.travelled_n = newtons(in, of->travelled),
                                     .force_n     = newtons(in, force),
                                     .friction_n  = newtons(in, of->friction),
                                     .noise_n     = newtons(in, of->noise),
                                     .effort_n    = newtons(in, of->effort),
                                     .need_n      = newtons(in, of->need),
                                     .L_n         = newtons(in, prior.L),
                                     .load_n      = newtons(in, prior.load),
                                     .flips       = of->flips,
                                     .turns       = of->turns,
                                     .chatter     = of->chatter,
                                     .learns      = of->learns != 0u,
                                     .moves       = of->moves != 0u,
                                     .starts      = of->starts != 0u};

    tribo_feedforward_f32_weights_t result;
    tribo_learner_step(in, &x->learner, &sample, &result);
    weights_t used = taken(in, &result);
    used.seal      = seal_of(&used);
    copy_weights(&x->exchange.result, &used);
    x->exchange.owner = TRIBO_FEEDFORWARD_OWNER_RESULT;
    return true;
}

void FEEDFORWARD(reset)(state_t *state)
{
    *state = (state_t){.mode = TRIBO_FEEDFORWARD_RESTART};
    tribo_learner_forget(&state->learner);
}

tribo_feedforward_learned_t FEEDFORWARD(learned)(const loop_params_t *params,
                                                 const state_t       *state,
                                                 uint32_t             direction,
                                                 force_t              force)
{
    if (params->method == NULL)
    {
        return (tribo_feedforward_learned_t){.L_n = 0.0f};
    }
    const tribo_feedforward_learning_t *const learning = &params_of(params)->learning;
    const friction_params_t *const            friction = &params->compensator.friction;

    const force_t         at    = is_credible(force, CREDIBLE_N) ? inside(force) : 0;
    const prior_t         prior = prior_of(friction, at);
    const learner_place_t place = {.sign      = (direction & 1u) == TRIBO_BREAKAWAY_POSITIVE ? 1.0f : -1.0f,
                                   .force_n   = newtons(learning, at),
                                   .L_n       = newtons(learning, prior.L),
                                   .load_n    = newtons(learning, plus(prior.load, inside(friction->OF(gravity)))),
                                   .late      = state->late,
                                   .forgotten = state->forgotten};
    return tribo_learner_readout(learning, &state->learner, &place);
}

void FEEDFORWARD(restore)(state_t *state)
{
    weights_t *const w = &state->weights;
    if (w->seal == seal_of(w))
    {
        w->fed_back = 0;
        w->seal     = seal_of(w);
    }
    tribo_learner_restore(&state->learner);
}
