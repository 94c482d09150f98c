// The public functions of the feed-forward that learn, and read or reset what is learned. None of them runs in the
// tick. This text serves both arithmetics and is included after words_f32.h or words_q31.h, and after reference.h.

/// Reads a sample in N, member by member, because accesses to volatile objects keep their order.
static void read_sample(const params_t *p, const volatile FEEDFORWARD(sample_t) * from, learner_sample_t *sample)
{
    const tribo_feedforward_learning_t *const in = &p->learning;

    sample->travelled_n = newtons(in, from->travelled);
    sample->friction_n  = newtons(in, from->friction);
    sample->noise_n     = newtons(in, from->noise);
    sample->effort_n    = newtons(in, from->effort);
    sample->need_n      = newtons(in, from->need);
    sample->flips       = from->flips;
    sample->turns       = from->turns;
    sample->chatter     = from->chatter;
    sample->learns      = from->learns != 0u;
    sample->moves       = from->moves != 0u;
    sample->starts      = from->starts != 0u;
}

bool FEEDFORWARD(learn)(const loop_params_t *loop, memory_t *memory)
{
    const params_t *const p = FEEDFORWARD(of)(loop);
    state_t *const        x = &memory->state;
    if (p == NULL || x->exchange.owner != TRIBO_FEEDFORWARD_OWNER_LEARNER)
    {
        return false;
    }
    const force_t    force  = x->exchange.sample.force;
    const prior_t    prior  = prior_of(&loop->compensator.friction, force);
    learner_sample_t sample = {.force_n = newtons(&p->learning, force),
                               .L_n     = newtons(&p->learning, prior.L),
                               .load_n  = newtons(&p->learning, prior.load)};
    read_sample(p, &x->exchange.sample, &sample);

    tribo_feedforward_f32_weights_t result;
    tribo_learner_step(&p->learning, &x->learner, &sample, &result);
    weights_t used = taken(&p->learning, &result);
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
