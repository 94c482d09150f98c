#include "cli/trace.h"

void sim_trace_write_header(FILE *file, bool learns)
{
    (void)fputs("t_s,r_N,y_N,F_N,e_N,controller_N,friction_term_N,u_N,limited," SIM_TRACE_COMPENSATOR
                ",u_a_N,plant_n_N,plant_L_N,plant_v_N_per_s,plant_Q1,plant_Q2,plant_Q,f_N",
                file);
    (void)fputs(
        learns ? ",breakaway_positive_N,breakaway_negative_N,relative_variance_positive,relative_variance_negative,"
                 "learned_positive_N,learned_negative_N\n"
               : "\n",
        file);
}

void sim_trace_write_compensator(FILE *file, const tribo_compensator_f32_signals_t *signals)
{
    const tribo_friction_f32_signals_t *friction = &signals->friction;
    (void)fprintf(file,
                  "%.9g,%.9g,%.9g,%.9g,%d,%d,%d,%.9g",
                  (double)signals->force_n,
                  (double)friction->n_n,
                  (double)friction->L_n,
                  (double)friction->v_n_per_s,
                  (friction->relays & TRIBO_RELAY_Q1) != 0u,
                  (friction->relays & TRIBO_RELAY_Q2) != 0u,
                  (friction->relays & TRIBO_RELAY_Q) != 0u,
                  (double)friction->f_n);
}

void sim_trace_write_row(FILE *file, const sim_row_t *row)
{
    const tribo_force_loop_f32_signals_t *loop  = &row->loop;
    const sim_truth_signals_t            *truth = &row->plant.truth;
    (void)fprintf(file,
                  "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%d,",
                  row->t_s,
                  row->r_n,
                  row->y_n,
                  row->force_n,
                  (double)loop->e_n,
                  (double)loop->controller.v_n,
                  (double)loop->friction_term_n,
                  (double)loop->controller.u_n,
                  loop->controller.limited);
    sim_trace_write_compensator(file, &loop->compensator);
    (void)fprintf(file,
                  ",%.9g,%.9g,%.9g,%.9g,%d,%d,%d,%.9g",
                  row->plant.u_a_n,
                  truth->n_n,
                  truth->L_n,
                  truth->v_n_per_s,
                  truth->q1,
                  truth->q2,
                  truth->q,
                  truth->f_n);
    const sim_learned_t *learned = row->learned;
    if (learned != NULL)
    {
        (void)fprintf(file,
                      ",%.9g,%.9g,%.9g,%.9g,%.9g,%.9g",
                      learned->breakaway_n[0],
                      learned->breakaway_n[1],
                      learned->relative_variance[0],
                      learned->relative_variance[1],
                      learned->travel_n[0],
                      learned->travel_n[1]);
    }
    (void)fputc('\n', file);
}
