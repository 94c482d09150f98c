#include "rig.h"

#include "keys/reader.h"
#include "keys/rows.h"
#include "support/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// clang-format off: one row a key
static const char *const no_or_yes[] = {"no", "yes", NULL};
static const char *const outputs[]   = {[RIG_OUTPUT_PWM] = "pwm", [RIG_OUTPUT_DAC] = "dac", NULL};
static const char *const biases[]    = {[LINE_BIAS_AS_IS] = "as_is", [LINE_BIAS_DISABLED] = "disabled",
                                        [LINE_BIAS_PULL_UP] = "pull_up", [LINE_BIAS_PULL_DOWN] = "pull_down", NULL};

static const common_key_t sensor_keys[] = {
    TEXT("device",  AT(rig_t, sensor.device),  CHANNEL_NAME_MAX, "name, label or id of the force's IIO device; not used if the scenario has compensator.sensor none"),
    TEXT("channel", AT(rig_t, sensor.channel), CHANNEL_NAME_MAX, "its channel, e.g. voltage0; a unit is (raw + offset) scale, e.g. mV for a voltage"),
    NUMBER("low_units",  AT(rig_t, sensor_low),  RANGE("-", -1e9, 1e9, 0.0), "lowest reading of a working sensor ..."),
    NUMBER("high_units", AT(rig_t, sensor_high), RANGE("-", -1e9, 1e9, 0.0), "... and its highest; equal: no range"),
    END};

static const common_key_t measured_keys[] = {
    TEXT("device",     AT(rig_measure_t, channel.device),  CHANNEL_NAME_MAX, "name, label or id of the IIO device"),
    TEXT("channel",    AT(rig_measure_t, channel.channel), CHANNEL_NAME_MAX, "its channel, e.g. voltage1"),
    NUMBER("per_unit", AT(rig_measure_t, per_unit), RANGE("-", -1e6, 1e6, 1e-3), "A, V or degC for a unit ..."),
    NUMBER("zero",     AT(rig_measure_t, zero),     RANGE("-", -1e9, 1e9, 0.0), "... beyond this reading"),
    END};

static const common_key_t position_keys[] = {
    TEXT("file",  AT(rig_t, position.file), COUNTER_PATH_MAX, "its file in sysfs, e.g. /sys/bus/counter/devices/counter0/count0/count"),
    WHOLE("bits", AT(rig_t, position.bits), RANGE("-", 1.0, 32.0, 32.0), "the counter wraps at 2^bits"),
    END};

#define MEASURED(number, name_, text_) GROUP(name_, .offset = offsetof(rig_t, measured) + (number) * sizeof(rig_measure_t), measured_keys, text_)

static const common_key_t pwm_keys[] = {
    TEXT("chip",       AT(rig_t, pwm.chip),      PWM_NAME_MAX, "the PWM chip in /sys/class/pwm, e.g. pwmchip0; a unit of the output is a duty of 1"),
    WHOLE("channel",   AT(rig_t, pwm.channel),   RANGE("-",  0.0, 255.0, 0.0), "channel of the chip"),
    WHOLE("period_ns", AT(rig_t, pwm.period_ns), RANGE("ns", 100.0, 1e9, 50000.0), "period of the PWM"),
    END};

static const common_key_t dac_keys[] = {
    TEXT("device",  AT(rig_t, dac.device),  CHANNEL_NAME_MAX, "name, label or id of the command's IIO device"),
    TEXT("channel", AT(rig_t, dac.channel), CHANNEL_NAME_MAX, "its channel, e.g. voltage0"),
    NUMBER("low_units",  AT(rig_t, dac_low),  RANGE("-", -1e9, 1e9, 0.0), "lowest output ..."),
    NUMBER("high_units", AT(rig_t, dac_high), RANGE("-", -1e9, 1e9, 0.0), "... and highest; equal: no range"),
    END};

static const common_key_t line_keys[] = {
    TEXT("name",         AT(line_config_t, name),       LINES_NAME_MAX, "name of the line, or ..."),
    TEXT("chip",         AT(line_config_t, chip),       LINES_NAME_MAX, "... its chip (label, name, number or path) ..."),
    WHOLE("offset",      AT(line_config_t, offset),     RANGE("-", 0.0, 1023.0, 0.0), "... and the line's number there"),
    CHOICE("active_low", AT(line_config_t, active_low), no_or_yes, 0.0, "yes: the level is inverted"),
    CHOICE("bias",       AT(line_config_t, bias),       biases, 0.0, "bias of an input"),
    END};

