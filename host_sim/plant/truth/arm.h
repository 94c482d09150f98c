/// Steps the arm of Eq. (2) with a friction law: the arm by its exact zero-order-hold matrices, with the friction held at its
/// value for the speed at the step's end. Each step solves one scalar equation,
///
///     w1 + c f(w1) = w0,    w0: end speed without friction,  c: loss of end speed per newton of friction,
///
/// which has one root, because f does not fall with speed by more than 1/c (Moreau's time stepping; Acary & Brogliato,
/// "Numerical Methods for Nonsmooth Dynamical Systems", 2008). With friction that jumps at rest the arm stands exactly, and
/// stiff laws need no steps of a microsecond. The method is of first order in the step, see tests/bench/truth_bench.c.

#ifndef SIM_ARM_H
#define SIM_ARM_H

#include "plant/truth/law.h"

/// Creates an arm at rest with this law; null if there is no memory.
void *sim_arm_create(const sim_law_t *law, const sim_truth_config_t *config, double step_s);

/// The functions step, destroy and parts of sim_truth_ops_t.
double sim_arm_step(void *model, double u_n, sim_truth_signals_t *signals);
void   sim_arm_destroy(void *model);
void   sim_arm_parts(void *model, sim_truth_part_t parts[SIM_TRUTH_PARTS]);

/// Defines sim_NAME_truth, an arm with this law. Pass its own keys, or NULL.
#define SIM_ARM_TRUTH(name_, law_, keys_)                                                                              \
    static void *create_##name_(const sim_truth_config_t *config, double step_s)                                       \
    {                                                                                                                  \
        return sim_arm_create(&(law_), config, step_s);                                                                \
    }                                                                                                                  \
    const sim_truth_ops_t sim_##name_##_truth = {.name    = #name_,                                                    \
                                                 .create  = create_##name_,                                            \
                                                 .step    = sim_arm_step,                                              \
                                                 .destroy = sim_arm_destroy,                                           \
                                                 .parts   = sim_arm_parts,                                             \
                                                 .keys    = (keys_),                                                   \
                                                 .law     = &(law_)}

/// The exact step of the arm with d = u + g - f - F held at its start: F += phi_d d + phi_g G, G = gamma_d d + gamma_g G,
/// with G the speed in N/s.
typedef struct
{
    double phi_d, phi_g, gamma_d, gamma_g;
} sim_arm_matrices_t;

sim_arm_matrices_t sim_arm_matrices(const common_arm_config_t *arm, double step_s);

#endif
