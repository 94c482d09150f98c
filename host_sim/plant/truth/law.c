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

void sim_law_reset(const sim_law_t *law, void *friction, const sim_truth_config_t *config, double z[])
{
    memset(friction, 0, law->size);
    if (law->own_size > 0)
    {
        memcpy(friction, config->own, law->own_size);
    }
    if (law->reset != NULL)
    {
        law->reset(friction, config, z);
    }
}