#define LINE(number, name_, text_) GROUP(name_, .offset = offsetof(rig_t, lines) + (number) * sizeof(line_config_t), line_keys, text_)
static const common_key_t lines_keys[] = {
    LINE(LINE_ENABLE,         "enable",         "output: the power stage is on"),
    LINE(LINE_HEARTBEAT,      "heartbeat",      "output: changes its level every heartbeat_ticks ticks unless something has failed, for a retriggerable one-shot on the enable path"),
    LINE(LINE_PROBE,          "probe",          "output: high during each tick"),
    LINE(LINE_EMERGENCY_STOP, "emergency_stop", "input: high stops the drive; normally closed to ground with a pull-up, so that an open wire stops it"),
    LINE(LINE_POWER_FAULT,    "power_fault",    "input: the power stage's fault, see drive.fault_level"),
    LINE(LINE_READY,          "ready",          "input: the power stage is ready, see drive.ready_ms and drive.ready_level"),
    END};

static const common_key_t realtime_keys[] = {
    WHOLE("priority",  AT(rig_t, priority), RANGE("-", 1.0, 98.0, 80.0), "priority of SCHED_FIFO; that of the supervisor is one higher"),
    NUMBER("cpu",      AT(rig_t, cpu),      RANGE("-", -1.0, 1023.0, -1.0), "CPU of the loop; -1: any"),
    CHOICE("required", AT(rig_t, required), no_or_yes, 1.0, "without the privileges, yes ends the program and no warns and runs on"),
    WHOLE("catch_up_ms", AT(rig_t, catch_up_ms), RANGE("ms", 0.0, 10000.0, 0.0), "delay behind its schedule that tribo-desk may catch up; 0: drive.late_us is the bound"),
    END};

static const common_key_t bus_keys[] = {
    TEXT("device", AT(rig_t, bus.device), BUS_NAME_MAX, "serial line of Modbus RTU, e.g. /dev/ttyUSB0, or ..."),
    CHOICE("rs485", AT(rig_t, bus.rs485), no_or_yes, 0.0, "yes: the kernel's driver enables the line's transceiver while it sends"),
    WHOLE("baud",  AT(rig_t, bus.baud),   RANGE("-", 1200.0, 4000000.0, 115200.0), "rate of the line, with 8 bits, no parity, 1 stop bit"),
    TEXT("listen", AT(rig_t, bus.listen), BUS_NAME_MAX, "... address of this machine for Modbus TCP; anyone who reaches it can move the drive; 127.0.0.1 if only bus.port is given"),
    WHOLE("port",  AT(rig_t, bus.port),   RANGE("-", 1.0, 65535.0, 1502.0), "port of this address"),
    WHOLE("silent_s", AT(rig_t, bus.silent_s), RANGE("s", 1.0, 3600.0, 10.0), "a client that sends no request for longer gives its place to the next one"),
    END};

#define DRIVE_KEY(type_, name_, unit_, low, high, off, normal, change, text_) \
    {.name = #name_, .type = COMMON_KEY_NUMBER, .offset = offsetof(rig_t, drive_values) + DRIVE_CONFIG_##name_ * sizeof(double), \
     .unit = (unit_), .min = (off) != 0 ? 0.0 : (double)(low), .max = (double)(high), .standard = (double)(normal), .text = (text_)},
static const common_key_t drive_keys[] = {DRIVE_CONFIG_FIELDS(DRIVE_KEY) END};

