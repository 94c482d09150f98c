// A loop of the library as a drive has it, on rigs whose numbers have nothing in common with the paper's. The one place that names
// functions of the feed-forward.

#ifndef TESTS_CLOSED_LOOP_FOREIGN_LOOP_H
#define TESTS_CLOSED_LOOP_FOREIGN_LOOP_H

#include "../../wire/tribo_arithmetic.h"
#include "foreign_plant.h"

#include <stdbool.h>
#include <stddef.h>

typedef enum
{
    FOREIGN_NONE,
    FOREIGN_FEEDFORWARD
} foreign_method_t;

/// A rig as its owner believes it, and the range of its force.
typedef struct
{
    const char *name;
    double      sample_time_s;
    double      actuator_pole, sensor_pole;  // rad/s
    double      inertia, damping, stiffness; // of the arm, in any consistent units
    double      offset, slope;               // of L
    double      mean, amplitude;             // of r, N
    bool        paper_controller;
} foreign_rig_t;

#define FOREIGN_RIGS 5
extern const foreign_rig_t foreign_rigs[FOREIGN_RIGS];

typedef struct
{
    TRIBO(force_loop, state_t) state;
    TRIBO(feedforward, memory_t) memory;
} foreign_state_t;

typedef struct
{
    double          full_scale_n;
    foreign_state_t state;
    TRIBO(force_loop, params_t) params;
    TRIBO(feedforward, params_t) feedforward;
    TRIBO(guard, params_t) guard;
} foreign_loop_t;

/// Nothing learned. `noise` is what the owner believes the sensor's to be. State and params point into `loop`.
tribo_status_t foreign_loop_open(foreign_loop_t *loop, const foreign_rig_t *rig, foreign_method_t method, double noise);

double foreign_loop_step(foreign_loop_t *loop, double r, double y);

/// Whether the loop has said that something is wrong: a latched cause, a bound that stays, or a count that rose above `before`'s.
bool foreign_loop_says(const foreign_loop_t *loop, const foreign_state_t *before);

#endif
