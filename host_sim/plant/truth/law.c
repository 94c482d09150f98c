#include "plant/truth/law.h"

#include <math.h>

double sim_law_breakaway(const sim_contact_t *contact, double sign)
{
    return signbit(sign) ? contact->breakaway.negative_n : contact->breakaway.positive_n;
}

double sim_law_limit(const sim_contact_t *contact, double x)
{
    return fmin(contact->breakaway.positive_n, fmax(-contact->breakaway.negative_n, x));
}
