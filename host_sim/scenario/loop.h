/// The library's force loop in f32 or in Q31, behind one face: in newton, or as the 32-bit words that its arithmetic has.

#ifndef SIM_LOOP_H
#define SIM_LOOP_H

#include "scenario/loop_config.h"
#include "tribo/force_loop_feedforward_f32.h"
#include "tribo/force_loop_feedforward_q31.h"
#include "tribo/force_loop_guard_f32.h"
#include "tribo/force_loop_guard_q31.h"
#include "tribo/force_loop_lugre_f32.h"
#include "tribo/force_loop_lugre_q31.h"
#include "tribo/quantize_feedforward_q31.h"
#include "tribo_signal_words.h"

#include <stdbool.h>

/// A force as a drive in Q31 has it: to the nearest bit, one beyond full scale as full scale.
int32_t sim_q31_from_n(double force_n, double full_scale_n);
double  sim_n_from_q31(int32_t x, double full_scale_n);

/// Not to be moved once it is initialised: params point into it.
typedef struct
{
    bool   q31;
    double full_scale_n, sample_time_s;

    tribo_force_loop_f32_params_t  params_f32;
    tribo_force_loop_f32_state_t   state_f32;
    tribo_feedforward_f32_params_t feedforward_f32;
    tribo_feedforward_f32_memory_t memory_f32;
    tribo_lugre_f32_params_t       lugre_f32;
    tribo_force_loop_q31_params_t  params_q31;
    tribo_force_loop_q31_state_t   state_q31;
    tribo_feedforward_q31_params_t feedforward_q31;
    tribo_feedforward_q31_memory_t memory_q31;
    tribo_lugre_q31_params_t       lugre_q31;

    bool                        guarded;
    tribo_guard_f32_params_t    guard_params_f32;
    tribo_guard_f32_state_t     guard_f32;
    tribo_guard_q31_params_t    guard_params_q31;
    tribo_guard_q31_state_t     guard_q31;
    tribo_breakaway_point_q31_t table[TRIBO_BREAKAWAY_POINTS_MAX];
} sim_loop_t;

/// What a feed-forward has learned of breakaway, L+ and L-.
typedef struct
{
    double breakaway_n[2];
    double doubt[2];    ///< 0 to 1
    double travel_n[2]; ///< learned from
    bool   at_bound[2];
    bool   stays_at_bound[2]; ///< latched
} sim_learned_t;

/// A loop at rest, of which nothing is learned. Returns what the library's init function says.
tribo_status_t sim_loop_init(sim_loop_t *loop, bool q31, const sim_loop_config_t *config, double full_scale_n);

/// At the end-point force `force_n`, for a loop that feeds friction forward.
sim_learned_t sim_loop_learned(const sim_loop_t *loop, double force_n);
bool          sim_loop_feeds_forward(const sim_loop_t *loop);

/// Why the guard has faded the compensation, and in a word: none, hunting or overshoot.
tribo_guard_cause_t sim_loop_guard_cause(const sim_loop_t *loop);
const char         *sim_loop_guard_text(const sim_loop_t *loop);

/// What was learned in the form of `prior`, a law or a table. A law is that of 0 N and of the largest credible force.
void sim_loop_learned_breakaway(const sim_loop_t             *loop,
                                const sim_breakaway_config_t *prior,
                                sim_breakaway_config_t       *learned);

/// One tick; returns u in N, exact.
double   sim_loop_step(sim_loop_t *loop, double r_n, double y_n, tribo_force_loop_f32_signals_t *seen);
uint32_t sim_loop_limited_ticks(const sim_loop_t *loop);
uint32_t sim_loop_bad_inputs(const sim_loop_t *loop);

/// The same in words, none of them rounded.
void sim_loop_step_words(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[TRIBO_SIGNAL_WORDS]);

/// A force as a word and back; a step's words in newton, those of Q31 to float's seven digits.
uint32_t sim_loop_word(const sim_loop_t *loop, double force_n);
double   sim_loop_force(const sim_loop_t *loop, uint32_t word);
void     sim_loop_signals(const sim_loop_t               *loop,
                          const uint32_t                  words[TRIBO_SIGNAL_WORDS],
                          tribo_force_loop_f32_signals_t *signals);

#endif
