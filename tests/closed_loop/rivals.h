// Other ways to take friction out of a force loop, in double precision, for a fair table beside the feed-forward. None learns to be
// the library's: they are what a reader would try first.

#ifndef TESTS_CLOSED_LOOP_RIVALS_H
#define TESTS_CLOSED_LOOP_RIVALS_H

#include <stdbool.h>

typedef enum
{
    RIVAL_GAIN,          ///< the controller alone, its gain raised
    RIVAL_TANH,          ///< friction by the sign of r's rate, smoothed by tanh
    RIVAL_OBSERVER,      ///< a force disturbance observer
    RIVAL_LADRC,         ///< linear active disturbance rejection in place of the controller
    RIVAL_REINFORCEMENT, ///< a constant term by the sign of the controller's last move
    RIVAL_MIRROR,        ///< at a reversal, what the controller holds beside the load is turned round
    RIVAL_SMALL,         ///< a feed-forward that learns friction as the difference of two means
    RIVALS
} rival_law_t;

extern const char *const rival_names[RIVALS];

/// What they know of the rig: the paper's, at 1 kHz.
typedef struct
{
    double offset_n, slope; ///< of L(F) = offset + slope |F|
    double gain;            ///< times the paper's controller
    double sigma_n;         ///< standard deviation of the sensor's noise
} rival_config_t;

typedef struct
{
    double w1, w2;
} rival_section_t;

typedef struct
{
    rival_law_t     law;
    rival_config_t  config;
    bool            has_run;
    rival_section_t section[4];
    double          r, rate, lin, m1, m2; // the reference's path
    double          u, term;
    double          u1, u2, u3, d;        // what u should have come to, and the disturbance
    double          x1, x2;               // the extended state observer
    double          place, sign, ramp;    // a play, the sign of its last move, its term on the way
    double          held, load, turned;   // mirror: u beyond lin, what of it is load, what has been taken
    double          previous, previous_L; // mirror: at the last reversal
    int             flips;
    // small
    double A, G, c, c0, o, d_small, sigma, sigma0, F0, yf, z, f, lag, still_s;
    double sum_g, sum_L, sum_z, mean_g[2], mean_L[2];
    bool   known[2], is_back, looks;
    long   n;
} rival_t;

void rival_open(rival_t *rival, rival_law_t law, const rival_config_t *config);

/// One tick; returns u.
double rival_step(rival_t *rival, double r, double y);

#endif
