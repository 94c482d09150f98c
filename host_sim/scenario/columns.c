#include "scenario/columns.h"

#define NUMBER(name_, value) {.name = #name_},
#define FLAG(name_, value)   {.name = #name_, .is_flag = true},
const sim_column_t sim_columns[] = {SIM_RUN_COLUMNS(NUMBER, FLAG) SIM_LEARNED_COLUMNS(NUMBER, FLAG)};
#undef NUMBER
#undef FLAG

unsigned sim_column_count(bool learns)
{
    return learns ? SIM_COLUMNS_MAX : SIM_COLUMNS;
}

unsigned sim_column_values(const sim_row_t *row, double values[SIM_COLUMNS_MAX])
{
    const tribo_compensator_f32_signals_t *signals = &row->loop.compensator;

    unsigned count = 0;
#define VALUE(name, value) values[count++] = (double)(value);
    SIM_RUN_COLUMNS(VALUE, VALUE)
    if (row->learned != NULL)
    {
        SIM_LEARNED_COLUMNS(VALUE, VALUE)
    }
#undef VALUE
    return count;
}
