#include "plant/truth/law.h"

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
    double       numbers[SIM_TRUTH_KEYS_MAX];
    const size_t count = sim_truth_key_count(truth);
    sim_truth_numbers(truth, config->own, numbers);
    memcpy(parameters, numbers, count * sizeof numbers[0]);
}
