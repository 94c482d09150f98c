/// A friction law for the arm of Eq. (2),
///
///     I w' = u + g - F - b w - f,   theta' = w,   F = K theta,   n = u + g - F,
///
/// in two forms of the same equations. The plant's fixed steps (arm.h) take the friction at a step's end from the speed
/// there (`update`), so that a stiff law needs no finer steps and a set-valued one stands without chatter. The reference
/// solver (tests/truth/cvode.h) integrates the published law: friction, rates of its states, and modes that change where a
/// guard reaches 0.
///
/// Friction has the sign of the motion that it opposes. A law's own struct holds its parameters and modes; the solver holds
/// its continuous states z.

#ifndef SIM_LAW_H
#define SIM_LAW_H

#include "plant/breakaway.h"
#include "plant/truth.h"

#include <stdbool.h>
#include <stddef.h>

#define SIM_LAW_STATES_MAX 8u  ///< continuous states z
#define SIM_LAW_GUARDS_MAX 32u ///< events at a time

/// A kink of |w| counts as passed beyond this speed; at rest w is solver noise.
#define SIM_LAW_TURN_DEG_PER_S 1e-7

/// Forces and motion at the contact at an instant.
typedef struct
{
    double          time_s;
    double          u_n;
    double          n_n;
    double          force_n;                         ///< F
    double          speed_deg_per_s;                 ///< w
    sim_breakaway_t breakaway;                       ///< L+ and L- at F
    double          u_rate_n_per_s, u_rate_n_per_s2; ///< first and second derivative of u; 0 in fixed steps
    double          n_rate_n_per_s;                  ///< dn/dt; 0 in fixed steps
} sim_contact_t;

/// A fixed step: its start, with the states there, and its length.
typedef struct
{
    sim_contact_t start;
    const double *z;
    double        length_s;
} sim_law_step_t;

typedef struct sim_law
{
    size_t   size;     ///< size of the law's struct
    size_t   own_size; ///< size of the law's own parameters, which come first in its struct
    unsigned state_count;
    unsigned guard_count;
    bool     turns; ///< the law has no modes and no guards, but a kink where w changes sign
    unsigned steps; ///< fixed steps in one of the plant's; 0 means 1

    /// Completes a start (sim_law_reset), for which the struct is all zeros but for its parameters. Null: nothing is left to do.
    void (*reset)(void *law, const sim_truth_config_t *config, double z[]);

    /// For fixed steps: computes friction and states at the end of a step that ends with `end_speed`. If friction jumps with
    /// the direction of motion, +0.0 and -0.0 are the two sides. `z_end` is not the step's z. Null if the model makes its own
    /// steps.
    double (*update)(const void *law, const sim_law_step_t *step, double end_speed, double z_end[]);

    /// For fixed steps: updates the modes after a step. z and `end` belong to its end, except L, which is still that of the step.
    /// Null if the law has no modes.
    void (*settle)(void *law, const sim_contact_t *end, double z[]);

    /// Returns true if the position stands in this mode, whatever the speed. Null: never.
    bool (*stands)(const void *law);

    /// For continuous time, while the mode is constant.
    double (*friction)(const void *law, const sim_contact_t *now, const double z[]);
    void (*rates)(const void *law, const sim_contact_t *now, const double z[], double dz[]);

    /// For continuous time: each guard is positive until its event happens; `cross` then changes modes, states and speed.
    void (*guards)(const void *law, const sim_contact_t *now, const double z[], double g[]);
    void (*cross)(void *law, sim_contact_t *now, double z[], unsigned guard);
} sim_law_t;

/// Starts a law at rest at F = 0, with the config's own parameters. Leaves states that are 0 then as they are.
void sim_law_reset(const sim_law_t *law, void *friction, const sim_truth_config_t *config, double z[]);

/// Returns L for this sign (-0.0 is negative), as a magnitude.
double sim_law_breakaway(const sim_contact_t *contact, double sign);

/// Returns x limited to -L- to L+.
double sim_law_limit(const sim_contact_t *contact, double x);

#endif
