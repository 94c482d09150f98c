// A new key is a row here and a field of the struct that the row is about (config.h, plant/truth_config.h); what uses it reads the
// field. `cmake --build --preset host-release --target scenario-readme` then writes its row in scenarios/README.md.

#include "scenario/keys.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// --- the table -----------------------------------------------------------------------------------------------------

// clang-format off: one row a key
#define AT(type_, member) .offset = offsetof(type_, member)
#define RANGE(unit_, min_, max_, standard_) .unit = (unit_), .min = (min_), .max = (max_), .standard = (standard_)
#define STATUS(name_) (UINT64_C(1) << TRIBO_ERR_##name_)

#define NUMBER(name_, at, range, text_)           {.name = (name_), .type = SIM_KEY_NUMBER, at, range, .text = (text_)}
#define CHECKED(name_, at, range, statuses_, text_) {.name = (name_), .type = SIM_KEY_NUMBER, at, range, .statuses = (statuses_), .text = (text_)}
#define REQUIRED(name_, at, range, text_)         {.name = (name_), .type = SIM_KEY_NUMBER, .is_required = true, at, range, .text = (text_)}
#define OPTIONAL(name_, at, range, text_)         {.name = (name_), .type = SIM_KEY_OPTIONAL, at, range, .text = (text_)}
#define WHOLE(name_, at, range, text_)            {.name = (name_), .type = SIM_KEY_WHOLE, at, range, .text = (text_)}
#define CHOICE(name_, at, words_, standard_, text_) {.name = (name_), .type = SIM_KEY_CHOICE, at, .unit = "-", .words = (words_), .standard = (standard_), .text = (text_)}
#define TEXT(name_, at, max_, text_)              {.name = (name_), .type = SIM_KEY_TEXT, at, .unit = "-", .max = (max_), .text = (text_)}
#define GROUP(name_, at, keys_, statuses_, text_) {.name = (name_), .type = SIM_KEY_GROUP, at, .keys = (keys_), .statuses = (statuses_), .text = (text_)}
#define LIST(name_, type_, member, counter, max_, keys_, statuses_, text_) \
    {.name = (name_), .type = SIM_KEY_LIST, AT(type_, member), .unit = "-", .min = 1, .max = (max_), .keys = (keys_), \
     .size = sizeof((type_ *)0)->member[0], .count_offset = offsetof(type_, counter), .statuses = (statuses_), .text = (text_)}
#define END {.name = NULL}

static const sim_key_t point_keys[] = {
    REQUIRED("force_N",    AT(sim_breakaway_point_t, force_n),    RANGE("N", 0.0, 1e6, 0.0),  "a point's applied force |F|, strictly rising from point to point"),
    REQUIRED("positive_N", AT(sim_breakaway_point_t, positive_n), RANGE("N", 1e-6, 1e6, 0.0), "L in the positive direction there"),
    REQUIRED("negative_N", AT(sim_breakaway_point_t, negative_n), RANGE("N", 1e-6, 1e6, 0.0), "L in the negative direction there"),
    END};

static const sim_key_t breakaway_keys[] = {
    CHECKED("offset_N",           AT(sim_breakaway_config_t, offset_n),          RANGE("N", 1e-6, 1e6, 0.007), STATUS(BREAKAWAY_OFFSET), "L(F) = offset + slope |F|, both directions"),
    CHECKED("slope",              AT(sim_breakaway_config_t, slope),             RANGE("-", 0.0, 10.0, 0.3),   STATUS(BREAKAWAY_SLOPE),  "likewise"),
    OPTIONAL("negative_offset_N", AT(sim_breakaway_config_t, negative_offset_n), RANGE("N", 1e-6, 1e6, 0.0),   "the negative direction's own offset; as the positive one if left out"),
    OPTIONAL("negative_slope",    AT(sim_breakaway_config_t, negative_slope),    RANGE("-", 0.0, 10.0, 0.0),   "the negative direction's own slope; likewise"),
    LIST("table", sim_breakaway_config_t, table, table_count, SIM_BREAKAWAY_POINTS_MAX, point_keys, STATUS(TABLE_LENGTH) | STATUS(TABLE_FORCE) | STATUS(TABLE_BREAKAWAY),
         "1 to 32 points in place of offset and slope: linear between them, clamped at both ends"),
    END};

