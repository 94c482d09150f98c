// Runs a fuzz target over the files of folders, where there is no libFuzzer: tests/fuzz/corpus, in every check. Options
// ("-runs=0") are libFuzzer's and left out.

#include "fuzz.h"

#include <dirent.h>
#include <stdio.h>

static int is_file(const struct dirent *entry)
{
    return entry->d_name[0] != '.';
}

static bool replay(const char *folder, const char *name)
{
    char path[4096];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (file == NULL)
    {
        return false;
    }
    static uint8_t bytes[1u << 20u];
    const size_t   size = fread(bytes, 1, sizeof bytes, file);
    (void)fclose(file);
    return LLVMFuzzerTestOneInput(bytes, size) == 0;
}

int main(int count, char **arguments)
{
    int files = 0;
    for (int i = 1; i < count; i++)
    {
        struct dirent **entries;
        const int       found = (arguments[i][0] != '-') ? scandir(arguments[i], &entries, is_file, alphasort) : 0;
        for (int j = 0; j < found; j++)
        {
            if (!replay(arguments[i], entries[j]->d_name))
            {
                (void)fprintf(stderr, "%s/%s: cannot be read\n", arguments[i], entries[j]->d_name);
                return 1;
            }
            free(entries[j]);
            files++;
        }
        if (found > 0)
        {
            free((void *)entries);
        }
    }
    (void)printf("%d inputs, %u of them good\n", files, fuzz_good);
    return (files > 0 && fuzz_good > 0) ? 0 : 1;
}
