#include "scenario/loop_functions.h"

#include "tribo_arithmetic.h"

#define IN(loop) TRIBO_EITHER(&(loop)->in_f32, &(loop)->in_q31)

static tribo_status_t init(sim_loop_t *loop, const common_loop_config_t *config)
{
    TRIBO_PART(sim_loop, t) *in = IN(loop);
    const tribo_force_loop_f32_config_t whole =
        tribo_loop_with_parts(&config->parts, &in->feedforward, &in->guard_params);

    in->state.memory            = config->parts.feeds_forward ? &in->memory.state.tick : NULL;
    const tribo_status_t status = tribo_init_loop(&in->params, in->table, &whole, (float)loop->full_scale_n);
    return status == TRIBO_OK ? TRIBO(force_loop, start)(&in->state, &in->params, false) : status;
}

static sim_learned_t learned(const sim_loop_t *loop, double force_n)
{
    const TRIBO_PART(sim_loop, t) *in = IN(loop);
    const tribo_force_t force         = tribo_force_of_n(force_n, loop->full_scale_n);
    sim_learned_t       seen          = {.breakaway_n = {0.0}};
    for (uint32_t d = 0; d < 2u; d++)
    {
        const tribo_feedforward_learned_t at = TRIBO(feedforward, learned)(&in->params, &in->memory.state, d, force);

        seen.breakaway_n[d]       = (double)at.L_n;
        seen.relative_variance[d] = (double)at.relative_variance;
        seen.travel_n[d]          = (double)at.travel_n;
        seen.at_bound[d]          = at.at_bound;
        seen.stays_at_bound[d]    = at.stays_at_bound;
        seen.harms                = at.harms;
        seen.forgotten            = at.forgotten;
    }
    return seen;
}

static double largest_n(const sim_loop_t *loop)
{
    return TRIBO_EITHER((double)loop->in_f32.params.input_max_n, 0.999 * loop->full_scale_n);
}

static uint32_t word(const sim_loop_t *loop, double force_n)
{
    return tribo_force_word(tribo_force_of_n(force_n, loop->full_scale_n));
}

static double force(const sim_loop_t *loop, uint32_t of_word)
{
    return tribo_force_n(tribo_force_of_word(of_word), loop->full_scale_n);
}

static tribo_force_t step_forces(sim_loop_t *loop, tribo_force_t r, tribo_force_t y, uint32_t words[TRIBO_SIGNAL_WORDS])
{
    TRIBO(force_loop, signals_t) signals;
    const tribo_force_t u = TRIBO(force_loop, step)(&IN(loop)->params, &IN(loop)->state, r, y, &signals);
    (void)TRIBO(feedforward, learn)(&IN(loop)->params, &IN(loop)->memory);
    tribo_signal_words(&signals, words);
    return u;
}

static void step_words(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[TRIBO_SIGNAL_WORDS])
{
    (void)step_forces(loop, tribo_force_of_word(r), tribo_force_of_word(y), words);
}

static void signals_of(const sim_loop_t               *loop,
                       const uint32_t                  words[TRIBO_SIGNAL_WORDS],
                       tribo_force_loop_f32_signals_t *signals)
{
    tribo_friction_f32_signals_t *friction = &signals->compensator.friction;
#define FORCE(place, text, f32, q31) signals->f32 = (float)force(loop, words[TRIBO_SIGNAL_##place]);
    TRIBO_SIGNAL_FORCES(FORCE)
#undef FORCE
#if TRIBO_IS_Q31 // Q31 has the rise in a tick
    friction->v_n_per_s = (float)(force(loop, words[TRIBO_SIGNAL_RATE]) / loop->sample_time_s);
#endif
    signals->controller.limited = (words[TRIBO_SIGNAL_FLAGS] & TRIBO_SIGNAL_LIMITED) != 0u;
    friction->relays            = (uint8_t)(words[TRIBO_SIGNAL_FLAGS] >> 1);
}

static double step(sim_loop_t *loop, double r_n, double y_n, tribo_force_loop_f32_signals_t *seen)
{
    const double        full_scale_n = loop->full_scale_n;
    uint32_t            words[TRIBO_SIGNAL_WORDS];
    const tribo_force_t u =
        step_forces(loop, tribo_force_of_n(r_n, full_scale_n), tribo_force_of_n(y_n, full_scale_n), words);
    signals_of(loop, words, seen);
    return tribo_force_n(u, full_scale_n);
}

static tribo_guard_cause_t guard_cause(const sim_loop_t *loop)
{
    return IN(loop)->state.guard.cause;
}

static uint32_t limited_ticks(const sim_loop_t *loop)
{
    return IN(loop)->state.controller.limited_ticks;
}

static uint32_t bad_inputs(const sim_loop_t *loop)
{
    return IN(loop)->state.bad_inputs;
}

const sim_loop_functions_t TRIBO_PART(sim_loop, functions) = {.init          = init,
                                                              .learned       = learned,
                                                              .largest_n     = largest_n,
                                                              .word          = word,
                                                              .force         = force,
                                                              .step          = step,
                                                              .step_words    = step_words,
                                                              .signals       = signals_of,
                                                              .guard_cause   = guard_cause,
                                                              .limited_ticks = limited_ticks,
                                                              .bad_inputs    = bad_inputs};
