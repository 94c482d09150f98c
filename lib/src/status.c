#include "tribo/status.h"

#include <stddef.h>

const char *tribo_status_text(tribo_status_t status)
{
    static const char *const text[] = {
        [TRIBO_OK]                   = "no error",
        [TRIBO_ERR_NULL]             = "pointer argument: not null",
        [TRIBO_ERR_SAMPLE_TIME]      = "sample_time_s: 1e-6 to 0.1 s",
        [TRIBO_ERR_K_MIN]            = "friction k_min: 1.01 to k_max",
        [TRIBO_ERR_K_MAX]            = "friction k_max: 1.01 to 1000",
        [TRIBO_ERR_M]                = "friction m: 0 to 100",
        [TRIBO_ERR_V0]               = "friction v0_n_per_s: 1e-6 to 1e6 N/s; q31: over m full_scale_n/(6 2^31 h)",
        [TRIBO_ERR_BREAKAWAY_OFFSET] = "friction breakaway offset_n: 1e-6 to 1e6 N; q31: 1e-6 to under 1 full_scale_n",
        [TRIBO_ERR_BREAKAWAY_SLOPE]  = "friction breakaway slope: 0 to 10",
        [TRIBO_ERR_TABLE_LENGTH]     = "friction table_length: 1 to 32 points",
        [TRIBO_ERR_TABLE_FORCE]      = "friction table force_n: 0 to 1e6 N, strictly rising; q31: under full_scale_n",
        [TRIBO_ERR_TABLE_BREAKAWAY] =
            "friction table positive_n and negative_n: 1e-6 to 1e6 N; q31: 1e-6 to under 1 full_scale_n",
        [TRIBO_ERR_SET_LEVEL]   = "friction set_level: over 0 to 1",
        [TRIBO_ERR_RESET_LEVEL] = "friction reset_level: over 0 to 1",
        [TRIBO_ERR_PULSE_WIDTH] = "friction pulse_width_s: 1 to 63 sample times",
        [TRIBO_ERR_GRAVITY]     = "friction gravity_n: -1e6 to 1e6 N; q31: within full_scale_n",
        [TRIBO_ERR_INERTIA]     = "arm inertia: over 0",
        [TRIBO_ERR_DAMPING]     = "arm damping: 0 or more; q31: enough for quantised poles inside the unit circle",
        [TRIBO_ERR_STIFFNESS]   = "arm stiffness: over 0",
        [TRIBO_ERR_ARM_TOO_FAST] =
            "arm: stiffness h^2/inertia 1e-9 to 1e4 and damping h/inertia at most 1e4; q31: coefficients below 4",
        [TRIBO_ERR_SECTION_COUNT]       = "controller section_count: 1 to 4",
        [TRIBO_ERR_SECTION_COEFFICIENT] = "controller section coefficient: -1e6 to 1e6",
        [TRIBO_ERR_SECTION_FEEDTHROUGH] =
            "controller section b0: magnitude 1e-6 to 1e6, so that the cascade is biproper",
        [TRIBO_ERR_SECTION_UNSTABLE]     = "controller section poles: inside the unit circle, or one of them at z = 1",
        [TRIBO_ERR_ANTI_WINDUP]          = "controller cascade: no pole at z = 1, nor a slow one, that a zero hides",
        [TRIBO_ERR_U_MIN]                = "controller u_min_n: -1e6 to 0 N; q31: from -full_scale_n",
        [TRIBO_ERR_U_MAX]                = "controller u_max_n: 0 to 1e6 N and over u_min_n; q31: to full_scale_n",
        [TRIBO_ERR_GAIN]                 = "force loop gain: 0 to 2",
        [TRIBO_ERR_INPUT_MAX]            = "force loop input_max_n: over 0 to 1e6 N; q31: to full_scale_n",
        [TRIBO_ERR_FULL_SCALE]           = "full_scale_n: 1e-3 to 1e6 N",
        [TRIBO_ERR_HEADROOM]             = "controller cascade: worst-case peak below 2^24 full scales at every node",
        [TRIBO_ERR_ACTUATOR_POLE]        = "path actuator_pole_rad_per_s: times sample time 1e-9 to 50",
        [TRIBO_ERR_SENSOR_POLE]          = "path sensor_pole_rad_per_s: times sample time 1e-9 to 50",
        [TRIBO_ERR_REVERSAL_WIDTH]       = "feedforward reversal_n: 1e-9 to 1e6 N",
        [TRIBO_ERR_JUMP_TIME]            = "feedforward jump_time_s: 1e-6 to 1e3 s",
        [TRIBO_ERR_LEAD]                 = "feedforward lead: 0 to 1",
        [TRIBO_ERR_REFERENCE_NOISE]      = "feedforward noise_gain: 0 to 8; noise_time_s: 1e-6 to 1e3 s",
        [TRIBO_ERR_REFERENCE_RATE]       = "feedforward rate_time_s: 1e-6 to 1e3 s; rate_max_n_per_s: 1e-6 to 1e9 N/s",
        [TRIBO_ERR_OFFSET_TIME]          = "feedforward offset_time_s: 1e-6 to 1e3 s",
        [TRIBO_ERR_SLIDE_WIDTH]          = "feedforward slide_width_n: 1e-9 to 1e6 N",
        [TRIBO_ERR_SLIDE_FILTER]         = "feedforward slide_filter_time_s: 1e-6 to 10 s",
        [TRIBO_ERR_SLIDE_RATE]           = "feedforward slide_rate_max_n_per_s: 1e-6 to 1e9 N/s",
        [TRIBO_ERR_SLIDE_RUN_IN]         = "feedforward slide_run_in_n: 1e-9 to 1e6 N",
        [TRIBO_ERR_SLIDE_ERROR]          = "feedforward slide_error_max_n: 1e-9 to 1e6 N",
        [TRIBO_ERR_LEARNING_SPREAD]      = "learning spread_scale: 1e-3 to 2; spread_offset_n: 1e-9 to 1e6 N",
        [TRIBO_ERR_LEARNING_CORRELATION] = "learning correlation and correlation_faded: 0 to 0.99",
        [TRIBO_ERR_LEARNING_TRUST]       = "learning trust: 0 to 1; doubt: 1e-3 to 1",
        [TRIBO_ERR_LEARNING_WEIGHT]      = "learning weight_n: 1e-9 to 1e6 N",
        [TRIBO_ERR_LEARNING_FORGETTING]  = "learning forgetting_per_n: 0 to 1e6 1/N",
        [TRIBO_ERR_LEARNING_BOUNDS]      = "learning scale_min: 1e-3 to 1; scale_max: 1 to 10",
        [TRIBO_ERR_HOLD_GAIN]            = "hold gain: 0 to 0.99",
        [TRIBO_ERR_HOLD_TIME]            = "hold still_time_s and quick_time_s: 1e-6 to 1e3 s",
        [TRIBO_ERR_HOLD_MARGIN]          = "hold margin: 0.1 to 1",
        [TRIBO_ERR_HOLD_CAUTION]         = "hold caution_travel_n: 1e-9 to 1e6 N",
        [TRIBO_ERR_HOLD_DEADBAND]        = "hold deadband_time_s: 1e-6 to 1e3 s",
        [TRIBO_ERR_GUARD_TURN]           = "guard turn_n: 1e-9 to 1e6 N; q31: 1e-6 to under 1 full_scale_n",
        [TRIBO_ERR_GUARD_TIME]  = "guard quick_time_s: 1e-6 to 1e3 s and up to 1e5 samples; fade_time_s: 1e-6 to 1e3 s",
        [TRIBO_ERR_GUARD_STRAY] = "guard stray_n: 1e-9 to 1e6 N; q31: 1e-6 to under 1 full_scale_n",
        [TRIBO_ERR_BRISTLE_STIFFNESS] = "lugre stiffness: over 0, stiffness gamma_d/K 1e-6 to 1e6",
        [TRIBO_ERR_BRISTLE_DAMPING]   = "lugre damping: 0 to 1000 stiffness h; q31: less for stiff bristles",
        [TRIBO_ERR_BRISTLE_VISCOUS]   = "lugre viscous: 0 to 1000 K h/gamma_d",
    };
    // Compared as unsigned: a status outside the list may be of either sign.
    const size_t index = (size_t)status;
    return index < sizeof text / sizeof text[0] ? text[index] : "unknown status";
}