static const sim_key_t friction_keys[] = {
    CHECKED("k_min",         AT(sim_friction_config_t, k_min),         RANGE("-", 1.01, 1000.0, 6.0),  STATUS(K_MIN),       "k of Eq. (5) at high net-force rates, where hysteresis is widest; at most `k_max`"),
    CHECKED("k_max",         AT(sim_friction_config_t, k_max),         RANGE("-", 1.01, 1000.0, 20.0), STATUS(K_MAX),       "k of Eq. (5) at low net-force rates"),
    CHECKED("m",             AT(sim_friction_config_t, m),             RANGE("-", 0.0, 100.0, 3.0),    STATUS(M),           "steepness of k(v)"),
    CHECKED("v0_N_per_s",    AT(sim_friction_config_t, v0_n_per_s),    RANGE("N/s", 1e-6, 1e6, 0.007), STATUS(V0),          "centre of k(v)"),
    GROUP("breakaway",       AT(sim_friction_config_t, breakaway),     breakaway_keys, 0,              ""),
    CHECKED("set_level",     AT(sim_friction_config_t, set_level),     RANGE("-", 1e-6, 1.0, 0.75),    STATUS(SET_LEVEL),   "c1 of Eq. (9): where the relays set, as a fraction of L"),
    CHECKED("reset_level",   AT(sim_friction_config_t, reset_level),   RANGE("-", 1e-6, 1.0, 0.8),     STATUS(RESET_LEVEL), "c2 of Eq. (9): where the relays reset, as a fraction of L"),
    CHECKED("pulse_width_s", AT(sim_friction_config_t, pulse_width_s), RANGE("s", 1e-6, 10.0, 0.003),  STATUS(PULSE_WIDTH), "pulse of the edge detectors; in the compensator 1 to 63 samples"),
    CHECKED("gravity_N",     AT(sim_friction_config_t, gravity_n),     RANGE("N", -1e6, 1e6, 0.0),     STATUS(GRAVITY),     "gravity on the arm, as end-point force"),
    END};

static const sim_key_t arm_keys[] = {
    CHECKED("inertia_N_s2_per_deg", AT(sim_arm_config_t, inertia_n_s2_per_deg), RANGE("N s²/deg", 1e-12, 1e12, 1.2e-4), STATUS(INERTIA),   "I of Eq. (2)"),
    CHECKED("damping_N_s_per_deg",  AT(sim_arm_config_t, damping_n_s_per_deg),  RANGE("N s/deg", 0.0, 1e12, 0.0288),    STATUS(DAMPING),   "b of Eq. (2)"),
    CHECKED("stiffness_N_per_deg",  AT(sim_arm_config_t, stiffness_n_per_deg),  RANGE("N/deg", 1e-12, 1e12, 3.84),      STATUS(STIFFNESS), "K of Eq. (2)"),
    END};

static const char *const reference_kinds[] = {
    [SIM_REFERENCE_TRIANGLE] = "triangle", [SIM_REFERENCE_SINE] = "sine", [SIM_REFERENCE_STEP] = "step", [SIM_REFERENCE_RAMP] = "ramp",
    [SIM_REFERENCE_SAWTOOTH] = "sawtooth", [SIM_REFERENCE_CHIRP] = "chirp", [SIM_REFERENCE_CSV] = "csv", NULL};

static const sim_key_t reference_keys[] = {
    {.name = "kind", .type = SIM_KEY_CHOICE, .is_required = true, AT(sim_reference_config_t, kind), .unit = "-", .words = reference_kinds,
     .text = "the reference's shape, see above; required"},
    NUMBER("low_N",    AT(sim_reference_config_t, low_n),    RANGE("N", -1e6, 1e6, 0.4),      "lower end"),
    NUMBER("high_N",   AT(sim_reference_config_t, high_n),   RANGE("N", -1e6, 1e6, 0.6),      "upper end"),
    NUMBER("start_s",  AT(sim_reference_config_t, start_s),  RANGE("s", 0.0, 86400.0, 0.0),   "when it begins to move"),
    NUMBER("period_s", AT(sim_reference_config_t, period_s), RANGE("s", 1e-3, 86400.0, 20.0), "triangle, sine, sawtooth"),
    NUMBER("ramp_s",   AT(sim_reference_config_t, ramp_s),   RANGE("s", 1e-3, 86400.0, 10.0), "ramp: how long from low to high"),
    NUMBER("from_Hz",  AT(sim_reference_config_t, from_hz),  RANGE("Hz", 0.0, 1e6, 0.05),     "chirp: first frequency"),
    NUMBER("to_Hz",    AT(sim_reference_config_t, to_hz),    RANGE("Hz", 0.0, 1e6, 1.0),      "chirp: last frequency"),
    NUMBER("sweep_s",  AT(sim_reference_config_t, sweep_s),  RANGE("s", 1e-3, 86400.0, 60.0), "chirp: how long from the one to the other"),
    TEXT("file",       AT(sim_reference_config_t, file),     SIM_PATH_MAX,
         "csv: columns `t_s` (rising) and `r_N`; from the scenario file's folder, or from the current one if given by `--set`"),
    END};

