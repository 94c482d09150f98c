#include "ranges.h"

#include "ieee_f32.h"

static float number_at(const tribo_parameter_t *row, const void *config)
{
    const void *const member = (const unsigned char *)config + row->at;
    return row->is_whole != 0u ? (float)*(const uint32_t *)member : *(const float *)member;
}

/// Index of the first of `count` rows whose member is out of its range, `count` if all are inside.
static uint32_t first_outside(const tribo_parameter_t *rows, uint32_t count, const void *config)
{
    uint32_t i = 0;
    while (i < count && within(number_at(&rows[i], config), rows[i].low, rows[i].high))
    {
        i++;
    }
    return i;
}

tribo_status_t tribo_parameters_check(const tribo_parameter_t *rows, uint32_t count, const void *config)
{
    const uint32_t i = first_outside(rows, count, config);
    return i < count ? (tribo_status_t)rows[i].status : TRIBO_OK;
}

tribo_status_t tribo_element_refuse(tribo_status_t           status,
                                    const tribo_parameter_t *rows,
                                    uint32_t                 member,
                                    const void              *element,
                                    uint32_t                 index,
                                    tribo_refusal_t         *refusal)
{
    if (refusal != NULL)
    {
        const tribo_parameter_t *const row = &rows[member];
        *refusal = (tribo_refusal_t){index, member, number_at(row, element), row->low, row->high};
    }
    return status;
}

tribo_status_t tribo_element_check(const tribo_parameter_t *rows,
                                   uint32_t                 count,
                                   const void              *element,
                                   uint32_t                 index,
                                   tribo_refusal_t         *refusal)
{
    const uint32_t i = first_outside(rows, count, element);
    return i < count ? tribo_element_refuse((tribo_status_t)rows[i].status, rows, i, element, index, refusal)
                     : TRIBO_OK;
}
