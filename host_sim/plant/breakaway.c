#include "plant/breakaway.h"

sim_breakaway_t sim_breakaway_look_up(const common_breakaway_config_t *config, double force_n)
{
    const common_breakaway_point_t *point = config->table;
    const common_breakaway_point_t *last  = config->table + config->table_count - 1;
    if (force_n >= last->force_n)
    {
        return (sim_breakaway_t){last->positive_n, last->negative_n};
    }
    if (force_n <= point->force_n)
    {
        return (sim_breakaway_t){point->positive_n, point->negative_n};
    }
    while (point[1].force_n < force_n)
    {
        point++;
    }
    const double part = (force_n - point->force_n) / (point[1].force_n - point->force_n);
    return (sim_breakaway_t){point->positive_n + part * (point[1].positive_n - point->positive_n),
                             point->negative_n + part * (point[1].negative_n - point->negative_n)};
}