static const sim_key_t command_keys[] = {
    NUMBER("scale_error", AT(sim_drive_error_t, scale),  RANGE("-", -0.9, 9.0, 0.0), "the drive makes 1 + this of the commanded force (torque constant)"),
    NUMBER("bias_N",      AT(sim_drive_error_t, bias_n), RANGE("N", -1e6, 1e6, 0.0), "and adds this (offset of its current sensor)"),
    END};

static const sim_key_t ripple_keys[] = {
    NUMBER("amplitude_N", AT(sim_drive_error_t, ripple_n),          RANGE("N", 0.0, 1e6, 0.0),       "torque ripple, a sine of position (cogging, gear mesh); 0: none"),
    NUMBER("period_deg",  AT(sim_drive_error_t, ripple_period_deg), RANGE("deg", 1e-3, 360.0, 0.1),  "of the ripple; the paper's arm moves by 0.26 deg for 1 N"),
    NUMBER("phase",       AT(sim_drive_error_t, ripple_phase),      RANGE("-", 0.0, 1.0, 0.0),       "of the ripple at F = 0, in periods"),
    END};

#define MODEL_WORD(name_, text_) #name_,
#define MODEL_KEYS(name_, text_) {.name = #name_, .type = SIM_KEY_GROUP, AT(sim_plant_keys_t, own[SIM_TRUTH_##name_]), .keys_of_model = &sim_##name_##_truth.keys},
static const char *const models[] = {SIM_TRUTH_MODELS(MODEL_WORD) NULL};

static const sim_key_t plant_keys[] = {
    CHOICE("model",                   AT(sim_plant_keys_t, model),                   models, 0.0, "the truth model, see below"),
    NUMBER("step_s",                  AT(sim_plant_keys_t, step_s),                  RANGE("s", 1e-7, 0.1, 1e-4),      "plant step; must go into `sample_time_s` a whole number of times"),
    NUMBER("actuator_pole_rad_per_s", AT(sim_plant_keys_t, actuator_pole_rad_per_s), RANGE("rad/s", 1e-3, 1e9, 200.0), "first-order actuator"),
    GROUP("friction",                 AT(sim_plant_keys_t, friction),                friction_keys, 0, ""),
    GROUP("arm",                      AT(sim_plant_keys_t, arm),                     arm_keys, 0, ""),
    GROUP("command",                  AT(sim_plant_keys_t, drive_error),             command_keys, 0, ""),
    GROUP("ripple",                   AT(sim_plant_keys_t, drive_error),             ripple_keys, 0, ""),
    SIM_TRUTH_MODELS(MODEL_KEYS)
    END};

static const sim_key_t sensor_keys[] = {
    NUMBER("pole_rad_per_s", AT(sim_sensor_keys_t, pole_rad_per_s),          RANGE("rad/s", 1e-3, 1e9, 55.0), "first-order sensor filter"),
    NUMBER("noise_N",        AT(sim_sensor_keys_t, sampling.noise_n),        RANGE("N", 0.0, 1e6, 0.0),       "standard deviation of white Gaussian noise, one value a sample"),
    WHOLE("noise_seed",      AT(sim_sensor_keys_t, sampling.noise_seed),     RANGE("-", 0.0, 18446744073709551615.0, 1.0), "same seed, same noise, on every machine"),
    NUMBER("quantisation_N", AT(sim_sensor_keys_t, sampling.quantisation_n), RANGE("N", 0.0, 1e6, 0.0),       "readings are rounded to multiples of this, which is at least 1e-12; 0: not at all"),
    NUMBER("delay_s",        AT(sim_sensor_keys_t, sampling.delay_s),        RANGE("s", 0.0, 10.0, 0.0),      "rounded to whole plant steps"),
    END};

