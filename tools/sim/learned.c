#include "sim/learned.h"

#include "tribo/feedforward_f32.h"

#include <math.h>

void sim_learned_write(FILE *file, const sim_result_t *result)
{
    const common_breakaway_config_t *breakaway = &result->breakaway;
    const double relative_variance = fmax(result->learned.relative_variance[0], result->learned.relative_variance[1]);
    (void)fprintf(file,
                  "# The breakaway that a run has learned, from %.3g N of travel up and %.3g N down%s.\n"
                  "# For tribo-sim run or params --learned, in place of the scenario's own breakaway.\n"
                  "friction:\n  breakaway:\n",
                  result->learned.travel_n[0],
                  result->learned.travel_n[1],
                  result->learned.at_bound[0] || result->learned.at_bound[1] ? "; AT A BOUND: do not trust it" : "");
    if (breakaway->table_count == 0)
    {
        (void)fprintf(file,
                      "    offset_N: %.9g\n    slope: %.9g\n    negative_offset_N: %.9g\n    negative_slope: %.9g\n",
                      breakaway->offset_n,
                      breakaway->slope,
                      breakaway->negative_offset_n.value,
                      breakaway->negative_slope.value);
    }
    else
    {
        (void)fputs("    table:\n", file);
    }
    for (unsigned i = 0; i < breakaway->table_count; i++)
    {
        (void)fprintf(file,
                      "      - {force_N: %.9g, positive_N: %.9g, negative_N: %.9g}\n",
                      breakaway->table[i].force_n,
                      breakaway->table[i].positive_n,
                      breakaway->table[i].negative_n);
    }
    // Learned values deserve more trust than the default for configured ones.
    const double untrusted = (1.0 - (double)tribo_feedforward_f32_default().trust) * relative_variance;
    (void)fprintf(file, "feedforward:\n  trust: %.6g\n", 1.0 - fmin(1.0, fmax(0.0, untrusted)));
}
