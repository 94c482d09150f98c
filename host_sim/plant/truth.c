#include "plant/truth.h"

#define ADDRESS_OF(name, text) &sim_##name##_truth,

const sim_truth_ops_t *const sim_truth_models[SIM_TRUTH_COUNT] = {SIM_TRUTH_MODELS(ADDRESS_OF)};
