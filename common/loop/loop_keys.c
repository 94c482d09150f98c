// A new parameter of the library needs only a row in tribo/parameters.h. Another key needs a row here and a field in its struct
// (loop_keys.h), which the code that uses it reads. `tribo-sim list --markdown` then shows its row.

#include "loop/loop_keys.h"

#include "keys/rows.h"

// clang-format off: one row a key
// The negative direction has the values of the positive one unless it has its own.
#define AT_BREAKAWAY_OFFSET          offset_n
#define AT_BREAKAWAY_SLOPE           slope
#define AT_BREAKAWAY_NEGATIVE_OFFSET negative_offset_n
#define AT_BREAKAWAY_NEGATIVE_SLOPE  negative_slope
#define BREAKAWAY(group, symbol, member, ...) PARAMETER(group, symbol, AT_##symbol, __VA_ARGS__)

static const common_key_t point_keys[] = {
#define T common_breakaway_point_t
    TRIBO_POINT_ELEMENTS(ELEMENT)
#undef T
    END};

static const common_key_t breakaway_keys[] = {
#define T common_breakaway_config_t
    TRIBO_BREAKAWAY_PARAMETERS(BREAKAWAY)
#undef T
    LIST("table", common_breakaway_config_t, table, table_count, COMMON_BREAKAWAY_POINTS_MAX, point_keys,
         "1 to 32 points that replace offset and slope: linear between them, constant outside"),
    END};

const common_key_t common_friction_keys[] = {
#define T common_friction_config_t
    GROUP("breakaway", AT(common_friction_config_t, breakaway), breakaway_keys, ""),
    TRIBO_FRICTION_PARAMETERS(PARAMETER)
#undef T
    END};

const common_key_t common_arm_keys[] = {
#define T common_arm_config_t
    TRIBO_ARM_PARAMETERS(PARAMETER)
#undef T
    END};

static const char *const reference_kinds[] = {
    [COMMON_REFERENCE_TRIANGLE] = "triangle", [COMMON_REFERENCE_SINE] = "sine", [COMMON_REFERENCE_STEP] = "step", [COMMON_REFERENCE_RAMP] = "ramp",
    [COMMON_REFERENCE_SAWTOOTH] = "sawtooth", [COMMON_REFERENCE_CHIRP] = "chirp", [COMMON_REFERENCE_CSV] = "csv", NULL};

const common_key_t common_reference_keys[] = {
    {.name = "kind", .type = COMMON_KEY_CHOICE, .is_required = true, AT(common_reference_config_t, kind), .unit = "-", .words = reference_kinds,
     .text = "the reference's shape, see above; required"},
    NUMBER("low_N",    AT(common_reference_config_t, low_n),    RANGE("N", -1e6, 1e6, 0.4),      "lowest value"),
    NUMBER("high_N",   AT(common_reference_config_t, high_n),   RANGE("N", -1e6, 1e6, 0.6),      "highest value"),
    NUMBER("start_s",  AT(common_reference_config_t, start_s),  RANGE("s", 0.0, 86400.0, 0.0),   "time at which the reference begins to move"),
    NUMBER("period_s", AT(common_reference_config_t, period_s), RANGE("s", 1e-3, 86400.0, 20.0), "triangle, sine, sawtooth: period"),
    NUMBER("ramp_s",   AT(common_reference_config_t, ramp_s),   RANGE("s", 1e-3, 86400.0, 10.0), "ramp: time from low to high"),
    NUMBER("from_Hz",  AT(common_reference_config_t, from_hz),  RANGE("Hz", 0.0, 1e6, 0.05),     "chirp: first frequency"),
    NUMBER("to_Hz",    AT(common_reference_config_t, to_hz),    RANGE("Hz", 0.0, 1e6, 1.0),      "chirp: last frequency"),
    NUMBER("sweep_s",  AT(common_reference_config_t, sweep_s),  RANGE("s", 1e-3, 86400.0, 60.0), "chirp: time from the first to the last frequency"),
    TEXT("file",       AT(common_reference_config_t, file),     COMMON_PATH_MAX,
         "csv: file with columns `t_s` (rising) and `r_N`; its path starts at the scenario file's folder, or at the current one if given by `--set`"),
    END};

static const common_key_t section_keys[] = {
#define T common_section_t
    TRIBO_SECTION_ELEMENTS(ELEMENT)
#undef T
    END};

static const char *const controller_kinds[] = {[COMMON_CONTROLLER_PAPER] = "paper", [COMMON_CONTROLLER_PI] = "pi", [COMMON_CONTROLLER_Z] = "z", [COMMON_CONTROLLER_DELTA] = "delta", [COMMON_CONTROLLER_NONE] = "none", NULL};

