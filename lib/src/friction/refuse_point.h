// How the inits of both arithmetics refuse a point of the breakaway table.

#ifndef TRIBO_FRICTION_REFUSE_POINT_H
#define TRIBO_FRICTION_REFUSE_POINT_H

#include "tribo/friction_f32.h"

#include "../number/ranges.h"

/// Ranges of a point's numbers, force_n to negative_n.
extern const tribo_parameter_t tribo_point_numbers[3];

/// Refuses a number of point `index`: the one that `status`, TRIBO_ERR_TABLE_FORCE to TRIBO_ERR_TABLE_NEGATIVE, names.
static inline tribo_status_t friction_refuse_point(tribo_status_t                     status,
                                                   const tribo_friction_f32_config_t *config,
                                                   uint32_t                           index)
{
    const uint32_t number = (uint32_t)status - (uint32_t)TRIBO_ERR_TABLE_FORCE;
    return tribo_element_refuse(status, tribo_point_numbers, number, &config->table[index], index, config->refusal);
}

#endif
