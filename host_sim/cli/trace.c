#include "cli/trace.h"

#define DIGITS 9

typedef struct
{
    char  *next;
    size_t room;
} line_t;

static void put(line_t *line, double value)
{
    const int length = snprintf(line->next, line->room, "%.*g,", DIGITS, value);
    line->next += length;
    line->room -= (size_t)length;
}

static void put_bit(line_t *line, bool value)
{
    *line->next++ = value ? '1' : '0';
    *line->next++ = ',';
    line->room -= 2;
}

void sim_trace_write_header(FILE *file)
{
    (void)fputs("t_s,r_N,y_N,F_N,e_N,controller_N,friction_term_N,u_N,limited,"
                "F_hat_N,n_N,L_N,v_N_per_s,Q1,Q2,Q,f_hat_N,"
                "u_a_N,plant_n_N,plant_L_N,plant_v_N_per_s,plant_Q1,plant_Q2,plant_Q,f_N\n",
                file);
}

void sim_trace_write_row(FILE *file, const sim_row_t *row)
{
    const tribo_force_loop_f32_signals_t *loop     = &row->loop;
    const tribo_friction_f32_signals_t   *friction = &row->loop.compensator.friction;
    const sim_truth_signals_t            *truth    = &row->plant.truth;

    char text[1024]; // 25 values of at most 16 characters and a comma
    text[0]     = '\0';
    line_t line = {.next = text, .room = sizeof text};
    put(&line, row->t_s);
    put(&line, row->r_n);
    put(&line, row->y_n);
    put(&line, row->force_n);
    put(&line, (double)loop->e_n);
    put(&line, (double)loop->controller.v_n);
    put(&line, (double)loop->feedforward_n);
    put(&line, (double)loop->controller.u_n);
    put_bit(&line, loop->controller.limited);
    put(&line, (double)loop->compensator.force_n);
    put(&line, (double)friction->n_n);
    put(&line, (double)friction->L_n);
    put(&line, (double)friction->v_n_per_s);
    put_bit(&line, (friction->relays & TRIBO_RELAY_Q1) != 0u);
    put_bit(&line, (friction->relays & TRIBO_RELAY_Q2) != 0u);
    put_bit(&line, (friction->relays & TRIBO_RELAY_Q) != 0u);
    put(&line, (double)friction->f_n);
    put(&line, row->plant.u_a_n);
    put(&line, truth->n_n);
    put(&line, truth->L_n);
    put(&line, truth->v_n_per_s);
    put_bit(&line, truth->q1);
    put_bit(&line, truth->q2);
    put_bit(&line, truth->q);
    put(&line, truth->f_n);
    line.next[-1] = '\n';
    (void)fwrite(text, 1, (size_t)(line.next - text), file);
}
