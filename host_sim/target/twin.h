/// The loop on the host as a target sees it: forces and signals as the 32-bit words of the wire, in the target's arithmetic.

#ifndef SIM_TWIN_H
#define SIM_TWIN_H

#include "scenario/loop.h"

#include <stdint.h>

#define SIM_TWIN_WORDS 10 ///< from TRIBO_TOCK_LOOP on: bits, e, controller, feedforward, u, F^, n, L, rate, f^

uint32_t sim_twin_word(const sim_loop_t *loop, double force_n);
double   sim_twin_force(const sim_loop_t *loop, uint32_t word);

/// sim_loop_step in words: nothing is rounded.
void sim_twin_step(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[SIM_TWIN_WORDS]);

/// Words as what they mean.
void sim_twin_signals(const sim_loop_t               *loop,
                      const uint32_t                  words[SIM_TWIN_WORDS],
                      tribo_force_loop_f32_signals_t *signals);

#endif
