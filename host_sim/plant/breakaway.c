#include "plant/breakaway.h"

#include <math.h>

double sim_breakaway_negative_offset(const sim_breakaway_config_t *config)
{
    return config->negative_offset_n.is_given ? config->negative_offset_n.value : config->offset_n;
}

double sim_breakaway_negative_slope(const sim_breakaway_config_t *config)
{
    return config->negative_slope.is_given ? config->negative_slope.value : config->slope;
}

/// Linear between the points, clamped at both ends.
static sim_breakaway_t look_up(const sim_breakaway_config_t *config, double force)
{
    const sim_breakaway_point_t *point = config->table;
    const sim_breakaway_point_t *last  = config->table + config->table_count - 1;
    if (force >= last->force_n)
    {
        return (sim_breakaway_t){last->positive_n, last->negative_n};
    }
    if (force <= point->force_n)
    {
        return (sim_breakaway_t){point->positive_n, point->negative_n};
    }
    while (point[1].force_n < force)
    {
        point++;
    }
    const double part = (force - point->force_n) / (point[1].force_n - point->force_n);
    return (sim_breakaway_t){point->positive_n + part * (point[1].positive_n - point->positive_n),
                             point->negative_n + part * (point[1].negative_n - point->negative_n)};
}

sim_breakaway_t sim_breakaway_at(const sim_breakaway_config_t *config, double force_n)
{
    const double force = fabs(force_n);
    if (config->table_count > 0)
    {
        return look_up(config, force);
    }
    return (sim_breakaway_t){config->offset_n + config->slope * force,
                             sim_breakaway_negative_offset(config) + sim_breakaway_negative_slope(config) * force};
}
