// The list of truth models. A new one is a file in truth/, its test in tests/truth, and a row here.

#include "plant/truths.h"

#include "plant/truth/models.h"

#include <string.h>

const sim_truth_ops_t *const sim_truths[] = {
    &sim_paper_truth,
    &sim_torque_truth,
    &sim_coulomb_truth,
    &sim_karnopp_truth,
    &sim_armstrong_truth,
    &sim_dahl_truth,
    &sim_bristle_truth,
    &sim_reset_integrator_truth,
    &sim_bliman_sorine_truth,
    &sim_lubricated_truth,
    &sim_lugre_truth,
    &sim_elasto_plastic_truth,
    &sim_leuven_truth,
    &sim_maxwell_slip_truth,
    &sim_servo_mx106_truth,
    &sim_servo_mx64_truth,
    &sim_servo_xl330_truth,
    &sim_servo_erob80_truth,
};
const size_t sim_truth_count = sizeof sim_truths / sizeof sim_truths[0];

const sim_truth_ops_t *sim_truth_find(const char *name)
{
    for (size_t i = 0; i < sim_truth_count; i++)
    {
        if (strcmp(sim_truths[i]->name, name) == 0)
        {
            return sim_truths[i];
        }
    }
    return NULL;
}

const sim_truth_parameter_t *sim_truth_parameter_find(const sim_truth_ops_t *truth, const char *name)
{
    for (size_t i = 0; i < truth->parameter_count; i++)
    {
        if (strcmp(truth->parameters[i].name, name) == 0)
        {
            return &truth->parameters[i];
        }
    }
    return NULL;
}

static void write_double(void *parameters, const sim_truth_parameter_t *row, double value)
{
    memcpy((char *)parameters + row->offset, &value, sizeof value);
}

void sim_truth_parameters_default(const sim_truth_ops_t *truth, void *parameters)
{
    for (size_t i = 0; i < truth->parameter_count; i++)
    {
        write_double(parameters, &truth->parameters[i], truth->parameters[i].initial);
    }
}

bool sim_truth_parameter_set(const sim_truth_ops_t *truth, void *parameters, const char *name, double value)
{
    const sim_truth_parameter_t *row = sim_truth_parameter_find(truth, name);
    if (row == NULL || !(value >= row->min && value <= row->max))
    {
        return false;
    }
    write_double(parameters, row, value);
    return true;
}
