/// Exact zero-order-hold steps of small linear systems, double precision.

#ifndef SIM_ZOH_H
#define SIM_ZOH_H

/// Returns exp(a step) of a 2 by 2 matrix, row by row.
void sim_zoh_transition(const double a[4], double step_s, double phi[4]);

/// Returns the fraction of the distance to a held input that x' = pole (input - x) covers in one step.
double sim_zoh_first_order(double pole_rad_per_s, double step_s);

#endif
