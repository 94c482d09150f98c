#include "sim/trace.h"

#include <string.h>

/// The number of the column whose name is the first `length` bytes; SIM_COLUMNS_MAX if none has it.
static unsigned find(const char *name, size_t length)
{
    unsigned i = 0;
    while (i < SIM_COLUMNS_MAX &&
           (strlen(sim_columns[i].name) != length || strncmp(sim_columns[i].name, name, length) != 0))
    {
        i++;
    }
    return i;
}

bool sim_trace_choose(sim_trace_choice_t *choice, const char *list, common_error_t *error)
{
    choice->is_chosen = true;
    choice->has[0]    = true; // t_s
    while (*list != '\0')
    {
        const size_t   length = strcspn(list, ",");
        const unsigned column = find(list, length);
        if (column == SIM_COLUMNS_MAX)
        {
            return common_error_set(error, "a trace has no column '%.*s'", (int)length, list);
        }
        choice->has[column] = true;
        list += length + (list[length] == ',' ? 1u : 0u);
    }
    return true;
}

bool sim_trace_check(const sim_trace_choice_t *choice, bool learns, common_error_t *error)
{
    for (unsigned i = sim_column_count(learns); i < SIM_COLUMNS_MAX; i++)
    {
        if (choice->has[i])
        {
            return common_error_set(error, "--columns %s: this run learns nothing", sim_columns[i].name);
        }
    }
    return true;
}

static bool is_written(const sim_trace_choice_t *choice, unsigned column)
{
    return !choice->is_chosen || choice->has[column];
}

void sim_trace_write_header(FILE *file, const sim_trace_choice_t *choice, bool learns)
{
    for (unsigned i = 0; i < sim_column_count(learns); i++)
    {
        if (is_written(choice, i))
        {
            (void)fprintf(file, i == 0 ? "%s" : ",%s", sim_columns[i].name);
        }
    }
    (void)fputc('\n', file);
}

void sim_trace_write_compensator(FILE *file, const tribo_compensator_f32_signals_t *signals)
{
#define VALUE(name, value) (void)fprintf(file, ",%.9g", (double)(value));
    SIM_COMPENSATOR_COLUMNS(VALUE, VALUE)
#undef VALUE
}

void sim_trace_write_row(FILE *file, const sim_trace_choice_t *choice, const sim_row_t *row)
{
    double         values[SIM_COLUMNS_MAX];
    const unsigned count = sim_column_values(row, values);
    for (unsigned i = 0; i < count; i++)
    {
        if (is_written(choice, i))
        {
            (void)fprintf(file, i == 0 ? "%.9g" : ",%.9g", values[i]);
        }
    }
    (void)fputc('\n', file);
}
