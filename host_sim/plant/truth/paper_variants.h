/// The paper's model without some of its parts: the five steps of its section 3 and the lines of Figs. 2 to 8.

#ifndef SIM_PAPER_VARIANTS_H
#define SIM_PAPER_VARIANTS_H

#include "plant/truth.h"

/// When the gradual curve of Eq. (3) holds instead of f = n.
typedef enum
{
    SIM_PAPER_CURVE_NEVER,
    SIM_PAPER_CURVE_ALWAYS,
    SIM_PAPER_CURVE_RISING, ///< while v > 0, without relays
    SIM_PAPER_CURVE_RELAYS  ///< Eq. (8)
} sim_paper_curve_t;

/// The parameters of sim_paper_truth in addition to those of common_friction_config_t.
typedef struct
{
    int               limited; ///< 1: f is limited to -L to L; 0: it is not
    sim_paper_curve_t curve;
} sim_paper_parameters_t;

typedef struct
{
    const char            *name;
    const char            *text; ///< its place in the paper
    double                 k_min, k_max;
    sim_paper_parameters_t parameters;
} sim_paper_variant_t;

extern const sim_paper_variant_t sim_paper_variants[];
extern const size_t              sim_paper_variant_count;

/// Returns the variant of this name; null if there is none.
const sim_paper_variant_t *sim_paper_variant_find(const char *name);

/// Changes a config for sim_paper_truth to this variant, which must outlive it.
void sim_paper_variant_apply(const sim_paper_variant_t *variant, sim_truth_config_t *config);

#endif
