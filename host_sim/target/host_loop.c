#include "target/host_loop.h"

#include <string.h>

static float word_float(uint32_t word)
{
    float x;
    memcpy(&x, &word, sizeof x);
    return x;
}

uint32_t sim_host_word(const sim_loop_t *loop, double force_n)
{
    if (loop->q31)
    {
        return (uint32_t)sim_q31_from_n(force_n, loop->full_scale_n);
    }
    const float single = (float)force_n;
    uint32_t    word;
    memcpy(&word, &single, sizeof word);
    return word;
}

double sim_host_force(const sim_loop_t *loop, uint32_t word)
{
    return loop->q31 ? sim_n_from_q31((int32_t)word, loop->full_scale_n) : (double)word_float(word);
}

void sim_host_step(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[TRIBO_SIGNAL_WORDS])
{
    if (loop->q31)
    {
        tribo_force_loop_q31_signals_t signals;
        (void)tribo_force_loop_q31_step(&loop->params_q31, &loop->state_q31, (int32_t)r, (int32_t)y, &signals);
        tribo_signal_words_q31(&signals, words);
        return;
    }
    tribo_force_loop_f32_signals_t signals;
    (void)tribo_force_loop_f32_step(&loop->params_f32, &loop->state_f32, word_float(r), word_float(y), &signals);
    tribo_signal_words_f32(&signals, words);
}

void sim_host_signals(const sim_loop_t               *loop,
                      const uint32_t                  words[TRIBO_SIGNAL_WORDS],
                      tribo_force_loop_f32_signals_t *signals)
{
    tribo_friction_f32_signals_t *friction = &signals->compensator.friction;
#define FORCE(place, text, f32, q31) signals->f32 = (float)sim_host_force(loop, words[TRIBO_SIGNAL_##place]);
    TRIBO_SIGNAL_FORCES(FORCE)
#undef FORCE
    if (loop->q31) // a rise in a tick
    {
        friction->v_n_per_s = (float)(sim_host_force(loop, words[TRIBO_SIGNAL_RATE]) / loop->sample_time_s);
    }
    signals->controller.limited = (words[TRIBO_SIGNAL_FLAGS] & TRIBO_SIGNAL_LIMITED) != 0u;
    friction->relays            = (uint8_t)(words[TRIBO_SIGNAL_FLAGS] >> 1);
}
