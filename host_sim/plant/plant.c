#include "plant/plant.h"

#include "plant/zoh.h"

#include <stdlib.h>
#include <string.h>

struct sim_plant
{
    const sim_truth_ops_t *ops;
    void                  *truth;
    sim_drive_error_t      drive_error;
    double                 stiffness_n_per_deg;
    double                 actuator_part, sensor_part;

    // A step changes all members from here on.
    double u_a_n, force_n, filtered_n;
    double past_force_n; ///< F one step ago
};

enum
{
    PARTS = 1 + SIM_TRUTH_PARTS
};

static void parts_of(const sim_plant_t *plant, sim_truth_part_t parts[PARTS])
{
    const size_t start = offsetof(struct sim_plant, u_a_n);
    parts[0]           = (sim_truth_part_t){(char *)plant + start, sizeof *plant - start};
    plant->ops->parts(plant->truth, &parts[1]);
}

size_t sim_plant_size(const sim_plant_t *plant)
{
    sim_truth_part_t parts[PARTS];
    size_t           size = 0;
    parts_of(plant, parts);
    for (int i = 0; i < PARTS; i++)
    {
        size += parts[i].size;
    }
    return size;
}

void sim_plant_save(const sim_plant_t *plant, void *bytes)
{
    sim_truth_part_t parts[PARTS];
    char            *to = bytes;
    parts_of(plant, parts);
    for (int i = 0; i < PARTS; i++)
    {
        memcpy(to, parts[i].at, parts[i].size);
        to += parts[i].size;
    }
}

void sim_plant_load(sim_plant_t *plant, const void *bytes)
{
    sim_truth_part_t parts[PARTS];
    const char      *from = bytes;
    parts_of(plant, parts);
    for (int i = 0; i < PARTS; i++)
    {
        memcpy(parts[i].at, from, parts[i].size);
        from += parts[i].size;
    }
}

sim_plant_t *sim_plant_create(const sim_plant_config_t *config, const sim_truth_ops_t *truth)
{
    sim_plant_t *plant = calloc(1, sizeof *plant);
    if (plant == NULL)
    {
        return NULL;
    }
    plant->ops                 = truth;
    plant->truth               = truth->create(&config->truth, config->step_s);
    plant->drive_error         = config->drive_error;
    plant->stiffness_n_per_deg = config->truth.arm.stiffness;
    plant->actuator_part       = sim_zoh_first_order(config->actuator_pole_rad_per_s, config->step_s);
    plant->sensor_part         = sim_zoh_first_order(config->sensor_pole_rad_per_s, config->step_s);
    if (plant->truth == NULL)
    {
        free(plant);
        return NULL;
    }
    return plant;
}

void sim_plant_destroy(sim_plant_t *plant)
{
    if (plant != NULL)
    {
        plant->ops->destroy(plant->truth);
        free(plant);
    }
}

/// Returns the ripple in the middle of the step, because the value at its start would feed energy into an oscillation.
static double ripple(const sim_plant_t *plant)
{
    if (plant->drive_error.ripple_n == 0.0)
    {
        return 0.0; // saves a division a step for most plants
    }
    const double middle = (1.5 * plant->force_n - 0.5 * plant->past_force_n) / plant->stiffness_n_per_deg;
    return sim_drive_error_ripple(&plant->drive_error, middle).force_n;
}

void sim_plant_step(sim_plant_t *plant, double u_n, sim_plant_signals_t *signals)
{
    plant->u_a_n += plant->actuator_part * (sim_drive_error_command(&plant->drive_error, u_n) - plant->u_a_n);
    signals->u_a_n      = plant->u_a_n + ripple(plant);
    plant->past_force_n = plant->force_n;
    plant->force_n      = plant->ops->step(plant->truth, signals->u_a_n, &signals->truth);
    plant->filtered_n += plant->sensor_part * (plant->force_n - plant->filtered_n);
}

double sim_plant_force(const sim_plant_t *plant)
{
    return plant->force_n;
}

double sim_plant_filtered_force(const sim_plant_t *plant)
{
    return plant->filtered_n;
}
