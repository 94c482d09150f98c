#include "scenario/loop.h"

#include "scenario/loop_functions.h"

#include <math.h>

tribo_status_t sim_loop_init(sim_loop_t *loop, bool q31, const common_loop_config_t *config, double full_scale_n)
{
    *loop = (sim_loop_t){.functions     = q31 ? &sim_loop_q31_functions : &sim_loop_f32_functions,
                         .q31           = q31,
                         .guarded       = config->parts.guarded,
                         .full_scale_n  = full_scale_n,
                         .sample_time_s = (double)config->parts.config.sample_time_s};
    return loop->functions->init(loop, config);
}

sim_learned_t sim_loop_learned(const sim_loop_t *loop, double force_n)
{
    return loop->functions->learned(loop, force_n);
}

/// Reduces the breakaway learned between `low_n` and `high_n` to a law L(|F|). On one side of 0 the law holds all of it; on
/// both sides it holds their mean, from which a wrong scale of u cancels out.
static sim_learned_t learned_at_load(const sim_loop_t *loop, double load_n, double low_n, double high_n)
{
    const sim_learned_t above = sim_loop_learned(loop, high_n > 0.0 ? load_n : -load_n);
    sim_learned_t       both  = sim_loop_learned(loop, low_n < 0.0 ? -load_n : load_n);
    for (int d = 0; d < 2; d++)
    {
        both.breakaway_n[d] = 0.5 * (both.breakaway_n[d] + above.breakaway_n[d]);
    }
    return both;
}

/// Puts a line through two breakaways, in the form of a law: at 0 N at least a hundredth of the breakaway at the larger force.
static void line_through(double near_n, double near_L_n, double far_n, double far_L_n, double *offset_n, double *slope)
{
    const double least = 0.01 * far_L_n;
    *slope             = fmax(0.0, (far_L_n - near_L_n) / (far_n - near_n));
    *offset_n          = far_L_n - *slope * far_n;
    if (*offset_n < least)
    {
        *offset_n = least;
        *slope    = (far_L_n - least) / far_n;
    }
}

void sim_loop_learned_breakaway(const sim_loop_t                *loop,
                                const common_breakaway_config_t *prior,
                                double                           low_n,
                                double                           high_n,
                                common_breakaway_config_t       *learned)
{
    // Evaluate breakaway where it was learned; far from there a learned load can make it negative.
    const bool   around_0 = low_n < 0.0 && high_n > 0.0;
    const double ends[2]  = {fmin(fabs(low_n), fabs(high_n)), fmax(fabs(low_n), fabs(high_n))};
    const double near_n   = around_0 || ends[1] < 1.1 * ends[0] ? 0.0 : ends[0];
    const double far_n    = ends[1] > 0.0 ? ends[1] : loop->functions->largest_n(loop);

    const sim_learned_t near = learned_at_load(loop, near_n, low_n, high_n);
    const sim_learned_t far  = learned_at_load(loop, far_n, low_n, high_n);
    *learned                 = (common_breakaway_config_t){.negative_offset_n = {.is_given = true},
                                                           .negative_slope    = {.is_given = true},
                                                           .table_count       = prior->table_count};
    line_through(near_n, near.breakaway_n[0], far_n, far.breakaway_n[0], &learned->offset_n, &learned->slope);
    line_through(near_n,
                 near.breakaway_n[1],
                 far_n,
                 far.breakaway_n[1],
                 &learned->negative_offset_n.value,
                 &learned->negative_slope.value);
    for (unsigned i = 0; i < prior->table_count; i++)
    {
        const sim_learned_t there = learned_at_load(loop, prior->table[i].force_n, low_n, high_n);
        learned->table[i]         = (common_breakaway_point_t){.force_n    = prior->table[i].force_n,
                                                               .positive_n = there.breakaway_n[0],
                                                               .negative_n = there.breakaway_n[1]};
    }
}

uint32_t sim_loop_word(const sim_loop_t *loop, double force_n)
{
    return loop->functions->word(loop, force_n);
}

double sim_loop_force(const sim_loop_t *loop, uint32_t word)
{
    return loop->functions->force(loop, word);
}

void sim_loop_step_words(sim_loop_t *loop, uint32_t r, uint32_t y, uint32_t words[TRIBO_SIGNAL_WORDS])
{
    loop->functions->step_words(loop, r, y, words);
}

void sim_loop_signals(const sim_loop_t               *loop,
                      const uint32_t                  words[TRIBO_SIGNAL_WORDS],
                      tribo_force_loop_f32_signals_t *signals)
{
    loop->functions->signals(loop, words, signals);
}

double sim_loop_step(sim_loop_t *loop, double r_n, double y_n, tribo_force_loop_f32_signals_t *seen)
{
    return loop->functions->step(loop, r_n, y_n, seen);
}

tribo_guard_cause_t sim_loop_guard_cause(const sim_loop_t *loop)
{
    return loop->functions->guard_cause(loop);
}

const char *sim_loop_guard_text(const sim_loop_t *loop)
{
    static const char *const words[] =
        {[TRIBO_GUARD_NONE] = "none", [TRIBO_GUARD_HUNTING] = "hunting", [TRIBO_GUARD_OVERSHOOT] = "overshoot"};
    return words[sim_loop_guard_cause(loop)];
}

uint32_t sim_loop_limited_ticks(const sim_loop_t *loop)
{
    return loop->functions->limited_ticks(loop);
}

uint32_t sim_loop_bad_inputs(const sim_loop_t *loop)
{
    return loop->functions->bad_inputs(loop);
}
