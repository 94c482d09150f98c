/// Parameters of feed-forward and guard from what is known of a rig, by rule, so that none has to be set to begin with.
///
///     B = L at a quarter of input_max, mean of both directions     tau = 1/p_a + b/K     h: sample time, s: noise of y
///
///     reversal_n              B/314          error at a reversal that does not show beside the friction
///     jump_time_s             1.6 tau        as long as the path takes to follow
///     noise_time_s            0.25 s, at least 100 h
///     rate_time_s             0.8 tau, at least 2 h
///     rate_max_n_per_s        B/0.0785 s     no ramp that the arm could follow
///     slide_width_n           B/52           and 3 s: noise does not travel
///     slide_filter_time_s     1.6 tau, at least 10 h
///     slide_rate_max_n_per_s  B/0.314 s
///     slide_run_in_n          5/3 of slide_width_n
///     slide_error_max_n       B/157          and 6 s sqrt(h/(2 slide_filter_time_s)): the filtered error's peaks
///     spread_offset_n         B/15.7         prior; its scale is off by 40 % whatever the rig
///     weight_n                B/785          distance over which a measurement counts
///     forgetting_per_n        0.0157/B       a tenth of the first doubt comes back in 6.4 B of travel
///     caution_travel_n        B/1.57
///     guard: turn_n B/3.14; stray_n B/15.7 and 8 s; quick_time_s 16 tau, at least 20 h; fade_time_s 0.5 s
///
/// The rest is as in the defaults, and is no matter of the rig. The divisors give the defaults for the paper's rig, of which alone
/// they were tuned; all forces times 2 give all of these times 2. Not for the tick.

#ifndef TRIBO_FEEDFORWARD_TUNING_F32_H
#define TRIBO_FEEDFORWARD_TUNING_F32_H

#include "tribo/feedforward_f32.h"
#include "tribo/guard_f32.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What is known of a rig.
typedef struct
{
    float                              actuator_pole_rad_per_s, sensor_pole_rad_per_s;
    const tribo_arm_f32_config_t      *arm;
    const tribo_friction_f32_params_t *friction; ///< the breakaway that is believed
    float                              input_max_n;
    float                              noise_n; ///< standard deviation of y; 0 if it is not known
    float                              sample_time_s;
} tribo_feedforward_f32_rig_t;

/// Nothing is checked here: what cannot be is refused by tribo_feedforward_f32_init and tribo_guard_f32_init.
tribo_feedforward_f32_config_t tribo_feedforward_f32_tuned(const tribo_feedforward_f32_rig_t *rig);
tribo_guard_f32_config_t       tribo_guard_f32_tuned(const tribo_feedforward_f32_rig_t *rig);

#ifdef __cplusplus
}
#endif

#endif
