/// The columns of a run's trace, for trace.csv and the Python package.

#ifndef SIM_COLUMNS_H
#define SIM_COLUMNS_H

#include "scenario/runner.h"

// clang-format off: one row a column
/// NUMBER(name, value) or FLAG(name, value). These columns come from a compensator's `signals`.
#define SIM_COMPENSATOR_COLUMNS(NUMBER, FLAG) \
    NUMBER(F_hat_N,     signals->force_n) \
    NUMBER(n_N,         signals->friction.n_n) \
    NUMBER(L_N,         signals->friction.L_n) \
    NUMBER(v_N_per_s,   signals->friction.v_n_per_s) \
    FLAG(Q1,            (signals->friction.relays & TRIBO_RELAY_Q1) != 0u) \
    FLAG(Q2,            (signals->friction.relays & TRIBO_RELAY_Q2) != 0u) \
    FLAG(Q,             (signals->friction.relays & TRIBO_RELAY_Q) != 0u) \
    NUMBER(f_hat_N,     signals->friction.f_n)

/// These columns come from a `row` and its `signals`.
#define SIM_RUN_COLUMNS(NUMBER, FLAG) \
    NUMBER(t_s,             row->t_s) \
    NUMBER(r_N,             row->r_n) \
    NUMBER(y_N,             row->y_n) \
    NUMBER(F_N,             row->force_n) \
    NUMBER(e_N,             row->loop.e_n) \
    NUMBER(controller_N,    row->loop.controller.v_n) \
    NUMBER(friction_term_N, row->loop.friction_term_n) \
    NUMBER(u_N,             row->loop.controller.u_n) \
    FLAG(limited,           row->loop.controller.limited) \
    SIM_COMPENSATOR_COLUMNS(NUMBER, FLAG) \
    NUMBER(u_a_N,           row->plant.u_a_n) \
    NUMBER(plant_n_N,       row->plant.truth.n_n) \
    NUMBER(plant_L_N,       row->plant.truth.L_n) \
    NUMBER(plant_v_N_per_s, row->plant.truth.v_n_per_s) \
    FLAG(plant_Q1,          row->plant.truth.q1) \
    FLAG(plant_Q2,          row->plant.truth.q2) \
    FLAG(plant_Q,           row->plant.truth.q) \
    NUMBER(f_N,             row->plant.truth.f_n)

/// These columns come from a `row` of a loop that learns.
#define SIM_LEARNED_COLUMNS(NUMBER, FLAG) \
    NUMBER(breakaway_positive_N,       row->learned->breakaway_n[0]) \
    NUMBER(breakaway_negative_N,       row->learned->breakaway_n[1]) \
    NUMBER(relative_variance_positive, row->learned->relative_variance[0]) \
    NUMBER(relative_variance_negative, row->learned->relative_variance[1]) \
    NUMBER(learned_positive_N,         row->learned->travel_n[0]) \
    NUMBER(learned_negative_N,         row->learned->travel_n[1])
// clang-format on

#define SIM_COLUMN_ONE(name, value) +1 // NOLINT(bugprone-macro-parentheses): a summand
enum
{
    SIM_COLUMNS     = SIM_RUN_COLUMNS(SIM_COLUMN_ONE, SIM_COLUMN_ONE),
    SIM_COLUMNS_MAX = SIM_COLUMNS SIM_LEARNED_COLUMNS(SIM_COLUMN_ONE, SIM_COLUMN_ONE)
};

typedef struct
{
    const char *name;
    bool        is_flag; ///< the values are 0 or 1
} sim_column_t;

extern const sim_column_t sim_columns[SIM_COLUMNS_MAX];

/// Returns the number of columns of a trace.
unsigned sim_column_count(bool learns);

/// Writes a row's values, as many as the trace has columns.
unsigned sim_column_values(const sim_row_t *row, double values[SIM_COLUMNS_MAX]);

#endif