static const sim_key_t section_keys[] = {
    REQUIRED("b0", AT(sim_section_t, b0), RANGE("-", -1e6, 1e6, 0.0), "numerator (b0 + b1 z⁻¹ + b2 z⁻²), or b0 d² + b1 d + b2 with d = z − 1; b0 not 0"),
    REQUIRED("b1", AT(sim_section_t, b1), RANGE("-", -1e6, 1e6, 0.0), "likewise"),
    REQUIRED("b2", AT(sim_section_t, b2), RANGE("-", -1e6, 1e6, 0.0), "likewise"),
    REQUIRED("a1", AT(sim_section_t, a1), RANGE("-", -4.0, 4.0, 0.0), "denominator 1 + a1 z⁻¹ + a2 z⁻², or d² + a1 d + a2; stable"),
    REQUIRED("a2", AT(sim_section_t, a2), RANGE("-", -4.0, 4.0, 0.0), "likewise"),
    END};

static const char *const controller_kinds[] = {[SIM_CONTROLLER_PAPER] = "paper", [SIM_CONTROLLER_Z] = "z", [SIM_CONTROLLER_DELTA] = "delta", [SIM_CONTROLLER_NONE] = "none", NULL};

static const sim_key_t controller_keys[] = {
    CHOICE("kind", AT(sim_controller_config_t, kind), controller_kinds, 0.0, "`paper`: tribo/paper_controller.h, at 1 ms only; `z`, `delta`: `sections` in z⁻¹ or in z − 1; `none`: open loop, u is r within the limits"),
    LIST("sections", sim_controller_config_t, sections, section_count, SIM_SECTIONS_MAX, section_keys,
         STATUS(SECTION_COUNT) | STATUS(SECTION_COEFFICIENT) | STATUS(SECTION_FEEDTHROUGH) | STATUS(SECTION_UNSTABLE) | STATUS(ANTI_WINDUP) | STATUS(HEADROOM),
         "1 to 4 second-order sections, the first nearest to the error"),
    END};

static const sim_key_t learning_keys[] = {
    CHECKED("spread_scale",      AT(sim_learning_config_t, spread_scale),      RANGE("-", 1e-3, 2.0, 0.4),   STATUS(LEARNING_SPREAD), "how far off the believed breakaway may be as a factor: standard deviation; in Q31 at most 1"),
    NUMBER("spread_offset_N",    AT(sim_learning_config_t, spread_offset_n),   RANGE("N", 1e-9, 1e6, 0.01),  "and as an offset"),
    CHECKED("correlation",       AT(sim_learning_config_t, correlation),       RANGE("-", 0.0, 0.99, 0.7),   STATUS(LEARNING_CORRELATION), "of the directions before anything is learned"),
    NUMBER("correlation_faded",  AT(sim_learning_config_t, correlation_faded), RANGE("-", 0.0, 0.99, 0.1),   "and once forgotten"),
    CHECKED("trust",             AT(sim_learning_config_t, trust),             RANGE("-", 0.0, 1.0, 0.5),    STATUS(LEARNING_TRUST),      "share of the believed breakaway that is fed forward before anything is learned"),
    NUMBER("doubt",              AT(sim_learning_config_t, doubt),             RANGE("-", 1e-3, 1.0, 1.0),   "what is left of that doubt to begin with: 1, or less where the believed breakaway has itself been learned (`learned.yaml`)"),
    CHECKED("weight_N",          AT(sim_learning_config_t, weight_n),          RANGE("N", 1e-9, 1e6, 2e-4),  STATUS(LEARNING_WEIGHT),     "travel over which noise averages out; larger is slower"),
    CHECKED("forgetting_per_N",  AT(sim_learning_config_t, forgetting_per_n),  RANGE("1/N", 0.0, 1e6, 0.1),  STATUS(LEARNING_FORGETTING), "share of the first doubt that comes back per newton; 1 for friction that drifts"),
    CHECKED("scale_min",         AT(sim_learning_config_t, scale_min),         RANGE("-", 1e-3, 1.0, 0.2),   STATUS(LEARNING_BOUNDS),     "what is learned stays above this share of the believed breakaway"),
    NUMBER("scale_max",          AT(sim_learning_config_t, scale_max),         RANGE("-", 1.0, 10.0, 3.0),   "and below this multiple"),
    END};

