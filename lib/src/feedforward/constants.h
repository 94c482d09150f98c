// Private constants of the feed-forward; docs/feedforward.md gives the reason of each. Forces are fractions of B, the breakaway
// at the usual force, and times are multiples of tau, the lag from u to F.

#ifndef TRIBO_FEEDFORWARD_CONSTANTS_H
#define TRIBO_FEEDFORWARD_CONSTANTS_H

// Derived defaults of the config.
#define FEEDFORWARD_REVERSAL   (1.0f / 314.0f) // w of B
#define FEEDFORWARD_PRESLIDING (1.0f / 11.0f)  // d_4 of B
#define FEEDFORWARD_JUMP_TIME  2.1f            // T_j of tau
#define FEEDFORWARD_FORGETTING 0.0157f         // Q of 1/B

// Reference.
#define FEEDFORWARD_STOP_RATIO  0.375f  // d_(j-1) of d_j
#define FEEDFORWARD_NOISE_GAIN  4.0f    // k_n
#define FEEDFORWARD_NOISE_TIME  0.25f   // T_n, s
#define FEEDFORWARD_NOISE_TICKS 100.0f  // but at least so many samples
#define FEEDFORWARD_NOISE_FLOOR 0.002f  // n_0 of w
#define FEEDFORWARD_NOISE_PEAK  4.0f    // of a second difference over the mean
#define FEEDFORWARD_STEP_TIME   0.0785f // dr_s is B h over that, s
#define FEEDFORWARD_RATE_TIME   0.8f    // T_r of tau
#define FEEDFORWARD_RATE_TICKS  2.0f    // but at least so many samples
#define FEEDFORWARD_F_MAX       4.0f    // f of G
#define FEEDFORWARD_OFFSET_MAX  4.0f    // |b| of input_max
#define FEEDFORWARD_KEPT        0.25f   // of the learned load: b keeps at most as much at a reversal
#define FEEDFORWARD_V_NOISE     2.0f    // n_y that v has of noise at most
#define FEEDFORWARD_DOUBTFUL    0.5f    // more doubt: the controller alone takes a step
#define FEEDFORWARD_FORCE_MAX_N 1.0e9f  // a sum beyond: the state is corrupt

// Observer and learning.
#define FEEDFORWARD_STAGES           10u             // ticks of a sample
#define FEEDFORWARD_OBSERVER_TIME    0.8f            // T_y of tau
#define FEEDFORWARD_OBSERVER_TICKS   5.0f            // but at least so many samples
#define FEEDFORWARD_TRAVEL_WIDTH     0.2f            // w_y of w
#define FEEDFORWARD_TRAVEL_NOISE     0.4f            // k_y
#define FEEDFORWARD_SLIP_TIME        0.314f          // dy_max is B over that, s
#define FEEDFORWARD_TRAVEL_MAX       (1.0f / 157.0f) // delta_max of B
#define FEEDFORWARD_WEIGHING         (1.0f / 78.5f)  // R of B
#define FEEDFORWARD_DOUBT_TRAVEL     (1.0f / 7.85f)  // D_t of B
#define FEEDFORWARD_WEIGHT_SD        0.4f            // s_V
#define FEEDFORWARD_STOP_SD          0.55f           // s_U
#define FEEDFORWARD_CONSTANT_SD      (1.0f / 5.23f)  // s_0 of B
#define FEEDFORWARD_SLOPE_SD         0.1f            // s_1
#define FEEDFORWARD_LOAD_MAX         2.0f            // of the load's regressors
#define FEEDFORWARD_BOTH_WAYS        0.15f           // M_00 up to which both directions have slid
#define FEEDFORWARD_ONE_WAY          0.4f            // and from which on one alone has
#define FEEDFORWARD_LACK             1.15f           // of what friction lacks: too little costs less than too much
#define FEEDFORWARD_SHRINK           0.2f            // theta
#define FEEDFORWARD_PRESLIDING_MIN   0.15f           // A_0
#define FEEDFORWARD_PRESLIDING_NOISE 2.0f            // and of n_y/D_t beside it
#define FEEDFORWARD_SPARED           (1.0f / 3.0f)   // of k_1 n_y/D_t: V_0 that is not used in noise
#define FEEDFORWARD_SPARED_MAX       0.25f           // of V_0
#define FEEDFORWARD_JUMP_LAG         0.030f          // T_z, s
#define FEEDFORWARD_JUMP_MAX         8.0f            // of a change of z in T_z, over L
#define FEEDFORWARD_SURPRISE         4.0f            // squared standard deviations that a sample may surprise by
#define FEEDFORWARD_MODEL_ERROR      0.01f           // square of what no weight explains
#define FEEDFORWARD_WEIGHT_MIN       0.02f           // V_0; a friction without stiction has next to none at slow slides
#define FEEDFORWARD_WEIGHT_LOW       0.2f            // V_0 that counts as at its bound: the belief is wrong
#define FEEDFORWARD_WEIGHT_MAX       3.0f            // V_0
#define FEEDFORWARD_STOP_MAX         2.0f            // |V_j|
#define FEEDFORWARD_SLOPE_MAX        0.5f            // |c_1|
#define FEEDFORWARD_LEARNED_MIN      0.05f           // of V_0 L: breakaway of a direction that is told

