#include "rig.h"

#include "scenario/reader.h"
#include "support/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// clang-format off: one row a key
#define AT(type_, member) .offset = offsetof(type_, member)
#define TEXT(name_, at, max_, text_)   {.name = (name_), .type = SIM_KEY_TEXT, at, .unit = "-", .max = (max_), .text = (text_)}
#define NUMBER(name_, at, unit_, min_, max_, standard_, text_) \
    {.name = (name_), .type = SIM_KEY_NUMBER, at, .unit = (unit_), .min = (min_), .max = (max_), .standard = (standard_), .text = (text_)}
#define WHOLE(name_, at, unit_, min_, max_, standard_, text_) \
    {.name = (name_), .type = SIM_KEY_WHOLE, at, .unit = (unit_), .min = (min_), .max = (max_), .standard = (standard_), .text = (text_)}
#define CHOICE(name_, at, words_, standard_, text_) \
    {.name = (name_), .type = SIM_KEY_CHOICE, at, .unit = "-", .words = (words_), .standard = (standard_), .text = (text_)}
#define GROUP(name_, offset_, keys_, text_) {.name = (name_), .type = SIM_KEY_GROUP, .offset = (offset_), .keys = (keys_), .text = (text_)}
#define END {.name = NULL}

static const char *const no_or_yes[] = {"no", "yes", NULL};
static const char *const io_words[]  = {[RIG_IO_DEVICES] = "devices", [RIG_IO_SIMULATED] = "simulated", NULL};
static const char *const outputs[]   = {[RIG_OUTPUT_PWM] = "pwm", [RIG_OUTPUT_DAC] = "dac", NULL};
static const char *const biases[]    = {[LINE_BIAS_AS_IS] = "as_is", [LINE_BIAS_DISABLED] = "disabled",
                                        [LINE_BIAS_PULL_UP] = "pull_up", [LINE_BIAS_PULL_DOWN] = "pull_down", NULL};

static const sim_key_t sensor_keys[] = {
    TEXT("device",  AT(rig_t, sensor.device),  CHANNEL_NAME_MAX, "the IIO device of the force: its name, label or id"),
    TEXT("channel", AT(rig_t, sensor.channel), CHANNEL_NAME_MAX, "its channel, e.g. voltage0; a unit is (raw + offset) scale, mV of a voltage"),
    NUMBER("low_units",  AT(rig_t, sensor_low),  "-", -1e9, 1e9, 0.0, "the lower end of what a working sensor reads ..."),
    NUMBER("high_units", AT(rig_t, sensor_high), "-", -1e9, 1e9, 0.0, "... and the upper one; equal: no range"),
    END};

static const sim_key_t pwm_keys[] = {
    TEXT("chip",       AT(rig_t, pwm.chip),      PWM_NAME_MAX, "in /sys/class/pwm, e.g. pwmchip0; a unit of the output is a duty of 1"),
    WHOLE("channel",   AT(rig_t, pwm.channel),   "-",  0.0, 255.0, 0.0, "of the chip"),
    WHOLE("period_ns", AT(rig_t, pwm.period_ns), "ns", 100.0, 1e9, 50000.0, "of the PWM"),
    END};

static const sim_key_t dac_keys[] = {
    TEXT("device",  AT(rig_t, dac.device),  CHANNEL_NAME_MAX, "the IIO device of the command"),
    TEXT("channel", AT(rig_t, dac.channel), CHANNEL_NAME_MAX, "its channel, e.g. voltage0"),
    NUMBER("low_units",  AT(rig_t, dac_low),  "-", -1e9, 1e9, 0.0, "the lower end of its range ..."),
    NUMBER("high_units", AT(rig_t, dac_high), "-", -1e9, 1e9, 0.0, "... and the upper one; equal: no range"),
    END};

static const sim_key_t line_keys[] = {
    TEXT("name",         AT(line_config_t, name),       LINES_NAME_MAX, "the line's name, or else ..."),
    TEXT("chip",         AT(line_config_t, chip),       LINES_NAME_MAX, "... its chip (label, name, number or path) ..."),
    WHOLE("offset",      AT(line_config_t, offset),     "-", 0.0, 1023.0, 0.0, "... and its place there"),
    CHOICE("active_low", AT(line_config_t, active_low), no_or_yes, 0.0, "its level is inverted"),
    CHOICE("bias",       AT(line_config_t, bias),       biases, 0.0, "of an input"),
    END};

