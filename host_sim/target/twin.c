#include "target/twin.h"

#include <string.h>

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

uint32_t sim_twin_word(const sim_loop_t *loop, double force_n)
{
    if (!loop->q31)
    {
        return float_word((float)force_n);
    }
    return (uint32_t)sim_q31_from_n(force_n, loop->full_scale_n);
}

double sim_twin_force(const sim_loop_t *loop, uint32_t word)
{
    return loop->q31 ? sim_n_from_q31((int32_t)word, loop->full_scale_n) : (double)word_float(word);
}

static void step_f32(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[SIM_TWIN_WORDS])
{
    tribo_force_loop_f32_signals_t seen;
    (void)tribo_force_loop_f32_step(&loop->params_f32, &loop->state_f32, word_float(r), word_float(y), &seen);
    const tribo_friction_f32_signals_t *friction = &seen.compensator.friction;

    const float forces[] = {seen.e_n,
                            seen.controller.v_n,
                            seen.feedforward_n,
                            seen.controller.u_n,
                            seen.compensator.force_n,
                            friction->n_n,
                            friction->L_n,
                            friction->v_n_per_s,
                            friction->f_n};
    words[0]             = (uint32_t)seen.controller.limited | (uint32_t)friction->relays << 1;
    memcpy(words + 1, forces, sizeof forces);
}

static void step_q31(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[SIM_TWIN_WORDS])
{
    tribo_force_loop_q31_signals_t seen;
    (void)tribo_force_loop_q31_step(&loop->params_q31, &loop->state_q31, (int32_t)r, (int32_t)y, &seen);
    const tribo_friction_q31_signals_t *friction = &seen.compensator.friction;

    const int32_t forces[] = {seen.e,
                              seen.controller.v,
                              seen.feedforward,
                              seen.controller.u,
                              seen.compensator.force,
                              friction->n,
                              friction->L,
                              friction->rise,
                              friction->f};
    words[0]               = (uint32_t)seen.controller.limited | (uint32_t)friction->relays << 1;
    memcpy(words + 1, forces, sizeof forces);
}

void sim_twin_step(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[SIM_TWIN_WORDS])
{
    (loop->q31 ? step_q31 : step_f32)(loop, r, y, words);
}

void sim_twin_signals(const sim_loop_t               *loop,
                      const uint32_t                  words[SIM_TWIN_WORDS],
                      tribo_force_loop_f32_signals_t *signals)
{
    float forces[SIM_TWIN_WORDS];
    for (unsigned i = 1; i < SIM_TWIN_WORDS; i++)
    {
        forces[i] = (float)sim_twin_force(loop, words[i]);
    }
    const float rate = loop->q31 ? (float)(sim_twin_force(loop, words[8]) / loop->sample_time_s) : forces[8];
    *signals         = (tribo_force_loop_f32_signals_t){
                .e_n           = forces[1],
                .feedforward_n = forces[3],
                .controller    = {.v_n = forces[2], .u_n = forces[4], .limited = (words[0] & 1u) != 0u},
                .compensator   = {.force_n  = forces[5],
                                  .friction = {.n_n       = forces[6],
                                               .L_n       = forces[7],
                                               .v_n_per_s = rate,
                                               .f_n       = forces[9],
                                               .relays    = (uint8_t)(words[0] >> 1)}}};
}
