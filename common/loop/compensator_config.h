/// Converts the compensator's values to the library's configuration.

#ifndef COMMON_COMPENSATOR_CONFIG_H
#define COMMON_COMPENSATOR_CONFIG_H

#include "loop/loop_keys.h"
#include "tribo/friction_f32.h"

/// Copies a parameter from the keys, in double precision, to the library's configuration, in single precision.
#define COMMON_FILL(group, symbol, member, ...) to->member = (float)from->member;

static inline void common_friction_config_fill(tribo_friction_f32_config_t    *to,
                                               tribo_breakaway_point_f32_t     table[TRIBO_BREAKAWAY_POINTS_MAX],
                                               const common_friction_config_t *from)
{
    const common_breakaway_config_t *breakaway = &from->breakaway;
    TRIBO_FRICTION_PARAMETERS(COMMON_FILL)
    to->positive = (tribo_breakaway_f32_t){.offset_n = (float)breakaway->offset_n, .slope = (float)breakaway->slope};
    to->negative = (tribo_breakaway_f32_t){.offset_n = (float)common_breakaway_negative_offset(breakaway),
                                           .slope    = (float)common_breakaway_negative_slope(breakaway)};
    to->table    = (breakaway->table_count > 0) ? table : NULL;
    to->table_length = breakaway->table_count;
    for (unsigned i = 0; i < breakaway->table_count && i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        const common_breakaway_point_t *point = &breakaway->table[i];
        table[i]                              = (tribo_breakaway_point_f32_t){.force_n    = (float)point->force_n,
                                                                              .positive_n = (float)point->positive_n,
                                                                              .negative_n = (float)point->negative_n};
    }
}

static inline void common_arm_config_fill(tribo_arm_f32_config_t *to, const common_arm_config_t *from)
{
    TRIBO_ARM_PARAMETERS(COMMON_FILL)
}

#endif
