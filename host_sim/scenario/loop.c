#include "scenario/loop.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

int32_t sim_q31_from_n(double force_n, double full_scale_n)
{
    return (int32_t)fmax(-2147483647.0, fmin(2147483647.0, round(force_n / full_scale_n * 2147483648.0)));
}

double sim_n_from_q31(int32_t x, double full_scale_n)
{
    return x / 2147483648.0 * full_scale_n;
}

static tribo_status_t init_f32(sim_loop_t *loop, const sim_loop_config_t *config)
{
    if (config->has_lugre)
    {
        return tribo_force_loop_lugre_f32_init(&loop->params_f32, &loop->lugre_f32, &config->config, &config->lugre);
    }
    return config->feeds_forward ? tribo_force_loop_feedforward_f32_init(&loop->params_f32,
                                                                         &loop->feedforward_f32,
                                                                         &config->config,
                                                                         &config->feedforward)
                                 : tribo_force_loop_f32_init(&loop->params_f32, &config->config);
}

static tribo_status_t init_q31(sim_loop_t *loop, const sim_loop_config_t *config)
{
    const float FS = (float)loop->full_scale_n;
    if (config->has_lugre)
    {
        return tribo_force_loop_lugre_q31_init(&loop->params_q31,
                                               loop->table,
                                               &loop->lugre_q31,
                                               &config->config,
                                               &config->lugre,
                                               FS,
                                               NULL);
    }
    return config->feeds_forward ? tribo_force_loop_feedforward_q31_init(&loop->params_q31,
                                                                         loop->table,
                                                                         &loop->feedforward_q31,
                                                                         &config->config,
                                                                         &config->feedforward,
                                                                         FS,
                                                                         NULL)
                                 : tribo_force_loop_q31_init(&loop->params_q31, loop->table, &config->config, FS, NULL);
}

static tribo_status_t init_guard(sim_loop_t *loop, const sim_loop_config_t *config)
{
    const float h         = config->config.sample_time_s;
    loop->guarded         = config->guarded;
    tribo_status_t status = TRIBO_OK;
    tribo_guard_f32_reset(&loop->guard_f32);
    tribo_guard_q31_reset(&loop->guard_q31);
    if (config->guarded)
    {
        status = loop->q31 ? tribo_guard_q31_init(&loop->guard_params_q31, &config->guard, h, (float)loop->full_scale_n)
                           : tribo_guard_f32_init(&loop->guard_params_f32, &config->guard, h);
    }
    return status;
}

tribo_status_t sim_loop_init(sim_loop_t *loop, bool q31, const sim_loop_config_t *config, double full_scale_n)
{
    *loop =
        (sim_loop_t){.q31 = q31, .full_scale_n = full_scale_n, .sample_time_s = (double)config->config.sample_time_s};
    tribo_status_t status = q31 ? init_q31(loop, config) : init_f32(loop, config);
    if (status == TRIBO_OK)
    {
        status = init_guard(loop, config);
    }
    tribo_force_loop_f32_reset(&loop->state_f32);
    tribo_force_loop_q31_reset(&loop->state_q31);
    if (status == TRIBO_OK && config->feeds_forward)
    {
        tribo_feedforward_f32_reset(&loop->feedforward_f32, &loop->memory_f32.state);
        tribo_feedforward_q31_reset(&loop->feedforward_q31, &loop->memory_q31.state);
        tribo_force_loop_feedforward_f32_attach(&loop->state_f32, &loop->memory_f32);
        tribo_force_loop_feedforward_q31_attach(&loop->state_q31, &loop->memory_q31);
    }
    return status;
}

bool sim_loop_feeds_forward(const sim_loop_t *loop)
{
    return loop->params_f32.feedforward != NULL || loop->params_q31.feedforward != NULL;
}

sim_learned_t sim_loop_learned(const sim_loop_t *loop, double force_n)
{
    const double  unit_n  = loop->full_scale_n / 536870912.0;
    const int32_t force   = sim_q31_from_n(force_n, loop->full_scale_n);
    sim_learned_t learned = {.breakaway_n = {0.0}};
    for (uint32_t d = 0; d < 2u; d++)
    {
        if (loop->q31)
        {
            const tribo_feedforward_q31_learned_t at =
                tribo_feedforward_q31_learned(&loop->feedforward_q31,
                                              &loop->params_q31.compensator.friction,
                                              &loop->memory_q31.state,
                                              d,
                                              force);
            learned.breakaway_n[d]    = at.L * unit_n;
            learned.doubt[d]          = at.doubt / 2147483648.0;
            learned.travel_n[d]       = (double)at.travel * unit_n;
            learned.at_bound[d]       = at.at_bound;
            learned.stays_at_bound[d] = at.stays_at_bound;
            continue;
        }
        const tribo_feedforward_f32_learned_t at = tribo_feedforward_f32_learned(&loop->feedforward_f32,
                                                                                 &loop->params_f32.compensator.friction,
                                                                                 &loop->memory_f32.state,
                                                                                 d,
                                                                                 (float)force_n);
        learned.breakaway_n[d]                   = (double)at.L_n;
        learned.doubt[d]                         = (double)at.doubt;
        learned.travel_n[d]                      = (double)at.travel_n;
        learned.at_bound[d]                      = at.at_bound;
        learned.stays_at_bound[d]                = at.stays_at_bound;
    }
    return learned;
}

/// What L(|F|) can hold of what was learned on both sides of 0: their mean, from which a wrong scale of u drops out.
static sim_learned_t learned_at_load(const sim_loop_t *loop, double load_n)
{
    const sim_learned_t above = sim_loop_learned(loop, load_n);
    sim_learned_t       both  = sim_loop_learned(loop, -load_n);
    for (int d = 0; d < 2; d++)
    {
        both.breakaway_n[d] = 0.5 * (both.breakaway_n[d] + above.breakaway_n[d]);
    }
    return both;
}

