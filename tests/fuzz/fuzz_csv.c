// A CSV file, as a reference reads it and as logs are read: what is read is finite, and every row has its place.

#include "fuzz.h"

#include "support/csv.h"

#include <math.h>

unsigned fuzz_good;

static void check(const uint8_t *data, size_t size, bool is_log)
{
    static const common_csv_column_t columns[] = {{.name = "t_s"}, {.name = "u_N"}, {.name = "F_N", .optional = true}};

    common_error_t error = {""};
    common_csv_t   csv;
    char          *text = fuzz_text(data, size);
    const bool     ok   = common_csv_parse(&csv, text, "fuzz.csv", columns, 3, is_log, &error);
    fuzz_check_error(ok, &error);
    for (size_t i = 0; ok && i < csv.rows; i++)
    {
        ALWAYS(isfinite(csv.values[0][i]) && isfinite(csv.values[1][i]));
        ALWAYS(csv.values[2] == NULL || isfinite(csv.values[2][i]));
        ALWAYS(csv.positions[i] >= 1 && csv.positions[i] <= size);
    }
    ALWAYS(!ok || csv.rows > 0);
    fuzz_good += ok ? 1u : 0u;
    if (ok)
    {
        common_csv_free(&csv);
    }
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    check(data, size, false);
    check(data, size, true);
    return 0;
}
