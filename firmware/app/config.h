/// What a drive is told about its rig and its board: the bounds of its faults, the scaling of sensor and command, its clock.
/// Const from drive_init on. The list of fields below is the only place that knows them: a field is one line with its unit,
/// its range, its default and its meaning.
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
/// check off. The type is uint32_t or float. A 1 in a flag is a yes. `change`: PROTECTS changes at rest only, and once it is unlocked;
/// WIRED is as the image has it. A field's place is its register: a new one goes to the end.
// clang-format off: one row a field
#define DRIVE_CONFIG_FIELDS(FIELD) \
    FIELD(uint32_t, period_us, "us", 10, 100000, 0, 1000, PROTECTS, "of the ticks") \
    FIELD(uint32_t, late_us, "us", 0, 100000, 0, 50, PROTECTS, "jitter allowed, below period_us") \
    FIELD(uint32_t, budget_us, "us", 1, 100000, 0, 250, PROTECTS, "for a tick, from its start to its command") \
    FIELD(uint32_t, stuck_ticks, "ticks", 1, 1000000, 1, 0, PROTECTS, "readings without any change: the sensor is dead") \
    FIELD(float, residual_n, "N", 1e-6f, 1e6f, 1, 0.11f, PROTECTS, "y away from what u leads to by more than this, at y = 0 ...") \
    FIELD(uint32_t, residual_ms, "ms", 1, 10000, 0, 50, PROTECTS, "... for longer: sensor, motor or contact are wrong") \
    FIELD(uint32_t, command_limit_ms, "ms", 1, 600000, 1, 500, PROTECTS, "u at a limit for longer") \
    FIELD(uint32_t, reference_ms, "ms", 1, 600000, 1, 250, PROTECTS, "the host's reference not renewed for longer, in RUN") \
    FIELD(uint32_t, ready_ms, "ms", 1, 10000, 1, 0, PROTECTS, "for the power stage to become ready after it is enabled") \
    FIELD(uint32_t, ready_level, "", 0, 1, 0, 1, WIRED, "of the power stage's ready output when it is ready: 1 is high") \
    FIELD(uint32_t, fault_level, "", 0, 1, 0, 1, WIRED, "of the power stage's fault output in a fault: 1 is high") \
    FIELD(float, full_scale_n, "N", 1e-6f, 1e6f, 0, 4.0f, PROTECTS, "2^31 in Q31, as the loop's params have it; not read in f32") \
    FIELD(float, sensor_n_per_unit, "N", 1e-12f, 1e6f, 0, 1.0f, PROTECTS, "a unit of the sensor") \
    FIELD(float, sensor_zero_units, "", -1e6f, 1e6f, 0, 0.0f, PROTECTS, "reading at 0 N; a tare moves it") \
    FIELD(uint32_t, sensor_reversed, "", 0, 1, 0, 0, WIRED, "the reading falls as the force rises") \
    FIELD(float, tare_max_n, "N", 1e-6f, 1e6f, 1, 0.0f, PROTECTS, "largest force that a tare takes for 0 N; 0: no tare") \
    FIELD(float, command_n_per_unit, "N", 1e-12f, 1e6f, 0, 1.0f, PROTECTS, "a unit of the output") \
    FIELD(float, command_zero_units, "", -1e6f, 1e6f, 0, 0.0f, PROTECTS, "output at no current") \
    FIELD(uint32_t, command_reversed, "", 0, 1, 0, 0, WIRED, "the output falls as u rises") \
    FIELD(float, command_n_per_a, "N/A", 1e-6f, 1e6f, 0, 1.0f, PROTECTS, "force of an ampere of motor current") \
    FIELD(float, current_max_a, "A", 1e-6f, 1e6f, 1, 0.0f, PROTECTS, "largest current that u may ask for") \
    FIELD(uint32_t, crystal_hz, "Hz", 4000000, 26000000, 0, 8000000, WIRED, "of the board's crystal") \
    FIELD(uint32_t, degraded_clock, "", 0, 1, 0, 0, WIRED, "the drive may run from the internal oscillator") \
    FIELD(uint32_t, bus_unit, "", 1, 247, 0, 1, PROTECTS, "address on the bus; with another one the master has lost the drive") \
    FIELD(float, reference_ramp_n_per_s, "N/s", 0.0f, 1e6f, 0, 0.0f, PROTECTS, "after reference_ms r goes to safe_reference_n that fast; 0: a fault") \
    FIELD(float, safe_reference_n, "N", -1e6f, 1e6f, 0, 0.0f, PROTECTS, "where r goes without a host, within input_max_N") \
    FIELD(float, over_current_a, "A", 1e-3f, 1e6f, 1, 0.0f, PROTECTS, "measured motor current beyond this ...") \
    FIELD(uint32_t, over_current_ms, "ms", 1, 10000, 0, 5, PROTECTS, "... for longer") \
    FIELD(float, bus_low_v, "V", 1e-3f, 1e6f, 1, 0.0f, PROTECTS, "measured voltage of the power stage's supply below this ...") \
    FIELD(float, bus_high_v, "V", 1e-3f, 1e6f, 1, 0.0f, PROTECTS, "... or above this ...") \
    FIELD(uint32_t, bus_voltage_ms, "ms", 1, 10000, 0, 10, PROTECTS, "... for longer") \
    FIELD(float, temperature_max_c, "degC", 1e-3f, 1000.0f, 1, 0.0f, PROTECTS, "measured temperature above this ...") \
    FIELD(uint32_t, temperature_ms, "ms", 1, 600000, 0, 1000, PROTECTS, "... for longer") \
    FIELD(float, residual_slope, "N/N", 0.0f, 10.0f, 0, 0.45f, PROTECTS, "... which grows by so much with |y|") \
    FIELD(float, actuator_pole_rad_per_s, "rad/s", 1e-3f, 1e6f, 0, 200.0f, PROTECTS, "from the output to the force on the arm") \
    FIELD(float, sensor_pole_rad_per_s, "rad/s", 1e-3f, 1e6f, 0, 55.0f, PROTECTS, "from the contact's force to y") \
    FIELD(float, tracking_n, "N", 1e-6f, 1e6f, 1, 0.3f, PROTECTS, "|r - y| beyond this ...") \
    FIELD(uint32_t, tracking_ms, "ms", 1, 600000, 0, 1000, PROTECTS, "... for longer") \
    FIELD(float, speed_max_units_per_s, "1/s", 1e-6f, 1e9f, 1, 0.0f, PROTECTS, "of the arm, where the port has a position") \
    FIELD(uint32_t, speed_ms, "ms", 1, 10000, 0, 20, PROTECTS, "in which the speed is measured") \
    FIELD(uint32_t, debounce_n, "ticks", 1, 32, 0, 1, PROTECTS, "with a bad reading ...") \
    FIELD(uint32_t, debounce_m, "ticks", 1, 32, 0, 1, PROTECTS, "... of these make a fault; until then y stays as it was") \
    FIELD(float, motor_resistance_ohm, "Ohm", 1e-3f, 1e3f, 0, 2.0f, PROTECTS, "of the winding, where the board is the bridge ...") \
    FIELD(float, motor_inductance_h, "H", 1e-6f, 10.0f, 0, 1e-3f, PROTECTS, "... of the winding, too") \
    FIELD(float, current_bandwidth_hz, "Hz", 10.0f, 2100.0f, 0, 1250.0f, PROTECTS, "of its current loop") \
    FIELD(float, bridge_trip_a, "A", 1e-3f, 1e3f, 0, 3.0f, PROTECTS, "its current beyond this turns it off within two periods") \
    FIELD(uint32_t, dead_time_ns, "ns", 50, 6000, 0, 500, PROTECTS, "from one switch of a leg off to the other on") \
    FIELD(uint32_t, motion_units, "", 0, 1000000, 0, 0, PROTECTS, "travel of the position that is surely a reversal: without a force sensor friction opposes it, and is learned; 0: r decides") \
    FIELD(uint32_t, motion_reversed, "", 0, 1, 0, 0, WIRED, "the position falls as u rises") \
    FIELD(uint32_t, swing_ms, "ms", 1, 10000, 1, 1000, PROTECTS, "y or u swings to and fro though r does not: what counts is in firmware/README.md")
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

/// The list as a table, in the order of drive_config_t, whose members are words.
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

/// The name of a field, "" of none. Not in an image that does not call it.
const char *drive_config_name(unsigned field);

/// The value of a field.
float drive_config_value(const drive_config_t *config, unsigned field);

/// The default of every field.
drive_config_t drive_config_default(void);

/// Why a config is refused: a field's value and the range that is allowed, which may depend on another field.
typedef struct
{
    unsigned field; ///< DRIVE_CONFIG_ and its name
    float    value, low, high;
    bool     off; ///< 0 is allowed as well
} drive_config_error_t;

/// Checks every field, then fields against each other. False and `error` for the first that is out of range; a NaN is.
/// Pure: reads nothing else, so that it also checks a config that has not been staged yet.
bool drive_config_check(const drive_config_t *config, drive_config_error_t *error);

#endif
