// The paper's plant and a force loop, run tick by tick so that a test can act in between.

#ifndef TESTS_CLOSED_LOOP_RIG_H
#define TESTS_CLOSED_LOOP_RIG_H

#include "plant/plant.h"
#include "scenario/config.h"
#include ARITH_HEADER

#define RIG_STEPS_A_TICK 10 // of 0.1 ms

typedef struct
{
    common_scenario_t *scenario; // for the plant's defaults
    sim_plant_config_t plant_config;
    sim_plant_t       *plant;
    loop_t             loop;
    loop_seen_t        seen;
} rig_t;

/// Plant and loop at rest; the loop with `config`.
void rig_open(rig_t *rig, const tribo_force_loop_f32_config_t *config);
void rig_close(rig_t *rig);

/// The sensor's present reading, in N.
double rig_sensor(const rig_t *rig);

/// The present end-point force F, in N.
double rig_force(const rig_t *rig);

/// One tick of 1 ms: the loop gets `y`, the plant gets u. `params` are rig->loop's or another loop's. Returns u.
double rig_tick(rig_t *rig, const loop_t *params, double r, double y);

/// The benchmark's reference: 0.4 to 0.6 N, period 20 s, from its low end.
double rig_triangle(int tick);

#endif