#define LINE(number, name_, text_) GROUP(name_, offsetof(rig_t, lines) + (number) * sizeof(line_config_t), line_keys, text_)
static const sim_key_t lines_keys[] = {
    LINE(LINE_ENABLE,         "enable",         "output: the power stage is on"),
    LINE(LINE_PROBE,          "probe",          "output: high during each tick"),
    LINE(LINE_EMERGENCY_STOP, "emergency_stop", "input: high stops the drive; normally closed to ground with a pull-up, so that an open wire stops it"),
    LINE(LINE_POWER_FAULT,    "power_fault",    "input: the power stage's fault, see drive.fault_level"),
    LINE(LINE_READY,          "ready",          "input: the power stage is ready, see drive.ready_ms and drive.ready_level"),
    END};

static const sim_key_t realtime_keys[] = {
    WHOLE("priority",  AT(rig_t, priority), "-", 1.0, 98.0, 80.0, "of SCHED_FIFO; the supervisor's is one more"),
    NUMBER("cpu",      AT(rig_t, cpu),      "-", -1.0, 1023.0, -1.0, "the only one that the loop runs on; -1: any"),
    CHOICE("required", AT(rig_t, required), no_or_yes, 1.0, "without the privileges: yes ends the program, no says so and runs on"),
    WHOLE("catch_up_ms", AT(rig_t, catch_up_ms), "ms", 0.0, 10000.0, 0.0, "how far behind its schedule a drive with `io: simulated` may be and make up for it; 0: drive.late_us is the bound"),
    END};

static const sim_key_t bus_keys[] = {
    TEXT("device", AT(rig_t, bus.device), BUS_NAME_MAX, "the serial line of Modbus RTU, e.g. /dev/ttyUSB0, or else ..."),
    WHOLE("baud",  AT(rig_t, bus.baud),   "-", 1200.0, 4000000.0, 115200.0, "of it, with 8 bits, no parity, 1 stop bit"),
    TEXT("listen", AT(rig_t, bus.listen), BUS_NAME_MAX, "... the address of this machine for Modbus TCP, e.g. 127.0.0.1: whoever reaches it moves the drive"),
    WHOLE("port",  AT(rig_t, bus.port),   "-", 1.0, 65535.0, 1502.0, "of it"),
    END};

#define DRIVE_KEY(type_, name_, unit_, low, high, off, normal, text_) \
    {.name = #name_, .type = SIM_KEY_NUMBER, .offset = offsetof(rig_t, drive_values) + DRIVE_CONFIG_##name_ * sizeof(double), \
     .unit = (unit_), .min = (off) != 0 ? 0.0 : (double)(low), .max = (double)(high), .standard = (double)(normal), .text = (text_)},
static const sim_key_t drive_keys[] = {DRIVE_CONFIG_FIELDS(DRIVE_KEY) END};

static const sim_key_t rig_keys[] = {
    TEXT("scenario", AT(rig_t, scenario), RIG_PATH_MAX, "the scenario whose controller, compensator, limits and reference are taken; required"),
    CHOICE("io", AT(rig_t, io), io_words, 0.0, "`simulated`: the scenario's plant in place of all devices and lines"),
    GROUP("sensor", 0, sensor_keys, "Sensor"),
    CHOICE("output", AT(rig_t, output), outputs, 0.0, "what makes the command"),
    GROUP("pwm", 0, pwm_keys, "PWM"),
    GROUP("dac", 0, dac_keys, "DAC"),
    GROUP("lines", 0, lines_keys, "Lines"),
    GROUP("realtime", 0, realtime_keys, "Real time"),
    WHOLE("heartbeat_ms", AT(rig_t, heartbeat_ms), "ms", 2.0, 10000.0, 10.0, "longest time without a tick after which the supervisor turns the drive off"),
    TEXT("watchdog", AT(rig_t, watchdog), RIG_PATH_MAX, "e.g. /dev/watchdog, kept alive as long as there are ticks"),
    GROUP("bus", 0, bus_keys, "Bus"),
    TEXT("store", AT(rig_t, store), RIG_PATH_MAX, "the file of saved params, which take the place of drive.* and of the scenario's loop"),
    GROUP("drive", 0, drive_keys, "Drive"),
    END};
// clang-format on

bool rig_complain(const sim_sources_t *sources, const char *path, const char *key, const char *what, sim_error_t *error)
{
    const sim_source_t *source = sim_sources_find(sources, key);
    return sim_error_set(error, "%s: %s: %s", source != NULL ? source->place : path, key, what);
}

