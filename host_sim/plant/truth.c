#include "plant/truth.h"

#include <string.h>

#define ADDRESS_OF(name) &sim_##name##_truth,

const sim_truth_ops_t *const sim_truth_models[SIM_TRUTH_COUNT] = {SIM_TRUTH_MODELS(ADDRESS_OF)};

const sim_truth_ops_t *sim_truth_find(const char *name)
{
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        if (strcmp(sim_truth_models[i]->name, name) == 0)
        {
            return sim_truth_models[i];
        }
    }
    return NULL;
}

size_t sim_truth_key_count(const sim_truth_ops_t *truth)
{
    size_t count = 0;
    while (truth->keys != NULL && truth->keys[count].name != NULL)
    {
        count++;
    }
    return count;
}

void sim_truth_numbers(const sim_truth_ops_t *truth, const double *own, double numbers[])
{
    const size_t count = sim_truth_key_count(truth);
    for (size_t i = 0; i < count; i++)
    {
        numbers[i] = own != NULL ? own[i] : truth->keys[i].standard;
    }
}
