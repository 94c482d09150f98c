#include "parameters.h"

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"

#include "ieee_f32.h"

#include <stddef.h>

// clang-format off: one table a line
#define IS_WHOLE(x) _Generic((x), float: 0, uint32_t: 1)
#define ROW(group, symbol, member, key, unit, low_, high_, standard_, change, number_, condition, sentence) \
    {.low = (float)(low_), .high = (float)(high_), .standard = (float)(standard_), .at = offsetof(T, member), .number = (number_), \
     .status = TRIBO_ERR_##symbol, .is_whole = IS_WHOLE(((T *)0)->member), \
     .protects = TRIBO_##change},

#define T tribo_force_loop_f32_config_t
const tribo_parameter_t tribo_loop_parameters[] = {TRIBO_SAMPLE_PARAMETERS(ROW) TRIBO_INPUT_PARAMETERS(ROW) TRIBO_GAIN_PARAMETERS(ROW)};
#undef T
#define T tribo_controller_f32_config_t
const tribo_parameter_t tribo_limit_parameters[]   = {TRIBO_LIMIT_PARAMETERS(ROW)};
const tribo_parameter_t tribo_cascade_parameters[] = {TRIBO_CASCADE_PARAMETERS(ROW)};
#undef T
#define T tribo_friction_f32_config_t
const tribo_parameter_t tribo_friction_parameters[]  = {TRIBO_FRICTION_PARAMETERS(ROW)};
const tribo_parameter_t tribo_breakaway_parameters[] = {TRIBO_BREAKAWAY_PARAMETERS(ROW)};
const tribo_parameter_t tribo_table_parameters[]     = {TRIBO_TABLE_PARAMETERS(ROW)};
#undef T
#define T tribo_arm_f32_config_t
const tribo_parameter_t tribo_arm_parameters[] = {TRIBO_ARM_PARAMETERS(ROW)};
#undef T
#define T tribo_lugre_f32_config_t
const tribo_parameter_t tribo_lugre_parameters[] = {TRIBO_LUGRE_PARAMETERS(ROW)};
#undef T
#define T tribo_feedforward_f32_config_t
const tribo_parameter_t tribo_feedforward_parameters[] = {TRIBO_FEEDFORWARD_PARAMETERS(ROW)};
#undef T
#define T tribo_guard_f32_config_t
const tribo_parameter_t tribo_guard_parameters[] = {TRIBO_GUARD_PARAMETERS(ROW)};
#undef T
#define T tribo_sensorless_f32_config_t
const tribo_parameter_t tribo_sensorless_parameters[] = {TRIBO_SENSORLESS_PARAMETERS(ROW)};
#undef T
// clang-format on

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
