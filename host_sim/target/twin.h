/// The loop on the host as a target sees it: forces and signals as the 32-bit words of the wire, in the target's arithmetic.

#ifndef SIM_TWIN_H
#define SIM_TWIN_H

#include "tribo/quantize_q31.h"

#include <stdbool.h>
#include <stdint.h>

#define SIM_TWIN_WORDS 10 ///< from TRIBO_TOCK_LOOP on: bits, e, controller, feedforward, u, F^, n, L, rate, f^

typedef struct
{
    bool   q31;
    double full_scale_n; ///< of q31
    double sample_time_s;

    tribo_force_loop_f32_params_t params_f32;
    tribo_force_loop_f32_state_t  state_f32;
    tribo_force_loop_q31_params_t params_q31;
    tribo_force_loop_q31_state_t  state_q31;
    tribo_breakaway_point_q31_t   table[TRIBO_BREAKAWAY_POINTS_MAX];
} sim_twin_t;

/// `config` must outlive it. Not to be moved.
tribo_status_t sim_twin_init(sim_twin_t *twin, const tribo_force_loop_f32_config_t *config, bool q31);

uint32_t sim_twin_word(const sim_twin_t *twin, double force_n);
double   sim_twin_force(const sim_twin_t *twin, uint32_t word);

void sim_twin_step(sim_twin_t *twin, uint32_t r, uint32_t y, uint32_t words[SIM_TWIN_WORDS]);

/// Words as what they mean.
void sim_twin_signals(const sim_twin_t               *twin,
                      const uint32_t                  words[SIM_TWIN_WORDS],
                      tribo_force_loop_f32_signals_t *signals);

#endif