static const common_key_t rig_keys[] = {
    TEXT("scenario", AT(rig_t, scenario), RIG_PATH_MAX, "scenario that gives controller, compensator, limits and reference: a file, or the name of one that comes with the program; required"),
    GROUP("sensor", .offset = 0, sensor_keys, "Sensor"),
    MEASURED(RIG_CURRENT,     "current",     "The motor's current, for drive.over_current_a; each tick reads one of current, supply and temperature"),
    MEASURED(RIG_SUPPLY,      "supply",      "The power stage's supply, for drive.bus_low_v and bus_high_v"),
    MEASURED(RIG_TEMPERATURE, "temperature", "The power stage's temperature, for drive.temperature_max_c"),
    GROUP("position", .offset = 0, position_keys, "A counter of the arm's position, for drive.speed_max_units_per_s and motion_units: a unit is a count, read each tick"),
    CHOICE("output", AT(rig_t, output), outputs, 0.0, "device that outputs the command"),
    GROUP("pwm", .offset = 0, pwm_keys, "PWM"),
    GROUP("dac", .offset = 0, dac_keys, "DAC"),
    GROUP("lines", .offset = 0, lines_keys, "Lines"),
    GROUP("realtime", .offset = 0, realtime_keys, "Real time"),
    WHOLE("heartbeat_ms", AT(rig_t, heartbeat_ms), RANGE("ms", 2.0, 10000.0, 10.0), "time without a tick after which the supervisor turns the drive off"),
    WHOLE("heartbeat_ticks", AT(rig_t, heartbeat_ticks), RANGE("ticks", 1.0, 1000.0, 1.0), "ticks from edge to edge of lines.heartbeat"),
    CHOICE("read_back", AT(rig_t, read_back), no_or_yes, 1.0, "yes: lines.enable is read back in each tick; no: for a chip whose outputs read as 0"),
    WHOLE("ready_off_ms", AT(rig_t, ready_off_ms), RANGE("ms", 0.0, 10000.0, 100.0), "time allowed to lines.ready to fall after enable is off; longer is a fault of the power stage; 0: not checked"),
    TEXT("watchdog", AT(rig_t, watchdog), RIG_PATH_MAX, "watchdog device, e.g. /dev/watchdog, kept alive as long as there are ticks; required; `none`: a kernel that hangs leaves the outputs as they are"),
    WHOLE("watchdog_s", AT(rig_t, watchdog_s), RANGE("s", 1.0, 60.0, 1.0), "its timeout, set and read back; longer than the output's driver may block"),
    GROUP("bus", .offset = 0, bus_keys, "Bus"),
    TEXT("store", AT(rig_t, store), RIG_PATH_MAX, "file of saved params, which replace drive.* and the scenario's loop"),
    GROUP("drive", .offset = 0, drive_keys, "Drive"),
    END};
// clang-format on

bool rig_complain(const common_sources_t *sources,
                  const char             *path,
                  const char             *key,
                  const char             *what,
                  common_error_t         *error)
{
    const common_source_t *source = common_sources_find(sources, key);
    return common_error_set(error, "%s: %s: %s", source != NULL ? source->place : path, key, what);
}

static bool check_lines(const rig_t *rig, const common_sources_t *sources, const char *path, common_error_t *error)
{
    for (int i = 0; i < LINE_COUNT; i++)
    {
        char key[2 * LINES_NAME_MAX];
        (void)snprintf(key, sizeof key, "lines.%s", line_names[i]);
        const bool is_used = line_is_used(&rig->lines[i]);
        if (rig->lines[i].name[0] != '\0' && rig->lines[i].chip[0] != '\0')
        {
            return rig_complain(sources, path, key, "has a name and a chip: give only one of them", error);
        }
        if (!is_used && (i == LINE_ENABLE || i == LINE_EMERGENCY_STOP))
        {
            return rig_complain(sources, path, key, "is missing", error);
        }
        if (!is_used && i == LINE_READY && rig->drive.ready_ms > 0u)
        {
            return rig_complain(sources, path, key, "is missing; a drive.ready_ms other than 0 needs it", error);
        }
    }
    return true;
}

static bool check_devices(const rig_t *rig, const common_sources_t *sources, const char *path, common_error_t *error)
{
    const bool pwm = rig->output == RIG_OUTPUT_PWM;
    const struct
    {
        const char *key, *value;
    } texts[] = {{"sensor.channel", rig_has_sensor(rig) ? rig->sensor.channel : "-"},
                 {pwm ? "pwm.chip" : "dac.device", pwm ? rig->pwm.chip : rig->dac.device},
                 {pwm ? "pwm.chip" : "dac.channel", pwm ? rig->pwm.chip : rig->dac.channel}};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
    {
        if (texts[i].value[0] == '\0')
        {
            return rig_complain(sources, path, texts[i].key, "is missing", error);
        }
    }
    return check_lines(rig, sources, path, error) &&
           (rig->watchdog[0] != '\0' ||
            rig_complain(
                sources,
                path,
                "watchdog",
                "is missing: give a device, e.g. /dev/watchdog, or none, with which a kernel that hangs leaves the "
                "outputs as they are",
                error));
}

bool rig_has_sensor(const rig_t *rig)
{
    return rig->sensor.device[0] != '\0';
}

const char *rig_watchdog(const rig_t *rig)
{
    return strcmp(rig->watchdog, "none") != 0 && rig->watchdog[0] != '\0' ? rig->watchdog : NULL;
}

