/// The functions of loop.h that depend on the arithmetic. loop_functions.c is compiled once for each.

#ifndef SIM_LOOP_FUNCTIONS_H
#define SIM_LOOP_FUNCTIONS_H

#include "scenario/loop.h"

typedef struct sim_loop_functions
{
    tribo_status_t (*init)(sim_loop_t *loop, const common_loop_config_t *config);
    sim_learned_t (*learned)(const sim_loop_t *loop, double force_n);
    double (*largest_n)(const sim_loop_t *loop); ///< largest credible force
    uint32_t (*word)(const sim_loop_t *loop, double force_n);
    double (*force)(const sim_loop_t *loop, uint32_t word);
    double (*step)(sim_loop_t *loop, double r_n, double y_n, tribo_force_loop_f32_signals_t *seen);
    void (*step_words)(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[TRIBO_SIGNAL_WORDS]);
    void (*signals)(const sim_loop_t               *loop,
                    const uint32_t                  words[TRIBO_SIGNAL_WORDS],
                    tribo_force_loop_f32_signals_t *signals);
    tribo_guard_cause_t (*guard_cause)(const sim_loop_t *loop);
    uint32_t (*limited_ticks)(const sim_loop_t *loop);
    uint32_t (*bad_inputs)(const sim_loop_t *loop);
} sim_loop_functions_t;

extern const sim_loop_functions_t sim_loop_f32_functions;
extern const sim_loop_functions_t sim_loop_q31_functions;

#endif
