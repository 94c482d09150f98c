#include "cli/trace.h"

void sim_trace_write_header(FILE *file, bool learns)
{
    for (unsigned i = 0; i < sim_column_count(learns); i++)
    {
        (void)fprintf(file, i == 0 ? "%s" : ",%s", sim_columns[i].name);
    }
    (void)fputc('\n', file);
}

void sim_trace_write_compensator(FILE *file, const tribo_compensator_f32_signals_t *signals)
{
#define VALUE(name, value) (void)fprintf(file, ",%.9g", (double)(value));
    SIM_COMPENSATOR_COLUMNS(VALUE, VALUE)
#undef VALUE
}

void sim_trace_write_row(FILE *file, const sim_row_t *row)
{
    double         values[SIM_COLUMNS_MAX];
    const unsigned count = sim_column_values(row, values);
    for (unsigned i = 0; i < count; i++)
    {
        (void)fprintf(file, i == 0 ? "%.9g" : ",%.9g", values[i]);
    }
    (void)fputc('\n', file);
}
