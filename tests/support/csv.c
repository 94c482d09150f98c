#include "csv.h"

#include "unity.h"

#include <stdlib.h>
#include <string.h>

void csv_open(csv_t *csv, const char *name, const char *header)
{
    char path[1024];
    char line[512];
    (void)snprintf(path, sizeof path, "%s/%s", TRIBO_GOLDEN_DIR, name);
    csv->file = fopen(path, "r");
    if (csv->file == NULL)
    {
        (void)snprintf(path, sizeof path, "%s/%s", TRIBO_VECTORS_DIR, name);
        csv->file = fopen(path, "r");
    }
    TEST_ASSERT_NOT_NULL_MESSAGE(csv->file, path);
    do
    {
        TEST_ASSERT_NOT_NULL(fgets(line, sizeof line, csv->file));
    } while (line[0] == '#'); // where it comes from
    line[strcspn(line, "\r\n")] = '\0';
    TEST_ASSERT_EQUAL_STRING(header, line);

    csv->rows    = 0;
    csv->columns = 1;
    for (const char *c = header; *c != '\0'; c++)
    {
        csv->columns += *c == ',';
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(CSV_COLUMNS_MAX, csv->columns);
}

bool csv_next(csv_t *csv)
{
    char line[512];
    if (fgets(line, sizeof line, csv->file) == NULL)
    {
        (void)fclose(csv->file);
        return false;
    }
    char *at = line;
    for (int i = 0; i < csv->columns; i++)
    {
        char *end     = NULL;
        csv->value[i] = strtod(at, &end);
        TEST_ASSERT_TRUE_MESSAGE(end != at && (*end == ',' || *end == '\n' || *end == '\r'), line);
        at = end + 1;
    }
    csv->rows++;
    return true;
}