void sim_loop_learned_breakaway(const sim_loop_t             *loop,
                                const sim_breakaway_config_t *prior,
                                sim_breakaway_config_t       *learned)
{
    const double        far_n = loop->q31 ? 0.999 * loop->full_scale_n : (double)loop->params_f32.input_max_n;
    const sim_learned_t at_0  = learned_at_load(loop, 0.0);
    const sim_learned_t far   = learned_at_load(loop, far_n);
    *learned                  = (sim_breakaway_config_t){
                         .offset_n          = at_0.breakaway_n[0],
                         .slope             = fmax(0.0, (far.breakaway_n[0] - at_0.breakaway_n[0]) / far_n),
                         .negative_offset_n = {true, at_0.breakaway_n[1]},
                         .negative_slope    = {true, fmax(0.0, (far.breakaway_n[1] - at_0.breakaway_n[1]) / far_n)},
                         .table_count       = prior->table_count};
    for (unsigned i = 0; i < prior->table_count; i++)
    {
        const sim_learned_t there = learned_at_load(loop, prior->table[i].force_n);
        learned->table[i]         = (sim_breakaway_point_t){.force_n    = prior->table[i].force_n,
                                                            .positive_n = there.breakaway_n[0],
                                                            .negative_n = there.breakaway_n[1]};
    }
}

static uint32_t float_word(float x)
{
    uint32_t word;
    memcpy(&word, &x, sizeof word);
    return word;
}

static float word_float(uint32_t word)
{
    float x;
    memcpy(&x, &word, sizeof x);
    return x;
}

uint32_t sim_loop_word(const sim_loop_t *loop, double force_n)
{
    if (!loop->q31)
    {
        return float_word((float)force_n);
    }
    return (uint32_t)sim_q31_from_n(force_n, loop->full_scale_n);
}

double sim_loop_force(const sim_loop_t *loop, uint32_t word)
{
    return loop->q31 ? sim_n_from_q31((int32_t)word, loop->full_scale_n) : (double)word_float(word);
}

void sim_loop_step_words(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[TRIBO_SIGNAL_WORDS])
{
    if (loop->q31)
    {
        tribo_force_loop_q31_signals_t signals;
        (void)tribo_force_loop_q31_step(&loop->params_q31, &loop->state_q31, (int32_t)r, (int32_t)y, &signals);
        if (loop->guarded)
        {
            tribo_force_loop_guard_q31_watch(&loop->guard_params_q31,
                                             &loop->guard_q31,
                                             &loop->params_q31,
                                             &loop->state_q31,
                                             (int32_t)r,
                                             (int32_t)y,
                                             &signals);
        }
        tribo_signal_words_q31(&signals, words);
        return;
    }
    tribo_force_loop_f32_signals_t signals;
    (void)tribo_force_loop_f32_step(&loop->params_f32, &loop->state_f32, word_float(r), word_float(y), &signals);
    if (loop->guarded)
    {
        tribo_force_loop_guard_f32_watch(&loop->guard_params_f32,
                                         &loop->guard_f32,
                                         &loop->params_f32,
                                         &loop->state_f32,
                                         word_float(r),
                                         word_float(y),
                                         &signals);
    }
    tribo_signal_words_f32(&signals, words);
}

void sim_loop_signals(const sim_loop_t               *loop,
                      const uint32_t                  words[TRIBO_SIGNAL_WORDS],
                      tribo_force_loop_f32_signals_t *signals)
{
    tribo_friction_f32_signals_t *friction = &signals->compensator.friction;
#define FORCE(place, text, f32, q31) signals->f32 = (float)sim_loop_force(loop, words[TRIBO_SIGNAL_##place]);
    TRIBO_SIGNAL_FORCES(FORCE)
#undef FORCE
    if (loop->q31) // a rise in a tick
    {
        friction->v_n_per_s = (float)(sim_loop_force(loop, words[TRIBO_SIGNAL_RATE]) / loop->sample_time_s);
    }
    signals->controller.limited = (words[TRIBO_SIGNAL_FLAGS] & TRIBO_SIGNAL_LIMITED) != 0u;
    friction->relays            = (uint8_t)(words[TRIBO_SIGNAL_FLAGS] >> 1);
}

double sim_loop_step(sim_loop_t *loop, double r_n, double y_n, tribo_force_loop_f32_signals_t *seen)
{
    uint32_t words[TRIBO_SIGNAL_WORDS];
    sim_loop_step_words(loop, sim_loop_word(loop, r_n), sim_loop_word(loop, y_n), words);
    sim_loop_signals(loop, words, seen);
    return sim_loop_force(loop, words[TRIBO_SIGNAL_U]);
}

tribo_guard_cause_t sim_loop_guard_cause(const sim_loop_t *loop)
{
    return loop->q31 ? loop->guard_q31.cause : loop->guard_f32.cause;
}

const char *sim_loop_guard_text(const sim_loop_t *loop)
{
    static const char *const words[] =
        {[TRIBO_GUARD_NONE] = "none", [TRIBO_GUARD_HUNTING] = "hunting", [TRIBO_GUARD_OVERSHOOT] = "overshoot"};
    return words[sim_loop_guard_cause(loop)];
}

uint32_t sim_loop_limited_ticks(const sim_loop_t *loop)
{
    return loop->q31 ? loop->state_q31.controller.limited_ticks : loop->state_f32.controller.limited_ticks;
}

uint32_t sim_loop_bad_inputs(const sim_loop_t *loop)
{
    return loop->q31 ? loop->state_q31.bad_inputs : loop->state_f32.bad_inputs;
}