/// Makes the drive's config from the values read. Values of integer fields must be whole numbers.
static bool take_drive(rig_t *rig, const common_sources_t *sources, const char *path, common_error_t *error)
{
    char                 key[64];
    char                 what[128];
    drive_config_error_t refused;
    for (size_t i = 0; i < DRIVE_CONFIG_COUNT; i++)
    {
        const drive_config_field_t *field = &drive_config_fields[i];
        const double                value = rig->drive_values[i];
        const uint32_t              whole = field->is_float ? 0u : (uint32_t)value;
        const float                 real  = (float)value;
        memcpy((char *)&rig->drive + i * sizeof real,
               field->is_float ? (const void *)&real : (const void *)&whole,
               sizeof real);
        if (!field->is_float && (double)whole != value)
        {
            (void)snprintf(key, sizeof key, "drive.%s", drive_config_name((unsigned)i));
            (void)snprintf(what, sizeof what, "%.10g is not a whole number", value);
            return rig_complain(sources, path, key, what, error);
        }
    }
    if (!drive_config_check(&rig->drive, &refused))
    {
        (void)snprintf(key, sizeof key, "drive.%s", drive_config_name(refused.field));
        (void)snprintf(what,
                       sizeof what,
                       "%.9g is outside %s%.9g to %.9g",
                       (double)refused.value,
                       refused.off ? "0 and " : "",
                       (double)refused.low,
                       (double)refused.high);
        return rig_complain(sources, path, key, what, error);
    }
    return true;
}

bool rig_load(rig_t *rig, const char *path, bool at_desk, common_sources_t *sources, common_error_t *error)
{
    *rig = (rig_t){.output = RIG_OUTPUT_PWM};
    common_key_set_defaults(rig_keys, (char *)rig);
    char *content = common_file_read(path, COMMON_FILE_BYTES_MAX, error);
    if (content == NULL)
    {
        return false;
    }
    const common_text_t text =
        {.text = content, .name = path, .prefix = "", .root = rig_keys, .keys = rig_keys, .group = (char *)rig};
    const bool ok = common_read(&text, sources, error);
    free(content);
    if (!ok || !take_drive(rig, sources, path, error))
    {
        return false;
    }
    if (rig->scenario[0] == '\0')
    {
        return rig_complain(sources, path, "scenario", "is missing", error);
    }
    if (rig->bus.device[0] == '\0' && rig->bus.listen[0] == '\0' && common_sources_has(sources, "bus.port"))
    {
        (void)snprintf(rig->bus.listen, sizeof rig->bus.listen, "127.0.0.1");
    }
    if (rig->bus.device[0] != '\0' && rig->bus.listen[0] != '\0')
    {
        return rig_complain(sources, path, "bus", "has a device and an address: give only one of them", error);
    }
    if (!at_desk && rig->catch_up_ms > 0u)
    {
        return rig_complain(sources,
                            path,
                            "realtime.catch_up_ms",
                            "is only for tribo-desk: a rig does not wait for a late tick",
                            error);
    }
    return at_desk || check_devices(rig, sources, path, error);
}

/// Escapes each |, which would end a cell of the table.
static void print_cell(const char *text)
{
    for (const char *p = text; *p != '\0'; p++)
    {
        (void)fputs(*p == '|' ? "\\" : "", stdout);
        (void)putchar(*p);
    }
}

static void print_rows(const common_key_t *keys, const char *prefix)
{
    for (const common_key_t *key = keys; key->name != NULL; key++)
    {
        char name[96];
        char allowed[COMMON_WORDS_MAX] = "text";
        char standard[64]              = "-";
        (void)snprintf(name, sizeof name, "%s%s", prefix, key->name);
        if (key->type == COMMON_KEY_GROUP)
        {
            (void)snprintf(name, sizeof name, "%s%s.", prefix, key->name);
            print_rows(key->keys, name);
            continue;
        }
        if (key->type == COMMON_KEY_CHOICE)
        {
            common_key_words(key, allowed, sizeof allowed);
            (void)snprintf(standard, sizeof standard, "%s", key->words[(int)key->standard]);
        }
        else if (key->type != COMMON_KEY_TEXT)
        {
            (void)snprintf(allowed, sizeof allowed, "%g to %g", key->min, key->max);
            (void)snprintf(standard, sizeof standard, "%g", key->standard);
        }
        (void)printf("| `%s` | %s | %s | %s | ", name, key->unit[0] != '\0' ? key->unit : "-", allowed, standard);
        print_cell(key->text);
        (void)puts(" |");
    }
}

void rig_print_keys(void)
{
    (void)puts("| key | unit | range | default | meaning |\n|---|---|---|---|---|");
    print_rows(rig_keys, "");
}