static const sim_key_t hold_keys[] = {
    CHECKED("gain",             AT(sim_hold_config_t, gain),             RANGE("-", 0.0, 0.99, 0.95),   STATUS(HOLD_GAIN),     "E: friction fed back while r stands; 0: never"),
    CHECKED("still_time_s",     AT(sim_hold_config_t, still_time_s),     RANGE("s", 1e-6, 1e3, 1.5),    STATUS(HOLD_TIME),     "r stands when it has for that long"),
    CHECKED("margin",           AT(sim_hold_config_t, margin),           RANGE("-", 0.1, 1.0, 0.85),    STATUS(HOLD_MARGIN),   "of the learned breakaway, that is fed back"),
    NUMBER("quick_time_s",      AT(sim_hold_config_t, quick_time_s),     RANGE("s", 1e-6, 1e3, 0.2),    "changes of side within that time are chatter, and make it cautious"),
    CHECKED("caution_travel_N", AT(sim_hold_config_t, caution_travel_n), RANGE("N", 1e-9, 1e6, 0.1),    STATUS(HOLD_CAUTION),  "learning over which caution fades"),
    CHECKED("deadband_time_s",  AT(sim_hold_config_t, deadband_time_s),  RANGE("s", 1e-6, 1e3, 0.3),    STATUS(HOLD_DEADBAND), "filters of the deadband that keeps noise of y from moving u"),
    END};

static const sim_key_t feedforward_keys[] = {
    CHECKED("actuator_pole_rad_per_s", AT(sim_feedforward_config_t, actuator_pole_rad_per_s), RANGE("rad/s", 1e-3, 1e6, 200.0), STATUS(ACTUATOR_POLE), "what the loop believes of the actuator"),
    CHECKED("sensor_pole_rad_per_s",   AT(sim_feedforward_config_t, sensor_pole_rad_per_s),   RANGE("rad/s", 1e-3, 1e6, 55.0),  STATUS(SENSOR_POLE),   "and of the sensor"),
    CHECKED("reversal_N",              AT(sim_feedforward_config_t, reversal_n),              RANGE("N", 1e-9, 1e6, 0.5e-3),    STATUS(REVERSAL_WIDTH), "w: r has turned when it has come back by that much; the error at a reversal is at least about w"),
    CHECKED("jump_time_s",             AT(sim_feedforward_config_t, jump_time_s),             RANGE("s", 1e-6, 1e3, 0.02),      STATUS(JUMP_TIME),      "over which friction changes sign at a reversal"),
    CHECKED("lead",                    AT(sim_feedforward_config_t, lead),                    RANGE("-", 0.0, 1.0, 1.0),        STATUS(LEAD),           "share of the lag from u to F that the rate of r makes up for; 0: no rate is used"),
    NUMBER("noise_gain",               AT(sim_feedforward_config_t, noise_gain),              RANGE("-", 0.0, 8.0, 4.0),        "widens `reversal_N` by the noise of r; 0 for a clean r"),
    CHECKED("noise_time_s",            AT(sim_feedforward_config_t, noise_time_s),            RANGE("s", 1e-6, 1e3, 0.25),      STATUS(REFERENCE_NOISE), "over which the noise of r is averaged"),
    NUMBER("rate_time_s",              AT(sim_feedforward_config_t, rate_time_s),             RANGE("s", 1e-6, 1e3, 0.01),      "filter of the rate of r"),
    CHECKED("rate_max_N_per_s",        AT(sim_feedforward_config_t, rate_max_n_per_s),        RANGE("N/s", 1e-6, 1e9, 2.0),     STATUS(REFERENCE_RATE), "a faster r is a step"),
    CHECKED("offset_time_s",           AT(sim_feedforward_config_t, offset_time_s),           RANGE("s", 1e-6, 1e3, 5.0),       STATUS(OFFSET_TIME),    "with which the offset leaks away"),
    CHECKED("slide_width_N",           AT(sim_feedforward_config_t, slide_width_n),           RANGE("N", 1e-9, 1e6, 3e-3),      STATUS(SLIDE_WIDTH),    "tells travel of y from its noise"),
    CHECKED("slide_filter_time_s",     AT(sim_feedforward_config_t, slide_filter_time_s),     RANGE("s", 1e-6, 10.0, 0.02),     STATUS(SLIDE_FILTER),   "of friction meter and slide detector"),
    CHECKED("slide_rate_max_N_per_s",  AT(sim_feedforward_config_t, slide_rate_max_n_per_s),  RANGE("N/s", 1e-6, 1e9, 0.5),     STATUS(SLIDE_RATE),     "nothing is learned from a faster y"),
    CHECKED("slide_run_in_N",          AT(sim_feedforward_config_t, slide_run_in_n),          RANGE("N", 1e-9, 1e6, 5e-3),      STATUS(SLIDE_RUN_IN),   "travelled before learning begins"),
    CHECKED("slide_error_max_N",       AT(sim_feedforward_config_t, slide_error_max_n),       RANGE("N", 1e-9, 1e6, 1e-3),      STATUS(SLIDE_ERROR),    "nothing is learned with a larger filtered error"),
    GROUP("learning",                  AT(sim_feedforward_config_t, learning),                learning_keys, 0, ""),
    GROUP("hold",                      AT(sim_feedforward_config_t, hold),                    hold_keys, 0, ""),
    END};

