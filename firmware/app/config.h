/// The configuration of a drive for its rig and its board: bounds of the faults, scaling of sensor and command, clock.
/// It is constant from drive_init on. The list below is the only place that knows the fields: each is one line with its unit,
/// range, default and meaning.
///
/// Scaling, with sensor and command in the units of the port, e.g. codes of a converter:
///
///     y       =  sensor_n_per_unit (reading - sensor_zero_units)        with the sign of sensor_reversed
///     output  =  command_zero_units + u / command_n_per_unit            with the sign of command_reversed

#ifndef DRIVE_CONFIG_H
#define DRIVE_CONFIG_H

#include <stdbool.h>
#include <stdint.h>

/// FIELD(type, name, unit, low, high, off, default, change, text): `off` is 1 if 0 is allowed as well and turns the field's
/// check off. The type is uint32_t or float; in a flag 1 means yes. `change` is PROTECTS if the field changes only at rest
/// and once unlocked, or WIRED if the image fixes it. The order of the fields gives their registers: append new ones.
// clang-format off: one row a field
#define DRIVE_CONFIG_FIELDS(FIELD) \
    FIELD(uint32_t, period_us, "us", 10, 100000, 0, 1000, PROTECTS, "time from tick to tick") \
    FIELD(uint32_t, late_us, "us", 0, 100000, 0, 50, PROTECTS, "jitter allowed, below period_us") \
    FIELD(uint32_t, budget_us, "us", 1, 100000, 0, 250, PROTECTS, "time allowed to a tick, from its start to its command") \
    FIELD(uint32_t, stuck_ticks, "ticks", 1, 1000000, 1, 0, PROTECTS, "after so many equal readings the sensor counts as dead") \
    FIELD(float, residual_n, "N", 1e-6f, 1e6f, 1, 0.11f, PROTECTS, "fault if y differs from the y that u leads to by more than this, at y = 0 ...") \
    FIELD(uint32_t, residual_ms, "ms", 1, 10000, 0, 50, PROTECTS, "... for longer than this: sensor, motor or contact are wrong") \
    FIELD(uint32_t, command_limit_ms, "ms", 1, 600000, 1, 500, PROTECTS, "fault if u stays at a limit for longer than this") \
    FIELD(uint32_t, reference_ms, "ms", 1, 600000, 1, 250, PROTECTS, "in RUN, fault or ramp if the host does not renew its reference for longer than this") \
    FIELD(uint32_t, ready_ms, "ms", 1, 10000, 1, 0, PROTECTS, "time allowed to the power stage to become ready after it is enabled; 0: it has no ready output") \
    FIELD(uint32_t, ready_level, "", 0, 1, 0, 1, WIRED, "level of the power stage's ready output when it is ready: 1 is high") \
    FIELD(uint32_t, fault_level, "", 0, 1, 0, 1, WIRED, "level of the power stage's fault output in a fault: 1 is high") \
    FIELD(float, full_scale_n, "N", 1e-6f, 1e6f, 0, 4.0f, PROTECTS, "force of 2^31 in Q31, equal to that of the loop's params; f32 does not read it") \
    FIELD(float, sensor_n_per_unit, "N", 1e-12f, 1e6f, 0, 1.0f, PROTECTS, "force of one unit of the sensor") \
    FIELD(float, sensor_zero_units, "", -1e6f, 1e6f, 0, 0.0f, PROTECTS, "reading at 0 N; a tare moves it") \
    FIELD(uint32_t, sensor_reversed, "", 0, 1, 0, 0, WIRED, "1: the reading falls as the force rises") \
    FIELD(float, tare_max_n, "N", 1e-6f, 1e6f, 1, 0.0f, PROTECTS, "largest force that a tare accepts as 0 N; 0: no tare") \
    FIELD(float, command_n_per_unit, "N", 1e-12f, 1e6f, 0, 1.0f, PROTECTS, "force of one unit of the output") \
    FIELD(float, command_zero_units, "", -1e6f, 1e6f, 0, 0.0f, PROTECTS, "output at no current") \
    FIELD(uint32_t, command_reversed, "", 0, 1, 0, 0, WIRED, "1: the output falls as u rises") \
    FIELD(float, command_n_per_a, "N/A", 1e-6f, 1e6f, 0, 1.0f, PROTECTS, "force of one ampere of motor current") \
    FIELD(float, current_max_a, "A", 1e-6f, 1e6f, 1, 0.0f, PROTECTS, "largest current that u may request") \
    FIELD(uint32_t, crystal_hz, "Hz", 4000000, 26000000, 0, 8000000, WIRED, "frequency of the board's crystal") \
    FIELD(uint32_t, degraded_clock, "", 0, 1, 0, 0, WIRED, "1: the drive may run from the internal oscillator") \
    FIELD(uint32_t, bus_unit, "", 1, 247, 0, 1, PROTECTS, "address of the drive on the bus; its master loses it when the address changes") \
    FIELD(float, reference_ramp_n_per_s, "N/s", 0.0f, 1e6f, 0, 0.0f, PROTECTS, "rate at which r goes to safe_reference_n after reference_ms; 0: a fault instead") \
    FIELD(float, safe_reference_n, "N", -1e6f, 1e6f, 0, 0.0f, PROTECTS, "where r goes without a host, within input_max_N") \
    FIELD(float, over_current_a, "A", 1e-3f, 1e6f, 1, 0.0f, PROTECTS, "fault if the measured motor current exceeds this ...") \
    FIELD(uint32_t, over_current_ms, "ms", 1, 10000, 0, 5, PROTECTS, "... for longer than this") \
    FIELD(float, bus_low_v, "V", 1e-3f, 1e6f, 1, 0.0f, PROTECTS, "fault if the measured voltage of the power stage's supply is below this ...") \
    FIELD(float, bus_high_v, "V", 1e-3f, 1e6f, 1, 0.0f, PROTECTS, "... or above this ...") \
    FIELD(uint32_t, bus_voltage_ms, "ms", 1, 10000, 0, 10, PROTECTS, "... for longer than this") \
    FIELD(float, temperature_max_c, "degC", 1e-3f, 1000.0f, 1, 0.0f, PROTECTS, "fault if the measured temperature exceeds this ...") \
    FIELD(uint32_t, temperature_ms, "ms", 1, 600000, 0, 1000, PROTECTS, "... for longer than this") \
    FIELD(float, residual_slope, "N/N", 0.0f, 10.0f, 0, 0.45f, PROTECTS, "increase of the bound residual_n with |y|") \
    FIELD(float, actuator_pole_rad_per_s, "rad/s", 1e-3f, 1e6f, 0, 200.0f, PROTECTS, "pole from the output to the force on the arm") \
    FIELD(float, sensor_pole_rad_per_s, "rad/s", 1e-3f, 1e6f, 0, 55.0f, PROTECTS, "pole from the contact's force to y") \
    FIELD(float, tracking_n, "N", 1e-6f, 1e6f, 1, 0.3f, PROTECTS, "fault if |r - y| exceeds this ...") \
    FIELD(uint32_t, tracking_ms, "ms", 1, 600000, 0, 1000, PROTECTS, "... for longer than this") \
    FIELD(float, speed_max_units_per_s, "1/s", 1e-6f, 1e9f, 1, 0.0f, PROTECTS, "fault if the arm is faster, on a port that measures its position") \
    FIELD(uint32_t, speed_ms, "ms", 1, 10000, 0, 20, PROTECTS, "time over which the speed is measured") \
    FIELD(uint32_t, debounce_n, "ticks", 1, 32, 0, 1, PROTECTS, "a bad reading is a fault once this many ticks had one ...") \
    FIELD(uint32_t, debounce_m, "ticks", 1, 32, 0, 1, PROTECTS, "... of the last this many; until then y keeps its last good value") \
    FIELD(float, motor_resistance_ohm, "Ohm", 1e-3f, 1e3f, 0, 2.0f, PROTECTS, "the winding's, on a board that is the bridge itself") \
    FIELD(float, motor_inductance_h, "H", 1e-6f, 10.0f, 0, 1e-3f, PROTECTS, "the winding's, on a board that is the bridge itself") \
    FIELD(float, current_bandwidth_hz, "Hz", 10.0f, 2100.0f, 0, 1250.0f, PROTECTS, "bandwidth of such a board's current loop") \
    FIELD(float, bridge_trip_a, "A", 1e-3f, 1e3f, 0, 3.0f, PROTECTS, "such a board's bridge turns off within two periods of a current beyond this") \
    FIELD(uint32_t, dead_time_ns, "ns", 50, 6000, 0, 500, PROTECTS, "time from turning one switch of a leg off to turning the other one on") \
    FIELD(uint32_t, motion_units, "", 0, 1000000, 0, 0, PROTECTS, "least travel of the position that is surely a reversal: without a force sensor, friction opposes this motion and is learned from it; 0: r gives the direction") \
    FIELD(uint32_t, motion_reversed, "", 0, 1, 0, 0, WIRED, "1: the position falls as u rises") \
    FIELD(uint32_t, swing_ms, "ms", 1, 10000, 1, 1000, PROTECTS, "fault if y or u keep swinging though r does not; firmware/README.md says which swings count")
