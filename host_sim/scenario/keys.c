// A new key of the simulator needs a row here and a field in its struct (config.h); keys of the loop are in loop/loop_keys.c.
// `tribo-sim list --markdown` then shows its row.

#include "scenario/keys.h"

#include "keys/rows.h"

// clang-format off: one row a key
static const common_key_t command_keys[] = {
    NUMBER("scale_error", AT(sim_drive_error_t, scale),  RANGE("-", -0.9, 9.0, 0.0), "the drive makes 1 + this of the commanded force (torque constant)"),
    NUMBER("bias_N",      AT(sim_drive_error_t, bias_n), RANGE("N", -1e6, 1e6, 0.0), "the drive adds this (offset of its current sensor)"),
    END};

static const common_key_t ripple_keys[] = {
    NUMBER("amplitude_N", AT(sim_drive_error_t, ripple_n),          RANGE("N", 0.0, 1e6, 0.0),       "torque ripple, a sine of position (cogging, gear mesh); 0: none"),
    NUMBER("period_deg",  AT(sim_drive_error_t, ripple_period_deg), RANGE("deg", 1e-3, 360.0, 0.1),  "period of the ripple; the paper's arm moves by 0.26 deg for 1 N"),
    NUMBER("phase",       AT(sim_drive_error_t, ripple_phase),      RANGE("-", 0.0, 1.0, 0.0),       "phase of the ripple at F = 0, in periods"),
    END};

#define MODEL_WORD(name_, text_) #name_,
#define MODEL_KEYS(name_, text_) {.name = #name_, .type = COMMON_KEY_GROUP, AT(sim_plant_keys_t, own[SIM_TRUTH_##name_]), .keys_of_model = &sim_##name_##_truth.keys},
static const char *const models[] = {SIM_TRUTH_MODELS(MODEL_WORD) NULL};

static const common_key_t plant_keys[] = {
    CHOICE("model",                   AT(sim_plant_keys_t, model),                   models, 0.0, "the truth model, see below"),
    NUMBER("step_s",                  AT(sim_plant_keys_t, step_s),                  RANGE("s", 1e-7, 0.1, 1e-4),      "plant step; must divide `sample_time_s` without a remainder"),
    NUMBER("actuator_pole_rad_per_s", AT(sim_plant_keys_t, actuator_pole_rad_per_s), RANGE("rad/s", 1e-3, 1e9, 200.0), "first-order actuator"),
    GROUP("friction",                 AT(sim_plant_keys_t, friction),                common_friction_keys, ""),
    GROUP("arm",                      AT(sim_plant_keys_t, arm),                     common_arm_keys, ""),
    GROUP("command",                  AT(sim_plant_keys_t, drive_error),             command_keys, ""),
    GROUP("ripple",                   AT(sim_plant_keys_t, drive_error),             ripple_keys, ""),
    SIM_TRUTH_MODELS(MODEL_KEYS)
    END};

static const common_key_t sensor_keys[] = {
    NUMBER("pole_rad_per_s", AT(sim_sensor_keys_t, pole_rad_per_s),          RANGE("rad/s", 1e-3, 1e9, 55.0), "first-order sensor filter"),
    NUMBER("noise_N",        AT(sim_sensor_keys_t, sampling.noise_n),        RANGE("N", 0.0, 1e6, 0.0),       "standard deviation of white Gaussian noise, one value a sample"),
    WHOLE("noise_seed",      AT(sim_sensor_keys_t, sampling.noise_seed),     RANGE("-", 0.0, 18446744073709551615.0, 1.0), "same seed, same noise, on every machine"),
    NUMBER("quantisation_N", AT(sim_sensor_keys_t, sampling.quantisation_n), RANGE("N", 0.0, 1e6, 0.0),       "readings are rounded to multiples of this, at least 1e-12; 0: no rounding"),
    NUMBER("delay_s",        AT(sim_sensor_keys_t, sampling.delay_s),        RANGE("s", 0.0, 10.0, 0.0),      "delay, rounded to whole plant steps"),
    END};

static const common_key_t metrics_keys[] = {
    NUMBER("start_s", AT(sim_metrics_config_t, start_s), RANGE("s", 0.0, 86400.0, 0.0), "start of the window for the errors in the summary"),
    OPTIONAL("end_s", AT(sim_metrics_config_t, end_s),   RANGE("s", 0.0, 86400.0, 0.0), "end of the window; the end of the run if missing"),
    END};

static const char *const arithmetics[] = {[SIM_F32] = "f32", [SIM_Q31] = "q31", [SIM_BOTH] = "both", NULL};

const common_key_t sim_keys[] = {
    TEXT("description",      AT(sim_config_t, description),   SIM_DESCRIPTION_MAX, "one line for `tribo-sim list`"),
    CHOICE("arithmetic",     AT(sim_config_t, arithmetic),    arithmetics, SIM_F32, "arithmetic of the loop, as in `--arith`; commands that play one loop take `both` as f32"),
    REQUIRED("duration_s",   AT(sim_config_t, duration_s),    RANGE("s", 1e-3, 86400.0, 0.0), "length of the run; required"),
#define T                                           sim_config_t
#define OF_THE_LOOP(group, symbol, member, ...) PARAMETER(group, symbol, loop.member, __VA_ARGS__)
    TRIBO_SAMPLE_PARAMETERS(OF_THE_LOOP)
#undef T
    GROUP("reference",       AT(sim_config_t, loop.reference),     common_reference_keys, "Reference"),
    GROUP("plant",           AT(sim_config_t, plant),         plant_keys, "Plant: the truth"),
    GROUP("sensor",          AT(sim_config_t, sensor),        sensor_keys, "Sensor"),
    GROUP("controller",      AT(sim_config_t, loop.controller),    common_controller_keys, "Controller"),
    GROUP("compensator",     AT(sim_config_t, loop.compensator),   common_compensator_keys, "Compensator: what the loop assumes"),
    GROUP("limits",          AT(sim_config_t, loop.limits),        common_limits_keys, "Limits"),
    GROUP("metrics",         AT(sim_config_t, metrics),       metrics_keys, "Metrics"),
    END};
// clang-format on
