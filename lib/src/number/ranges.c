#include "ranges.h"

#include "ieee_f32.h"

static float number_at(const tribo_parameter_t *row, const void *config)
{
    const void *const member = (const unsigned char *)config + row->at;
    return row->is_whole != 0u ? (float)*(const uint32_t *)member : *(const float *)member;
}

tribo_status_t tribo_parameters_check(const tribo_parameter_t *rows, uint32_t count, const void *config)
{
    for (uint32_t i = 0; i < count; i++)
    {
        if (!within(number_at(&rows[i], config), rows[i].low, rows[i].high))
        {
            return (tribo_status_t)rows[i].status;
        }
    }
    return TRIBO_OK;
}
