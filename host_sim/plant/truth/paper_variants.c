#include "plant/truth/paper_variants.h"

#include <string.h>

const sim_paper_variant_t sim_paper_variants[] = {
    {"unlimited", "step 1 of section 3: f = n", 6.0, 20.0, {0, SIM_PAPER_CURVE_NEVER}},
    {"saturation", "step 2, Eq. (11), Fig. 7 thin", 6.0, 20.0, {1, SIM_PAPER_CURVE_NEVER}},
    {"always_k6", "step 3 with k = 6: always on the curve", 6.0, 6.0, {1, SIM_PAPER_CURVE_ALWAYS}},
    {"constant_k6", "step 4 with k = 6, Fig. 7 dotted", 6.0, 6.0, {1, SIM_PAPER_CURVE_RELAYS}},
    {"constant_k1.1", "step 4 with k = 1.1, Fig. 4(a)", 1.1, 1.1, {1, SIM_PAPER_CURVE_RELAYS}},
    {"no_relays", "k(v), Q = v > 0, Fig. 6 dotted", 6.0, 20.0, {1, SIM_PAPER_CURVE_RISING}},
    {"full", "step 5, Eqs. (3) to (9), solid in Figs. 6 to 8", 6.0, 20.0, {1, SIM_PAPER_CURVE_RELAYS}},
};
const size_t sim_paper_variant_count = sizeof sim_paper_variants / sizeof sim_paper_variants[0];

const sim_paper_variant_t *sim_paper_variant_find(const char *name)
{
    for (size_t i = 0; i < sim_paper_variant_count; i++)
    {
        if (strcmp(sim_paper_variants[i].name, name) == 0)
        {
            return &sim_paper_variants[i];
        }
    }
    return NULL;
}

void sim_paper_variant_apply(const sim_paper_variant_t *variant, sim_truth_config_t *config)
{
    config->friction.k_min = variant->k_min;
    config->friction.k_max = variant->k_max;
    config->own            = &variant->parameters;
}
