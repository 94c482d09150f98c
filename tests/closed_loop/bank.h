// A bank of stops with learned weights as the feed-forward of friction, and a jump that leads the actuator, in double precision:
// a study for a successor of feedforward_f32.h, not a product. The controller is the paper's.
//
//     f = g L(rs) (V0 sigma + sum of S(Vj) (phi_j - phi_(j-1)))      phi_0 = sigma, phi_j = s_j/d_j
//
// sigma ramps to the sign of r as in feedforward_f32.h. The stops s_j of widths d_j are Prandtl-Ishlinskii operators of r.
// Their weights V_j are the friction still missing while stop j moves: presliding over distance. The same stops, driven by the
// measured force, teach the weights.

#ifndef TESTS_CLOSED_LOOP_BANK_H
#define TESTS_CLOSED_LOOP_BANK_H

#include <stdbool.h>

#define BANK_STOPS 4
#define BANK_LOADS 4 // weights beside those of the stops: V_0, c_0, c_1, c_2

typedef enum
{
    BANK_OFF,         // the controller alone
    BANK_FEEDFORWARD, // the bank
    BANK_NO_SENSOR,   // the bank without y: nothing is learned, no controller
} bank_method_t;

typedef struct
{
    bank_method_t method;
    double        lead;         // of the jump of f, as a fraction of the actuator's inverse; 0: none
    double        shrinkage;    // theta of S(V) = V^3/(V^2 + theta^2)
    double        still_time_s; // r stands after this time; 0: no hold
    double        width_n;      // w of a reversal
    double        jump_time_s;  // of sigma
    double        factor;       // on f, to see what the monitor makes of too much
    double        period;       // ticks from one sample for learning to the next
    double        stop_n;       // d_1; each is wider than the last by bank_stop_ratio
} bank_options_t;

typedef struct
{
    double w1[2], w2[2]; // controller
    bool   running;
    double r[2], y[2], r_noise, y_noise; // the last two, and mean second differences
    double reached, rate, play;          // rs, its filtered rate, rp
    int    sign;
    double sigma, offset, f, u;
    int    limited;
    double stopped, stop[BANK_STOPS];                          // rn, s_j
    double behind_actuator, behind_sensor;                     // distances of the reference model from rs
    double actuator, sensor, filtered, difference;             // observer: u1, u2, LP(y), LP(u2 - y)
    double measured, travelled, measured_stop[BANK_STOPS + 1]; // z, m and its stops
    double weight[BANK_STOPS + 1], constant, slope, scale;     // V, c_0, c_1, c_2
    double covariance[BANK_LOADS][BANK_LOADS], variance[BANK_STOPS], doubt;
    double travel, sample_k[BANK_LOADS], sample_psi[4], sample_e, sample_weighing, sample_travel;
    int    phase;
    double effort, effort_play, effort_travel, last_need, harm,
        share; // monitor: v filtered, through a play, its travel; xi
    bool   holds;
    double anchor, still_s, held_force, side_s, extra_margin, held_error, held_noise, held_changes;
    int    side, quick;
} bank_t;

/// The options of the design.
bank_options_t bank_default(void);

/// Starts with the first tick.
void bank_reset(bank_t *x);

/// One tick of 1 ms: reference and reading in N give u in N.
double bank_tick(bank_t *x, const bank_options_t *options, double r, double y);

#endif
