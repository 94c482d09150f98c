#include "plant/zoh.h"

#include "support/elementary.h"

#include <math.h>
#include <string.h>

#define TAYLOR_TERMS 16

static void multiply(const double a[4], const double b[4], double product[4])
{
    const double c[4] = {a[0] * b[0] + a[1] * b[2],
                         a[0] * b[1] + a[1] * b[3],
                         a[2] * b[0] + a[3] * b[2],
                         a[2] * b[1] + a[3] * b[3]};
    memcpy(product, c, sizeof c);
}

void sim_zoh_transition(const double a[4], double step_s, double phi[4])
{
    // Scaling and squaring: if the norm is below 1/2, sixteen terms are exact to the last bit.
    const double norm = step_s * fmax(fabs(a[0]) + fabs(a[1]), fabs(a[2]) + fabs(a[3]));
    int          halvings;
    (void)frexp(norm, &halvings);
    halvings = (halvings < 0) ? 0 : halvings + 1;

    const double scale     = ldexp(step_s, -halvings);
    const double scaled[4] = {a[0] * scale, a[1] * scale, a[2] * scale, a[3] * scale};
    double       term[4]   = {1.0, 0.0, 0.0, 1.0};
    memcpy(phi, term, sizeof term);
    for (int k = 1; k <= TAYLOR_TERMS; k++)
    {
        multiply(term, scaled, term);
        for (int i = 0; i < 4; i++)
        {
            term[i] /= k;
            phi[i] += term[i];
        }
    }
    for (int i = 0; i < halvings; i++)
    {
        multiply(phi, phi, phi);
    }
}

double sim_zoh_first_order(double pole_rad_per_s, double step_s)
{
    return -common_expm1(-pole_rad_per_s * step_s);
}
