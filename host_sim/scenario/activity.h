/// Measures the activity of a loop: chatter and total variation of its command u, and switches of Q, Eq. (8).
///
/// The plant filters a command that reverses at every tick, so RMS and peak of the error do not show it. A motor and its gear
/// suffer.

#ifndef SIM_ACTIVITY_H
#define SIM_ACTIVITY_H

#include <stdbool.h>
#include <stdint.h>

/// Smallest move of u that counts, as a fraction of full scale. u turns where two such moves in succession have opposite signs.
#define SIM_ACTIVITY_MOVE 1e-5

/// Begins with all zeros except `move_n`.
typedef struct
{
    double move_n; ///< SIM_ACTIVITY_MOVE times full scale

    uint64_t ticks;
    uint64_t chatter_ticks; ///< ticks in which u turned, as it did in the tick before
    uint64_t q_switches;    ///< switches of Q, on and off
    double   u_variation_n; ///< sum of |u(k) - u(k - 1)|
    double   r_variation_n; ///< sum of |r(k) - r(k - 1)|

    double r_n, u_n, last_move_n; ///< values of the last tick
    bool   q, turned;
    bool   continues; ///< there was a last tick
} sim_activity_t;

/// Adds a tick.
void sim_activity_add(sim_activity_t *activity, double r_n, double u_n, bool q);

/// Records that the next tick does not follow the last one.
void sim_activity_break(sim_activity_t *activity);

/// Returns the total variation of u divided by that of r; NaN if r did not move.
double sim_activity_variation_ratio(const sim_activity_t *activity);

#endif