// Another loop's effort.
#define EFFORT_TRAVEL_MIN  16.0f               // X_min, widths
#define EFFORT_WEIGHING    32.0f               // R_x, widths
#define EFFORT_GAIN        0.5f                // g_0
#define EFFORT_SURPRISE    0.25f               // Delta V
#define EFFORT_TICKS_MAX   (UINT32_C(1) << 20) // n_x
#define EFFORT_FASTEST_F32 1000.0f             // x_max, widths a tick
#define EFFORT_FASTEST_Q31 3.9f

// Hold.
#define FEEDFORWARD_HOLD_GAIN     0.94f          // E
#define FEEDFORWARD_QUICK_TIME    0.2f           // T_c, s
#define FEEDFORWARD_QUICK_CHANGES 4u             // until the margin grows
#define FEEDFORWARD_MARGIN_STEP   0.1f           // of what is left of it
#define FEEDFORWARD_MARGIN_TRAVEL (1.0f / 1.57f) // D_m of B
#define FEEDFORWARD_DEADBAND_TIME 0.3f           // T_d, s
#define FEEDFORWARD_DEADBAND_RARE 0.6f           // over the mean second difference of y, where y seldom changes
#define FEEDFORWARD_DEADBAND_ALL  0.07f          // and where it always changes
#define FEEDFORWARD_REST          2.5f           // deadbands that an error may grow to while u rests

// Force from u alone. Each turn leaves the slope of L(F), 0.3 on the paper's rig, of the error.
#define ESTIMATE_TURNS       4u
#define ESTIMATE_FIRST_TURNS 16u

// Monitor.
#define FEEDFORWARD_EFFORT_TIME  0.03f // T_v, s
#define FEEDFORWARD_EFFORT_WIDTH 0.02f // mu, of B
#define FEEDFORWARD_EFFORT_MAX   4.0f  // of t_v over B, and of its ratio
#define FEEDFORWARD_NEED_MIN     0.1f  // of B
#define FEEDFORWARD_EFFORT_PART  0.125f
#define FEEDFORWARD_HARM         0.6f  // xi from which on friction is fed back
#define FEEDFORWARD_PROBATION    0.51f // and with which it is fed forward again

// Feedback where friction fed forward does harm, in reversals.
#define FEEDFORWARD_FEEDBACK_MIN    4u
#define FEEDFORWARD_FEEDBACK_MAX    128u
#define FEEDFORWARD_FEEDBACK_GROWTH 8u // of a length to the next

#endif