const common_key_t common_controller_keys[] = {
    CHOICE("kind", AT(common_controller_config_t, kind), controller_kinds, 0.0, "`paper`: tribo/paper_controller.h, at 1 ms only; `pi`: `kp` and `ki_per_s`; `z`, `delta`: `sections` in z⁻¹ or in z − 1; `none`: open loop, u is r within the limits"),
    NUMBER("kp",       AT(common_controller_config_t, kp),       RANGE("-", 1e-6, 1e5, 1.0),  "pi: newtons of u per newton of error"),
    NUMBER("ki_per_s", AT(common_controller_config_t, ki_per_s), RANGE("1/s", 0.0, 1e5, 0.0), "pi: newtons of u per newton of error and second; times `sample_time_s` at most 2 `kp`"),
    LIST("sections", common_controller_config_t, sections, section_count, COMMON_SECTIONS_MAX, section_keys,
         "1 to 4 second-order sections, the first nearest to the error"),
    END};

static const common_key_t feedforward_keys[] = {
#define T common_feedforward_config_t
    TRIBO_FEEDFORWARD_PARAMETERS(PARAMETER)
#undef T
    END};

#define METHOD_WORD(symbol, word) word,
static const char *const methods[] = {COMMON_METHODS(METHOD_WORD) NULL};

static const char *const sensors[] = {[COMMON_SENSOR_FORCE] = "force", [COMMON_SENSOR_NONE] = "none", NULL};

static const common_key_t sensorless_keys[] = {
#define T common_sensorless_config_t
    TRIBO_SENSORLESS_PARAMETERS(PARAMETER)
#undef T
    END};

static const char *const no_yes[] = {"no", "yes", NULL};

static const common_key_t guard_keys[] = {
    CHOICE("on",            AT(common_guard_config_t, on),           no_yes, 1.0, "whether friction compensation that makes the loop hunt or overshoot is faded out until it is restored"),
#define T common_guard_config_t
    TRIBO_GUARD_PARAMETERS(PARAMETER)
#undef T
    END};

const common_key_t common_compensator_keys[] = {
    CHOICE("method",  AT(common_compensator_config_t, method),   methods, (double)COMMON_METHOD_FEEDFORWARD, "how friction is compensated: `feedforward`, fed forward from r and learned; `paper`, fed back from an estimate that follows u; `off`"),
    CHOICE("sensor",  AT(common_compensator_config_t, sensor),   sensors, 0.0, "how `feedforward` gets F: `force`, from a sensor; `none`, not at all: without feedback or learning, u follows from r and the configured breakaway"),
#define T common_compensator_config_t
    TRIBO_GAIN_PARAMETERS(PARAMETER)
#undef T
    GROUP("friction", AT(common_compensator_config_t, friction), common_friction_keys, ""),
    GROUP("arm",      AT(common_compensator_config_t, arm),      common_arm_keys, ""),
    GROUP("feedforward", AT(common_compensator_config_t, feedforward), feedforward_keys, ""),
    GROUP("sensorless", AT(common_compensator_config_t, sensorless), sensorless_keys, ""),
    GROUP("guard",    AT(common_compensator_config_t, guard),    guard_keys, ""),
    END};

const common_key_t common_limits_keys[] = {
#define T common_limits_config_t
    TRIBO_LIMIT_PARAMETERS(PARAMETER)
    TRIBO_INPUT_PARAMETERS(PARAMETER)
    TRIBO_SCALE_PARAMETERS(PARAMETER)
#undef T
    END};

const common_key_t common_loop_keys[] = {
    SKIPPED("description"),
    SKIPPED("arithmetic"),
    SKIPPED("duration_s"),
#define T common_loop_keys_t
    TRIBO_SAMPLE_PARAMETERS(PARAMETER)
#undef T
    GROUP("reference",   AT(common_loop_keys_t, reference),   common_reference_keys, "Reference"),
    SKIPPED("plant"),
    SKIPPED("sensor"),
    GROUP("controller",  AT(common_loop_keys_t, controller),  common_controller_keys, "Controller"),
    GROUP("compensator", AT(common_loop_keys_t, compensator), common_compensator_keys, "Compensator: what the loop assumes"),
    GROUP("limits",      AT(common_loop_keys_t, limits),      common_limits_keys, "Limits"),
    SKIPPED("metrics"),
    END};
// clang-format on

const char *common_loop_key_of(tribo_status_t status)
{
#define KEY(group, symbol, member, key, ...) [TRIBO_ERR_##symbol] = TRIBO_KEY_##group key,
#define REFUSAL(symbol, key, text)           [TRIBO_ERR_##symbol] = (key),
    static const char *const keys[TRIBO_STATUS_COUNT]             = {TRIBO_PARAMETERS(KEY) TRIBO_REFUSALS(REFUSAL)};
#undef KEY
#undef REFUSAL
    switch (status)
    {
    case TRIBO_ERR_SECTION_COUNT: // the number of a list's elements is not a key
        return "controller.sections";
    case TRIBO_ERR_TABLE_LENGTH:
        return "compensator.friction.breakaway.table";
    default:
        return (unsigned)status < TRIBO_STATUS_COUNT && keys[status] != NULL ? keys[status] : "";
    }
}
