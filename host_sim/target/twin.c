#include "target/twin.h"

#include <math.h>
#include <string.h>

/// Q31's full scale for a config: a power of two, at least twice the largest force.
static double full_scale(const tribo_force_loop_f32_config_t *config)
{
    const double u_max   = fmax((double)config->controller.u_max_n, -(double)config->controller.u_min_n);
    const double largest = fmax((double)config->input_max_n, u_max);
    return exp2(ceil(log2(2.0 * largest)));
}

tribo_status_t sim_twin_init(sim_twin_t *twin, const tribo_force_loop_f32_config_t *config, bool q31)
{
    *twin =
        (sim_twin_t){.q31 = q31, .full_scale_n = full_scale(config), .sample_time_s = (double)config->sample_time_s};
    tribo_force_loop_f32_reset(&twin->state_f32);
    tribo_force_loop_q31_reset(&twin->state_q31);
    return q31 ? tribo_force_loop_q31_init(&twin->params_q31, twin->table, config, (float)twin->full_scale_n, NULL)
               : tribo_force_loop_f32_init(&twin->params_f32, config);
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

uint32_t sim_twin_word(const sim_twin_t *twin, double force_n)
{
    if (!twin->q31)
    {
        return float_word((float)force_n);
    }
    const double x = round(force_n / twin->full_scale_n * 2147483648.0);
    return (uint32_t)(int32_t)fmin(2147483647.0, fmax(-2147483647.0, x));
}

double sim_twin_force(const sim_twin_t *twin, uint32_t word)
{
    return twin->q31 ? (double)(int32_t)word * twin->full_scale_n / 2147483648.0 : (double)word_float(word);
}

static uint32_t bits(bool limited, bool q1, bool q2, bool q)
{
    return (limited ? 1u : 0u) | (q1 ? 2u : 0u) | (q2 ? 4u : 0u) | (q ? 8u : 0u);
}

static void step_f32(sim_twin_t *twin, uint32_t r, uint32_t y, uint32_t words[SIM_TWIN_WORDS])
{
    tribo_force_loop_f32_signals_t seen;
    (void)tribo_force_loop_f32_step(&twin->params_f32, &twin->state_f32, word_float(r), word_float(y), &seen);
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
    words[0]             = bits(seen.controller.limited, friction->q1, friction->q2, friction->q);
    memcpy(words + 1, forces, sizeof forces);
}

static void step_q31(sim_twin_t *twin, uint32_t r, uint32_t y, uint32_t words[SIM_TWIN_WORDS])
{
    tribo_force_loop_q31_signals_t seen;
    (void)tribo_force_loop_q31_step(&twin->params_q31, &twin->state_q31, (int32_t)r, (int32_t)y, &seen);
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
    words[0]               = bits(seen.controller.limited, friction->q1, friction->q2, friction->q);
    memcpy(words + 1, forces, sizeof forces);
}

void sim_twin_step(sim_twin_t *twin, uint32_t r, uint32_t y, uint32_t words[SIM_TWIN_WORDS])
{
    (twin->q31 ? step_q31 : step_f32)(twin, r, y, words);
}

void sim_twin_signals(const sim_twin_t               *twin,
                      const uint32_t                  words[SIM_TWIN_WORDS],
                      tribo_force_loop_f32_signals_t *signals)
{
    float forces[SIM_TWIN_WORDS];
    for (unsigned i = 1; i < SIM_TWIN_WORDS; i++)
    {
        forces[i] = (float)sim_twin_force(twin, words[i]);
    }
    const float rate = twin->q31 ? (float)(sim_twin_force(twin, words[8]) / twin->sample_time_s) : forces[8];
    *signals         = (tribo_force_loop_f32_signals_t){
                .e_n           = forces[1],
                .feedforward_n = forces[3],
                .controller    = {.v_n = forces[2], .u_n = forces[4], .limited = (words[0] & 1u) != 0u},
                .compensator   = {.force_n  = forces[5],
                                  .friction = {.n_n       = forces[6],
                                               .L_n       = forces[7],
                                               .v_n_per_s = rate,
                                               .f_n       = forces[9],
                                               .q1        = (words[0] & 2u) != 0u,
                                               .q2        = (words[0] & 4u) != 0u,
                                               .q         = (words[0] & 8u) != 0u}}};
}
