/// The library's force loop in f32 or in Q31, behind one interface: in newtons, or as the 32-bit words of its arithmetic.

#ifndef SIM_LOOP_H
#define SIM_LOOP_H

#include "loop/loop_config.h"
#include "tribo/feedforward_f32.h"
#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_f32.h"
#include "tribo/force_loop_q31.h"
#include "tribo_signal_words.h"

#include <stdbool.h>

/// A loop in one arithmetic.
#define SIM_LOOP_IN(arithmetic)                                                                                        \
    struct                                                                                                             \
    {                                                                                                                  \
        tribo_force_loop_##arithmetic##_params_t  params;                                                              \
        tribo_force_loop_##arithmetic##_state_t   state;                                                               \
        tribo_feedforward_##arithmetic##_params_t feedforward;                                                         \
        tribo_feedforward_##arithmetic##_memory_t memory;                                                              \
        tribo_guard_##arithmetic##_params_t       guard_params;                                                        \
        tribo_breakaway_point_##arithmetic##_t    table[TRIBO_BREAKAWAY_POINTS_MAX]; /* not used in f32 */             \
    }

typedef SIM_LOOP_IN(f32) sim_loop_f32_t;
typedef SIM_LOOP_IN(q31) sim_loop_q31_t;

/// A loop in one of the arithmetics. It must not move once it is initialised, because params point into it.
typedef struct
{
    const struct sim_loop_functions *functions; ///< functions of the arithmetic, loop_functions.h
    bool                             q31, guarded;
    double                           full_scale_n, sample_time_s;
    sim_loop_f32_t                   in_f32;
    sim_loop_q31_t                   in_q31;
} sim_loop_t;

/// The breakaway that a feed-forward has learned, L+ and L-.
typedef struct
{
    double breakaway_n[2];
    double relative_variance[2]; ///< 0 to 1
    double travel_n[2];          ///< travel from which it was learned
    bool   at_bound[2];
    bool   stays_at_bound[2]; ///< latched

    bool     harms; ///< latched: feeding friction forward cost more effort than it saved, so it is fed back
    uint32_t forgotten;
} sim_learned_t;

/// Starts a loop at rest that has learned nothing. Returns the status of the library's init function.
tribo_status_t sim_loop_init(sim_loop_t *loop, bool q31, const common_loop_config_t *config, double full_scale_n);

/// Returns the learned breakaway at the end-point force `force_n`, for a loop that feeds friction forward.
sim_learned_t sim_loop_learned(const sim_loop_t *loop, double force_n);

/// Return why the guard has faded the compensation, as a cause and as a word: none, hunting or overshoot.
tribo_guard_cause_t sim_loop_guard_cause(const sim_loop_t *loop);
const char         *sim_loop_guard_text(const sim_loop_t *loop);

/// Returns the learned breakaway in the form of `prior`, a law or a table, with r from `low_n` to `high_n`. A law goes
/// through the breakaways at both ends.
void sim_loop_learned_breakaway(const sim_loop_t                *loop,
                                const common_breakaway_config_t *prior,
                                double                           low_n,
                                double                           high_n,
                                common_breakaway_config_t       *learned);

/// Runs one tick. Returns u in N, exact.
double   sim_loop_step(sim_loop_t *loop, double r_n, double y_n, tribo_force_loop_f32_signals_t *seen);
uint32_t sim_loop_limited_ticks(const sim_loop_t *loop);
uint32_t sim_loop_bad_inputs(const sim_loop_t *loop);

/// Runs one tick in words, none of which is rounded.
void sim_loop_step_words(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[TRIBO_SIGNAL_WORDS]);

/// Convert a force to a word and back, and a step's words to newtons; those of Q31 have the seven digits of a float then.
uint32_t sim_loop_word(const sim_loop_t *loop, double force_n);
double   sim_loop_force(const sim_loop_t *loop, uint32_t word);
void     sim_loop_signals(const sim_loop_t               *loop,
                          const uint32_t                  words[TRIBO_SIGNAL_WORDS],
                          tribo_force_loop_f32_signals_t *signals);

#endif
