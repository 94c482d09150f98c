/// The loop on the host with its forces and signals as the 32-bit words of the wire, in the target's arithmetic.

#ifndef SIM_HOST_LOOP_H
#define SIM_HOST_LOOP_H

#include "scenario/loop.h"
#include "tribo_signal_words.h"

#include <stdint.h>

uint32_t sim_host_word(const sim_loop_t *loop, double force_n);
double   sim_host_force(const sim_loop_t *loop, uint32_t word);

/// sim_loop_step in words, so without any rounding of inputs and outputs.
void sim_host_step(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[TRIBO_SIGNAL_WORDS]);

/// Words converted to signals.
void sim_host_signals(const sim_loop_t               *loop,
                      const uint32_t                  words[TRIBO_SIGNAL_WORDS],
                      tribo_force_loop_f32_signals_t *signals);

#endif