static const char *const methods[] = {[SIM_METHOD_PAPER] = "paper", [SIM_METHOD_FEEDFORWARD] = "feedforward", [SIM_METHOD_OFF] = "off", NULL};

static const char *const friction_models[] = {[SIM_MODEL_PAPER] = "paper", [SIM_MODEL_LUGRE] = "lugre", NULL};

static const sim_key_t lugre_keys[] = {
    CHECKED("stiffness_N_per_deg",         AT(sim_bristles_config_t, stiffness_n_per_deg),         RANGE("N/deg", 1.0, 1e7, 1e5),                 STATUS(BRISTLE_STIFFNESS), "σ0 of Eq. (12): of the bristles"),
    CHECKED("bristle_damping_N_s_per_deg", AT(sim_bristles_config_t, bristle_damping_n_s_per_deg), RANGE("N s/deg", 0.0, 1e4, 316.22776601683796), STATUS(BRISTLE_DAMPING),   "σ1: of the bristles; at most 1000 σ0 h"),
    CHECKED("viscous_N_s_per_deg",         AT(sim_bristles_config_t, viscous_n_s_per_deg),         RANGE("N s/deg", 0.0, 10.0, 0.4),              STATUS(BRISTLE_VISCOUS),   "σ2: of sliding, beside the arm's own"),
    END};

static const char *const no_yes[] = {"no", "yes", NULL};

static const sim_key_t guard_keys[] = {
    CHOICE("on",            AT(sim_guard_config_t, on),           no_yes, 0.0, "whether what friction compensation adds is faded out, and stays so, once it makes the loop hunt or overshoot"),
    CHECKED("turn_N",       AT(sim_guard_config_t, turn_n),       RANGE("N", 1e-9, 1e6, 0.05), STATUS(GUARD_TURN),  "what is added turns when it comes back by that much: about a third of the breakaway"),
    CHECKED("quick_time_s", AT(sim_guard_config_t, quick_time_s), RANGE("s", 1e-6, 1e3, 0.2),  STATUS(GUARD_TIME),  "turns that are closer may be hunting; up to 100,000 samples"),
    CHECKED("stray_N",      AT(sim_guard_config_t, stray_n),      RANGE("N", 1e-9, 1e6, 0.01), STATUS(GUARD_STRAY), "of an overshoot: about a fifteenth of the breakaway, and over twice the peaks of noise"),
    NUMBER("fade_time_s",   AT(sim_guard_config_t, fade_time_s),  RANGE("s", 1e-6, 1e3, 0.5),  "within which it fades"),
    END};

static const sim_key_t compensator_keys[] = {
    CHOICE("method",  AT(sim_compensator_config_t, method),   methods, 0.0, "how friction is compensated: `paper`, fed back from an estimate that follows u; `feedforward`, fed forward from the reversals of r and learned; `off`"),
    CHOICE("model",   AT(sim_compensator_config_t, model),    friction_models, 0.0, "the friction that `paper` believes in: `paper`, Eq. (3); `lugre`, Eq. (12) with breakaway and gravity of `friction`, whose other keys it does not read"),
    CHECKED("gain",   AT(sim_compensator_config_t, gain),     RANGE("-", 0.0, 2.0, 0.85), STATUS(GAIN), "η of `paper`: how much of the estimated friction is fed back; 0 turns the compensation off"),
    GROUP("friction", AT(sim_compensator_config_t, friction), friction_keys, 0, ""),
    GROUP("arm",      AT(sim_compensator_config_t, arm),      arm_keys, STATUS(ARM_TOO_FAST), ""),
    GROUP("lugre",    AT(sim_compensator_config_t, lugre),    lugre_keys, 0, ""),
    GROUP("feedforward", AT(sim_compensator_config_t, feedforward), feedforward_keys, 0, ""),
    GROUP("guard",    AT(sim_compensator_config_t, guard),    guard_keys, 0, ""),
    END};