static bool check_lines(const rig_t *rig, const sim_sources_t *sources, const char *path, sim_error_t *error)
{
    for (int i = 0; i < LINE_COUNT; i++)
    {
        char key[2 * LINES_NAME_MAX];
        (void)snprintf(key, sizeof key, "lines.%s", line_names[i]);
        const bool is_used = line_is_used(&rig->lines[i]);
        if (rig->lines[i].name[0] != '\0' && rig->lines[i].chip[0] != '\0')
        {
            return rig_complain(sources, path, key, "has a name and a chip, one of them is wanted", error);
        }
        if (!is_used && (i == LINE_ENABLE || i == LINE_EMERGENCY_STOP))
        {
            return rig_complain(sources, path, key, "is missing", error);
        }
        if (!is_used && i == LINE_READY && rig->drive.ready_ms > 0u)
        {
            return rig_complain(sources, path, key, "is missing, drive.ready_ms is not 0", error);
        }
    }
    return true;
}

static bool check_devices(const rig_t *rig, const sim_sources_t *sources, const char *path, sim_error_t *error)
{
    const bool pwm = rig->output == RIG_OUTPUT_PWM;
    const struct
    {
        const char *key, *value;
    } texts[] = {{"sensor.device", rig->sensor.device},
                 {"sensor.channel", rig->sensor.channel},
                 {pwm ? "pwm.chip" : "dac.device", pwm ? rig->pwm.chip : rig->dac.device},
                 {pwm ? "pwm.chip" : "dac.channel", pwm ? rig->pwm.chip : rig->dac.channel}};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
    {
        if (texts[i].value[0] == '\0')
        {
            return rig_complain(sources, path, texts[i].key, "is missing", error);
        }
    }
    return check_lines(rig, sources, path, error);
}

/// The drive's config out of the values read; those of whole numbers must be whole.
static bool take_drive(rig_t *rig, const sim_sources_t *sources, const char *path, sim_error_t *error)
{
    char                 key[64];
    char                 what[128];
    drive_config_error_t refused;
    for (size_t i = 0; i < DRIVE_CONFIG_COUNT; i++)
    {
        const drive_config_field_t *field = &drive_config_fields[i];
        const double                value = rig->drive_values[i];
        const uint32_t              whole = (uint32_t)value;
        const float                 real  = (float)value;
        memcpy((char *)&rig->drive + i * sizeof real,
               field->is_float ? (const void *)&real : (const void *)&whole,
               sizeof real);
        if (!field->is_float && (double)whole != value)
        {
            (void)snprintf(key, sizeof key, "drive.%s", drive_config_name((unsigned)i));
            (void)snprintf(what, sizeof what, "%.10g is no whole number", value);
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

bool rig_load(rig_t *rig, const char *path, sim_sources_t *sources, sim_error_t *error)
{
    *rig = (rig_t){.io = RIG_IO_DEVICES};
    sim_key_set_defaults_below(rig_keys, (char *)rig);
    char *content = sim_file_read(path, SIM_FILE_BYTES_MAX, error);
    if (content == NULL)
    {
        return false;
    }
    const sim_text_t text = {.text = content, .name = path, .prefix = "", .keys = rig_keys, .group = (char *)rig};
    const bool       ok   = sim_read(&text, sources, error);
    free(content);
    if (!ok || !take_drive(rig, sources, path, error))
    {
        return false;
    }
    if (rig->scenario[0] == '\0')
    {
        return rig_complain(sources, path, "scenario", "is missing", error);
    }
    if (rig->bus.device[0] != '\0' && rig->bus.listen[0] != '\0')
    {
        return rig_complain(sources, path, "bus", "has a device and an address, one of them is wanted", error);
    }
    if (rig->io == RIG_IO_DEVICES && rig->catch_up_ms > 0u)
    {
        return rig_complain(sources,
                            path,
                            "realtime.catch_up_ms",
                            "is for simulated devices only: a rig does not wait for a late tick",
                            error);
    }
    return rig->io == RIG_IO_SIMULATED || check_devices(rig, sources, path, error);
}

/// A | in it is none of the table's.
static void print_cell(const char *text)
{
    for (const char *p = text; *p != '\0'; p++)
    {
        (void)fputs(*p == '|' ? "\\" : "", stdout);
        (void)putchar(*p);
    }
}

static void print_rows(const sim_key_t *keys, const char *prefix)
{
    for (const sim_key_t *key = keys; key->name != NULL; key++)
    {
        char name[96];
        char allowed[SIM_WORDS_MAX] = "text";
        char standard[64]           = "-";
        (void)snprintf(name, sizeof name, "%s%s", prefix, key->name);
        if (key->type == SIM_KEY_GROUP)
        {
            (void)snprintf(name, sizeof name, "%s%s.", prefix, key->name);
            print_rows(key->keys, name);
            continue;
        }
        if (key->type == SIM_KEY_CHOICE)
        {
            sim_key_words(key, allowed, sizeof allowed);
            (void)snprintf(standard, sizeof standard, "%s", key->words[(int)key->standard]);
        }
        else if (key->type != SIM_KEY_TEXT)
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
