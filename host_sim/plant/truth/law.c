#include "plant/truth/law.h"

#include "plant/truths.h"

#include <math.h>
#include <string.h>

double sim_law_breakaway(const sim_contact_t *contact, double sign)
{
    return signbit(sign) ? contact->breakaway.negative_n : contact->breakaway.positive_n;
}

double sim_law_limit(const sim_contact_t *contact, double x)
{
    return fmin(contact->breakaway.positive_n, fmax(-contact->breakaway.negative_n, x));
}

void sim_law_parameters(const sim_truth_ops_t *truth, const sim_truth_config_t *config, void *parameters)
{
    sim_truth_parameters_default(truth, parameters);
    if (config->friction.parameters != NULL)
    {
        memcpy(parameters, config->friction.parameters, truth->parameters_size);
    }
}
