#include "scenario/loop.h"

#include <math.h>
#include <stddef.h>

int32_t sim_q31_from_n(double force_n, double full_scale_n)
{
    return (int32_t)fmax(-2147483647.0, fmin(2147483647.0, round(force_n / full_scale_n * 2147483648.0)));
}

double sim_n_from_q31(int32_t x, double full_scale_n)
{
    return x / 2147483648.0 * full_scale_n;
}

tribo_compensator_f32_signals_t sim_signals_from_q31(const tribo_compensator_q31_signals_t *signals,
                                                     double                                 full_scale_n,
                                                     double                                 sample_time_s)
{
    const tribo_friction_q31_signals_t *friction = &signals->friction;
    return (tribo_compensator_f32_signals_t){
        .force_n  = (float)sim_n_from_q31(signals->force, full_scale_n),
        .friction = {.n_n       = (float)sim_n_from_q31(friction->n, full_scale_n),
                     .L_n       = (float)sim_n_from_q31(friction->L, full_scale_n),
                     .v_n_per_s = (float)(sim_n_from_q31(friction->rise, full_scale_n) / sample_time_s),
                     .f_n       = (float)sim_n_from_q31(friction->f, full_scale_n),
                     .relays    = friction->relays}};
}

tribo_status_t sim_loop_init(sim_loop_t                          *loop,
                             bool                                 q31,
                             const tribo_force_loop_f32_config_t *config,
                             double                               full_scale_n)
{
    *loop = (sim_loop_t){.q31 = q31, .full_scale_n = full_scale_n, .sample_time_s = (double)config->sample_time_s};
    tribo_force_loop_f32_reset(&loop->state_f32);
    tribo_force_loop_q31_reset(&loop->state_q31);
    return q31 ? tribo_force_loop_q31_init(&loop->params_q31, loop->table, config, (float)full_scale_n, NULL)
               : tribo_force_loop_f32_init(&loop->params_f32, config);
}

static double step_q31(sim_loop_t *loop, double r_n, double y_n, tribo_force_loop_f32_signals_t *seen)
{
    const double                   full_scale_n = loop->full_scale_n;
    const int32_t                  r            = sim_q31_from_n(r_n, full_scale_n);
    const int32_t                  y            = sim_q31_from_n(y_n, full_scale_n);
    tribo_force_loop_q31_signals_t signals;
    const int32_t                  u = tribo_force_loop_q31_step(&loop->params_q31, &loop->state_q31, r, y, &signals);
    *seen                            = (tribo_force_loop_f32_signals_t){
                                   .e_n           = (float)sim_n_from_q31(signals.e, full_scale_n),
                                   .feedforward_n = (float)sim_n_from_q31(signals.feedforward, full_scale_n),
                                   .controller    = {.v_n     = (float)sim_n_from_q31(signals.controller.v, full_scale_n),
                                                     .u_n     = (float)sim_n_from_q31(signals.controller.u, full_scale_n),
                                                     .limited = signals.controller.limited},
                                   .compensator   = sim_signals_from_q31(&signals.compensator, full_scale_n, loop->sample_time_s)};
    return sim_n_from_q31(u, full_scale_n);
}

double sim_loop_step(sim_loop_t *loop, double r_n, double y_n, tribo_force_loop_f32_signals_t *seen)
{
    return loop->q31
               ? step_q31(loop, r_n, y_n, seen)
               : (double)tribo_force_loop_f32_step(&loop->params_f32, &loop->state_f32, (float)r_n, (float)y_n, seen);
}

uint32_t sim_loop_limited_ticks(const sim_loop_t *loop)
{
    return loop->q31 ? loop->state_q31.controller.limited_ticks : loop->state_f32.controller.limited_ticks;
}

uint32_t sim_loop_bad_inputs(const sim_loop_t *loop)
{
    return loop->q31 ? loop->state_q31.bad_inputs : loop->state_f32.bad_inputs;
}