// clang-format on

typedef struct
{
#define DRIVE_CONFIG_MEMBER(type, name, unit, low, high, off, normal, change, text) type name; ///< see the list
    DRIVE_CONFIG_FIELDS(DRIVE_CONFIG_MEMBER)
#undef DRIVE_CONFIG_MEMBER
} drive_config_t;

enum
{
    DRIVE_PROTECTS,
    DRIVE_WIRED
};

/// A row of the list, in the order of drive_config_t, whose members are 32-bit words.
typedef struct
{
    float low, high;
    bool  is_float, off, wired;
} drive_config_field_t;

enum
{
#define DRIVE_CONFIG_PLACE(type, name, unit, low, high, off, normal, change, text) DRIVE_CONFIG_##name,
    DRIVE_CONFIG_FIELDS(DRIVE_CONFIG_PLACE)
#undef DRIVE_CONFIG_PLACE
        DRIVE_CONFIG_COUNT
};

extern const drive_config_field_t drive_config_fields[DRIVE_CONFIG_COUNT];

/// Returns the name of a field, "" if there is no such field. An image that does not call this holds no names.
const char *drive_config_name(unsigned field);

/// Returns the value of a field.
float drive_config_value(const drive_config_t *config, unsigned field);

/// Returns the default of every field.
drive_config_t drive_config_default(void);

/// Why a config is refused: a field, its value and its allowed range, which may depend on another field.
typedef struct
{
    unsigned field; ///< DRIVE_CONFIG_<name>
    float    value, low, high;
    bool     off; ///< 0 is allowed as well
} drive_config_error_t;

/// Checks every field, then fields against each other. Returns false and fills `error` for the first field that is out of range
/// or NaN. Reads nothing but `config`, so that it also checks a config that has not been staged yet.
bool drive_config_check(const drive_config_t *config, drive_config_error_t *error);

#endif
