/// The configuration of tribo-drive and tribo-desk, from YAML: devices, lines, real time, the drive's config, and the scenario
/// whose loop and reference they run. The keys are in rig.c; `tribo-drive --keys` prints a table of them.

#ifndef LINUX_RIG_H
#define LINUX_RIG_H

#include "app/config.h"
#include "bus.h"
#include "channel.h"
#include "counter.h"
#include "keys/source.h"
#include "lines.h"
#include "pwm.h"
#include "realtime.h"

#define RIG_PATH_MAX 255u

typedef enum
{
    RIG_OUTPUT_PWM,
    RIG_OUTPUT_DAC
} rig_output_t;

/// The measured quantities of the power stage, in the order of port_measured_t.
typedef enum
{
    RIG_CURRENT,
    RIG_SUPPLY,
    RIG_TEMPERATURE,
    RIG_MEASURED
} rig_measured_t;

typedef struct
{
    channel_config_t channel;
    double           per_unit, zero; ///< the quantity is per_unit (reading - zero) in A, V or degC
} rig_measure_t;

typedef struct
{
    char             scenario[RIG_PATH_MAX + 1]; ///< relative to the folder of the configuration
    channel_config_t sensor;
    double           sensor_low, sensor_high; ///< limits of the sensor's range; equal: no range
    rig_measure_t    measured[RIG_MEASURED];
    counter_config_t position;
    int              output; ///< a rig_output_t
    pwm_config_t     pwm;
    channel_config_t dac;
    double           dac_low, dac_high;
    line_config_t    lines[LINE_COUNT];
    uint64_t         priority;
    double           cpu;      ///< -1: any CPU
    int              required; ///< 0 or 1
    uint64_t         catch_up_ms;
    uint64_t         heartbeat_ms;
    uint64_t         heartbeat_ticks;
    int              read_back; ///< 0 or 1
    uint64_t         ready_off_ms;
    char             watchdog[RIG_PATH_MAX + 1]; ///< see rig_watchdog
    uint64_t         watchdog_s;
    bus_config_t     bus;
    char             store[RIG_PATH_MAX + 1]; ///< relative to the folder of the configuration; empty: no store
    double           drive_values[DRIVE_CONFIG_COUNT];

    drive_config_t drive; ///< made from drive_values
} rig_t;

/// Reads and checks `path`; a desk needs no devices and lines. Returns false with file, line, key, value and range in `error`.
/// `sources` records where each key was written.
bool rig_load(rig_t *rig, const char *path, bool at_desk, common_sources_t *sources, common_error_t *error);

bool rig_has_sensor(const rig_t *rig);

/// Returns the watchdog's device; null if there is none.
const char *rig_watchdog(const rig_t *rig);

/// Reports an error at a key, or in the file as a whole: "FILE:LINE: " and the text. Always returns false.
bool rig_complain(const common_sources_t *sources,
                  const char             *path,
                  const char             *key,
                  const char             *what,
                  common_error_t         *error);

/// Prints the table of keys in Markdown.
void rig_print_keys(void);

#endif