static const sim_key_t limits_keys[] = {
    CHECKED("u_min_N",      AT(sim_limits_config_t, u_min_n),      RANGE("N", -1e6, 0.0, -2.0), STATUS(U_MIN),      "actuator limit"),
    CHECKED("u_max_N",      AT(sim_limits_config_t, u_max_n),      RANGE("N", 0.0, 1e6, 2.0),   STATUS(U_MAX),      "actuator limit"),
    CHECKED("input_max_N",  AT(sim_limits_config_t, input_max_n),  RANGE("N", 1e-6, 1e6, 2.0),  STATUS(INPUT_MAX),  "largest credible reference and measurement; beyond it an input is bad"),
    CHECKED("full_scale_N", AT(sim_limits_config_t, full_scale_n), RANGE("N", 1e-3, 1e6, 2.0),  STATUS(FULL_SCALE), "what 2^31 stands for in Q31: every force of the loop fits into it, better twice; in f32 only what chatter is measured by"),
    END};

static const sim_key_t metrics_keys[] = {
    NUMBER("start_s", AT(sim_metrics_config_t, start_s), RANGE("s", 0.0, 86400.0, 0.0), "the errors in the summary are from here"),
    OPTIONAL("end_s", AT(sim_metrics_config_t, end_s),   RANGE("s", 0.0, 86400.0, 0.0), "to here; the end of the run if left out"),
    END};

const sim_key_t sim_keys[] = {
    TEXT("description",      AT(sim_config_t, description),   SIM_DESCRIPTION_MAX, "one line for `tribo-sim list`"),
    REQUIRED("duration_s",   AT(sim_config_t, duration_s),    RANGE("s", 1e-3, 86400.0, 0.0), "length of the run; required"),
    CHECKED("sample_time_s", AT(sim_config_t, sample_time_s), RANGE("s", 1e-6, 0.1, 1e-3), STATUS(SAMPLE_TIME), "of the control loop"),
    GROUP("reference",       AT(sim_config_t, reference),     reference_keys, 0,   "Reference"),
    GROUP("plant",           AT(sim_config_t, plant),         plant_keys, 0,       "Plant: the truth"),
    GROUP("sensor",          AT(sim_config_t, sensor),        sensor_keys, 0,      "Sensor"),
    GROUP("controller",      AT(sim_config_t, controller),    controller_keys, 0,  "Controller"),
    GROUP("compensator",     AT(sim_config_t, compensator),   compensator_keys, 0, "Compensator: what the loop believes"),
    GROUP("limits",          AT(sim_config_t, limits),        limits_keys, 0,      "Limits"),
    GROUP("metrics",         AT(sim_config_t, metrics),       metrics_keys, 0,     "Metrics"),
    END};
// clang-format on

// --- what is found in it -------------------------------------------------------------------------------------------

const sim_key_t *sim_key_below(const sim_key_t *key)
{
    return key->keys_of_model != NULL ? *key->keys_of_model : key->keys;
}

const sim_key_t *sim_key_in(const sim_key_t *keys, const char *name, size_t length)
{
    for (; keys != NULL && keys->name != NULL; keys++)
    {
        if (strncmp(keys->name, name, length) == 0 && keys->name[length] == '\0' &&
            (keys->type != SIM_KEY_GROUP || sim_key_below(keys) != NULL))
        {
            return keys;
        }
    }
    return NULL;
}

/// Takes "[index]" at *path and steps into that element; false if there is none or it is not well formed.
static bool enter_element(sim_place_t *place, const char **path, const char *group)
{
    if (place->key->type != SIM_KEY_LIST || (*path)[1] < '0' || (*path)[1] > '9')
    {
        return false;
    }
    char         *end;
    unsigned long index = strtoul(*path + 1, &end, 10);
    if (group != NULL)
    {
        memcpy(&place->count, group + place->key->count_offset, sizeof place->count);
        place->at = (index < place->count) ? place->at + index * place->key->size : NULL;
    }
    place->is_element = true;
    *path             = end + 1;
    return *end == ']';
}

bool sim_key_find(sim_config_t *config, const char *path, sim_place_t *place)
{
    const sim_key_t *keys  = sim_keys;
    char            *group = (char *)config;
    *place                 = (sim_place_t){.key = NULL};
    while (keys != NULL)
    {
        const size_t length = strcspn(path, ".[");
        *place              = (sim_place_t){.key = sim_key_in(keys, path, length), .count = place->count};
        if (place->key == NULL)
        {
            return false;
        }
        place->at = (group != NULL) ? group + place->key->offset : NULL;
        path += length;
        if (*path == '[' && !enter_element(place, &path, group))
        {
            return false;
        }
        if (*path == '\0')
        {
            return true;
        }
        if (*path++ != '.' || (place->key->type == SIM_KEY_LIST && !place->is_element))
        {
            return false;
        }
        keys  = sim_key_below(place->key);
        group = place->at;
    }
    return false;
}

