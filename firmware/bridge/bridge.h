/// A bridge that the board drives itself, without its hardware registers: when its outputs may be on, what current flows,
/// and in which share of a period each leg is high.
///
///     OFF --wanted--> CALIBRATING --BRIDGE_OFFSET_SAMPLES--> ON
///      ^                   |                                 |
///      '-- not wanted, or tripped: until it has been not wanted
///
/// The outputs are on only in ON. CALIBRATING takes the mean code of the current's converter as 0 A.
///
/// A trip turns the bridge off within the sample that finds it, see bridge_trip_t. The drive has narrower bounds for longer
/// times on bus voltage and temperature (app/faults.h).
///
/// The converter's interrupt calls bridge_step once a period. The tick calls the other functions. It does not interrupt
/// bridge_step, and each shared word is written by only one of the two.
///
/// **FOC.** A law turns a reference into duties. bridge_brushed is built in. A law for three legs is a function of the same
/// kind that knows its rotor's angle; stage_init of a port names it.

#ifndef BRIDGE_BRIDGE_H
#define BRIDGE_BRIDGE_H

#include "bridge/current.h"

#include <stdbool.h>
#include <stdint.h>

#define BRIDGE_HZ             20000u
#define BRIDGE_LEGS           3u ///< the third is for a three-phase motor
#define BRIDGE_CURRENTS       2u ///< the second is for a three-phase motor
#define BRIDGE_OFFSET_SAMPLES 256u
#define BRIDGE_OFFSET_MOST    100u ///< largest distance of 0 A from the middle, in codes
#define BRIDGE_SPREAD_MOST                                                                                             \
    40u ///< codes from the lowest to the highest while calibrating; more is not noise but a current
#define BRIDGE_RAIL          100u  ///< codes: a broken wire reads this close to a rail
#define BRIDGE_CODES         4096u ///< codes of the converters
#define BRIDGE_MIDDLE        2048u ///< code of 0 A, except for the offset
#define BRIDGE_SAMPLES       2u    ///< so many samples in a row beyond a level cause a trip ...
#define BRIDGE_RISE          4u    ///< ... and so does more than one sample in five
#define BRIDGE_STALE_SAMPLES 60u   ///< after so many samples without a command, 3 ms, the tick hangs
#define BRIDGE_DUTY_MOST     0.95f ///< largest share of the bus; keeps the low sides on for the gate drivers' bootstraps
#define BRIDGE_SIGN_A        0.1f  ///< current from which on its sign is certain
#define BRIDGE_BUS_LEAST_V   1.0f  ///< below it a duty means nothing

typedef enum
{
    BRIDGE_OFF,
    BRIDGE_CALIBRATING,
    BRIDGE_ON
} bridge_state_t;

/// Why the bridge turned itself off.
typedef enum
{
    BRIDGE_TRIP_NONE,
    BRIDGE_TRIP_CURRENT, ///< the current of a phase is beyond trip_a
    BRIDGE_TRIP_BUS,     ///< the bus voltage is beyond trip_v
    BRIDGE_TRIP_SENSOR,  ///< a current's converter is at a rail; also while the bridge is off
    BRIDGE_TRIP_OFFSET,  ///< the reading at 0 A cannot be that of 0 A
    BRIDGE_TRIP_STALE,   ///< no command for BRIDGE_STALE_SAMPLES
    BRIDGE_TRIP_BREAK    ///< the timer's break input turned its outputs off
} bridge_trip_t;

/// Codes of one period.
typedef struct
{
    uint32_t current[BRIDGE_CURRENTS], bus;
} bridge_sample_t;

/// Measurements of one period, in units.
typedef struct
{
    float current_a[BRIDGE_CURRENTS], bus_v;
} bridge_measured_t;

/// Shares of a period in which each leg is high, 0 to 1.
typedef struct
{
    float leg[BRIDGE_LEGS];
} bridge_duty_t;

/// A law, called once a period in ON. `context` belongs to the law.
typedef void (*bridge_law_t)(void *context, float reference_a, const bridge_measured_t *measured, bridge_duty_t *duty);

typedef struct
{
    float        a_per_code, v_per_code;
    float        trip_a, trip_v;
    uint32_t     currents; ///< number of measured currents: 1, or 2 for a motor with three phases
    bridge_law_t law;
    void        *context;
    void (*begin)(void *context); ///< resets the law as the bridge turns on
} bridge_params_t;

typedef struct
{
    bridge_params_t params;

    // The tick writes these.
    volatile bool     is_wanted;
    volatile float    reference_a;
    volatile uint32_t age; ///< samples since the last command; bridge_step counts it up

    // bridge_step writes these.
    volatile bridge_state_t state;
    volatile bridge_trip_t  cause; ///< cause of the last trip
    volatile uint8_t        trips;
    bool                    must_rest; ///< the bridge stays off until it was not wanted once
    uint32_t                rails, beyond, high_bus, count;
    uint32_t                sum[BRIDGE_CURRENTS], low[BRIDGE_CURRENTS], high[BRIDGE_CURRENTS];
    float                   zero[BRIDGE_CURRENTS]; ///< codes at 0 A
    bridge_measured_t       measured;

    uint8_t trips_seen; ///< trips that the tick has seen
} bridge_t;

void bridge_init(bridge_t *bridge, const bridge_params_t *params);

/// Runs one period and writes the duties to apply; all legs have the same unless the bridge is on. Returns true if the
/// outputs may be on. `are_on` says whether they are on.
bool bridge_step(bridge_t *bridge, const bridge_sample_t *sample, bool are_on, bridge_duty_t *duty);

// The tick calls these.

void bridge_want(bridge_t *bridge, bool on);
void bridge_command(bridge_t *bridge, float reference_a);

/// Returns the cause of a trip, once for each trip.
bridge_trip_t bridge_take_trip(bridge_t *bridge);

/// The law of a motor with one winding, between legs 0 and 1, with the current into leg 0's terminal as current 0.
typedef struct
{
    current_params_t params;
    current_state_t  state;
    float            dead_share; ///< share of a period that a leg spends in dead time, bridge_dead_share
} bridge_brushed_t;

/// Returns the share of its voltage that a leg loses against its current in both edges of a period.
float bridge_dead_share(uint32_t dead_time_ns);

void bridge_brushed(void *context, float reference_a, const bridge_measured_t *measured, bridge_duty_t *duty);
void bridge_brushed_begin(void *context);

#endif
