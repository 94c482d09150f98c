/// Controls the current of a winding behind a bridge, of a brushed or a voice-coil motor:
///
///     v = R i + L di/dt + e          e: back EMF
///
/// The zero of a PI controller cancels the winding's pole; w is the bandwidth of the closed loop in rad/s:
///
///     C(s) = w (L s + R) / s         C(s) / (L s + R) = w / s, so i follows its reference as w / (s + w)
///
/// With a sample time T, the winding's pole is exp(-R T / L) and the zero is 1 - Ki / Kp:
///
///     v[n]   = Kp (r - i) + x[n]     Ki = w R T
///     x[n+1] = x[n] + Ki (r' - i)    Kp = Ki / (1 - exp(-R T / L))
///
/// The reference r is limited to the current limit, and v to the voltage that the bridge can give. r' is the reference that
/// leads to the limited v, so that x follows R i instead of winding up while v is at its limit. A voltage acts half a sample
/// to one and a half samples after its current was measured. With that delay, w T up to CURRENT_PHASE_MAX keeps 50 degrees
/// of phase margin. Single precision, no loops. Source: Harnefors and Nee, "Model-based current control of AC machines using
/// the internal model control method", IEEE Trans. Ind. Appl. 34 (1998).

#ifndef BRIDGE_CURRENT_H
#define BRIDGE_CURRENT_H

#include <stdbool.h>

#define CURRENT_PHASE_MAX 0.66f ///< largest w T
#define CURRENT_POLE_MAX  2.0f  ///< largest R T / L; a faster winding has hardly any inductance

typedef struct
{
    float resistance_ohm, inductance_h, bandwidth_hz, sample_time_s;
    float limit_a; ///< limit of the reference
} current_config_t;

typedef struct
{
    float kp_v_per_a, kp_a_per_v, ki_v_per_a, limit_a;
} current_params_t;

typedef struct
{
    float integral_v;
    bool  limited; ///< v of the last step was limited
} current_state_t;

/// Returns the largest bandwidth at a sample time.
float current_bandwidth_max_hz(float sample_time_s);

/// Computes `params`. Returns false and leaves them unchanged unless all values are positive and finite, the bandwidth is within
/// current_bandwidth_max_hz and R T / L within CURRENT_POLE_MAX.
bool current_init(current_params_t *params, const current_config_t *config);

void current_reset(current_state_t *state);

/// Returns x limited to -limit to limit; 0 for a NaN.
static inline float current_limited(float x, float limit)
{
    return x > limit ? limit : x < -limit ? -limit : x == x ? x : 0.0f;
}

/// Runs one sample and returns the voltage for the motor, within -most_v to most_v.
static inline float current_step(const current_params_t *params,
                                 current_state_t        *state,
                                 float                   reference_a,
                                 float                   measured_a,
                                 float                   most_v)
{
    const float error_a  = current_limited(reference_a, params->limit_a) - measured_a;
    const float wanted_v = params->kp_v_per_a * error_a + state->integral_v;
    const float v        = current_limited(wanted_v, most_v);
    const float given_a  = error_a + (v - wanted_v) * params->kp_a_per_v; // r' - i
    state->integral_v += params->ki_v_per_a * given_a;
    state->limited = wanted_v > most_v || wanted_v < -most_v;
    return v;
}

#endif