static void visit_below(const sim_key_t *keys, char *path, size_t length, sim_key_visitor_t visit, void *context)
{
    for (const sim_key_t *key = keys; key != NULL && key->name != NULL; key++)
    {
        const char *dot = (length > 0) ? "." : "";
        size_t      end = length + (size_t)snprintf(path + length, SIM_KEY_MAX - length, "%s%s", dot, key->name);
        if (key->type != SIM_KEY_GROUP || sim_key_below(key) != NULL)
        {
            visit(context, path, key);
        }
        if (key->type == SIM_KEY_LIST)
        {
            end += (size_t)snprintf(path + end, SIM_KEY_MAX - end, "[]");
        }
        visit_below(sim_key_below(key), path, end, visit, context);
        path[length] = '\0';
    }
}

void sim_key_visit(sim_key_visitor_t visit, void *context)
{
    char path[SIM_KEY_MAX] = "";
    visit_below(sim_keys, path, 0, visit, context);
}

void sim_key_set_defaults_below(const sim_key_t *keys, char *group)
{
    for (const sim_key_t *key = keys; key != NULL && key->name != NULL; key++)
    {
        uint64_t whole;
        int      word;
        switch (key->type)
        {
        case SIM_KEY_NUMBER:
            memcpy(group + key->offset, &key->standard, sizeof key->standard);
            break;
        case SIM_KEY_WHOLE:
            whole = (uint64_t)key->standard;
            memcpy(group + key->offset, &whole, sizeof whole);
            break;
        case SIM_KEY_CHOICE:
            word = (int)key->standard;
            memcpy(group + key->offset, &word, sizeof word);
            break;
        case SIM_KEY_GROUP:
            sim_key_set_defaults_below(sim_key_below(key), group + key->offset);
            break;
        default:
            break; // left out, empty: all zeros
        }
    }
}

void sim_key_set_defaults(sim_config_t *config)
{
    *config = (sim_config_t){.duration_s = 0.0};
    sim_key_set_defaults_below(sim_keys, (char *)config);
}

const char *sim_key_type_name(const sim_key_t *key)
{
    static const char *const names[] = {[SIM_KEY_NUMBER]   = "a number",
                                        [SIM_KEY_OPTIONAL] = "a number",
                                        [SIM_KEY_WHOLE]    = "a whole number",
                                        [SIM_KEY_CHOICE]   = "a word",
                                        [SIM_KEY_TEXT]     = "text",
                                        [SIM_KEY_GROUP]    = "a mapping",
                                        [SIM_KEY_LIST]     = "a list"};
    return names[key->type];
}

int sim_key_find_word(const sim_key_t *key, const char *word)
{
    const char *meant = word;
    if (strcmp(key->words[0], "no") == 0)
    {
        meant = strcmp(word, "false") == 0 ? "no" : meant;
        meant = strcmp(word, "true") == 0 ? "yes" : meant;
    }
    int index = 0;
    while (key->words[index] != NULL && strcmp(key->words[index], meant) != 0)
    {
        index++;
    }
    return key->words[index] != NULL ? index : -1;
}

void sim_key_words(const sim_key_t *key, char *text, size_t size)
{
    size_t length = 0;
    text[0]       = '\0';
    for (const char *const *word = key->words; *word != NULL && length < size; word++)
    {
        const char *separator = (word == key->words) ? "" : (word[1] == NULL) ? " or " : ", ";
        length += (size_t)snprintf(text + length, size - length, "%s%s", separator, *word);
    }
}

typedef struct
{
    tribo_status_t status;
    char          *path;
} status_search_t;

static void match_status(void *context, const char *path, const sim_key_t *key)
{
    const status_search_t *search = context;
    // Plant and compensator share rows; the library knows only the compensator.
    if ((key->statuses >> search->status & 1u) != 0u && strncmp(path, "plant.", 6) != 0)
    {
        (void)snprintf(search->path, SIM_KEY_MAX, "%s", path);
    }
}

void sim_key_of_status(tribo_status_t status, char path[SIM_KEY_MAX])
{
    status_search_t search = {.status = status, .path = path};
    path[0]                = '\0';
    sim_key_visit(match_status, &search);
}
