#include "rig.h"

#include "plant/truth.h"
#include "unity.h"

#include <math.h>

void rig_open(rig_t *rig, const tribo_force_loop_f32_config_t *config)
{
    rig->scenario = sim_scenario_create();
    TEST_ASSERT_NOT_NULL(rig->scenario);
    const sim_config_t *defaults = sim_scenario_config(rig->scenario);
    rig->plant_config            = (sim_plant_config_t){.step_s                  = 1e-3 / RIG_STEPS_A_TICK,
                                                        .actuator_pole_rad_per_s = defaults->plant.actuator_pole_rad_per_s,
                                                        .sensor_pole_rad_per_s   = defaults->sensor.pole_rad_per_s,
                                                        .truth                   = {.friction = defaults->plant.friction,
                                                                                    .arm      = defaults->plant.arm,
                                                                                    .own      = defaults->plant.own[SIM_TRUTH_paper]}};
    rig->plant                   = sim_plant_create(&rig->plant_config, &sim_paper_truth);
    TEST_ASSERT_NOT_NULL(rig->plant);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&rig->loop, config));
}

void rig_close(rig_t *rig)
{
    sim_plant_destroy(rig->plant);
    common_scenario_destroy(rig->scenario);
}

double rig_sensor(const rig_t *rig)
{
    return sim_plant_filtered_force(rig->plant);
}

double rig_force(const rig_t *rig)
{
    return sim_plant_force(rig->plant);
}

double rig_tick(rig_t *rig, const loop_t *params, double r, double y)
{
    sim_plant_signals_t unused;
    rig->seen = loop_step_by(&rig->loop, params, r, y);
    for (int i = 0; i < RIG_STEPS_A_TICK; i++)
    {
        sim_plant_step(rig->plant, rig->seen.u, &unused);
    }
    return rig->seen.u;
}

double rig_triangle(int tick)
{
    const double phase = fmod(tick * 1e-3, 20.0);
    return 0.4 + 0.02 * (phase < 10.0 ? phase : 20.0 - phase);
}
