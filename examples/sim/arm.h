/// The simulated arm for the examples in C: a pole for the actuator, an arm that friction holds while the net force is within
/// the breakaway, and a pole for the sensor. Its breakaway is 20 % above the value in the examples' rig. Forces are in N.

#ifndef EXAMPLES_SIM_ARM_H
#define EXAMPLES_SIM_ARM_H

typedef struct
{
    float actuator_n, force_n, reading_n;
} arm_t;

/// The fraction of its remaining distance that each part covers per sample: 1 - e^(-h 200/s), h/(h + 7.5 ms), 1 - e^(-h 55/s).
typedef struct
{
    float actuator, arm, sensor;
} arm_parts_t;

#define ARM_1KHZ  ((arm_parts_t){0.18127f, 0.11765f, 0.05351f})
#define ARM_500HZ ((arm_parts_t){0.32968f, 0.21053f, 0.10417f})

static inline float arm_between(float low, float value, float high)
{
    return value < low ? low : value > high ? high : value;
}

/// Advances the arm by one sample with the command `u_n`.
static inline void arm_step(arm_t *arm, arm_parts_t parts, float u_n)
{
    const float load      = arm->force_n < 0.0f ? -arm->force_n : arm->force_n;
    const float breakaway = 1.2f * (0.007f + 0.3f * load);
    arm->actuator_n += parts.actuator * (u_n - arm->actuator_n);
    const float held = arm_between(arm->actuator_n - breakaway, arm->force_n, arm->actuator_n + breakaway);
    arm->force_n += parts.arm * (held - arm->force_n);
    arm->reading_n += parts.sensor * (arm->force_n - arm->reading_n);
}

/// Returns the benchmark's triangle, 0.4 to 0.6 N, at `tick`; its period is `ticks`.
static inline float arm_reference_n(unsigned tick, unsigned ticks)
{
    const float phase = (float)(tick % ticks) / (float)ticks;
    return 0.4f + 0.4f * (phase < 0.5f ? phase : 1.0f - phase);
}

#endif
