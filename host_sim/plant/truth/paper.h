/// Which parts the paper's model has: all, or those of a step of the paper's section 3.

#ifndef SIM_PAPER_H
#define SIM_PAPER_H

/// When the gradual curve of Eq. (3) holds instead of f = n.
typedef enum
{
    SIM_PAPER_CURVE_NEVER,
    SIM_PAPER_CURVE_ALWAYS,
    SIM_PAPER_CURVE_RISING, ///< while v > 0, without relays
    SIM_PAPER_CURVE_RELAYS  ///< Eq. (8)
} sim_paper_curve_t;

/// The parameters of sim_paper_truth in addition to those of common_friction_config_t.
typedef struct
{
    int               limited; ///< 1: f is limited to -L to L; 0: it is not
    sim_paper_curve_t curve;
} sim_paper_parameters_t;

#endif
