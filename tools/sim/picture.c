#include "sim/picture.h"

#include "sim/commands.h"
#include "sim/tool.h"
#include "support/output_file.h"
#include "support/text.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

bool sim_picture_has_ending(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot != NULL && (strcmp(dot, ".png") == 0 || strcmp(dot, ".svg") == 0 || strcmp(dot, ".html") == 0);
}

char *sim_picture_folder(common_error_t *error)
{
    const char *where  = getenv("TMPDIR");
    char       *folder = common_text_format("%s/tribo-sim-XXXXXX", where != NULL ? where : "/tmp");
    if (folder == NULL || !common_output_folder_temporary(folder))
    {
        (void)common_error_set(error, "%s: cannot be made: %s", folder != NULL ? folder : "a folder", strerror(errno));
        free(folder);
        return NULL;
    }
    return folder;
}

bool sim_picture_of(const char *path, const char *name, const char *out, bool is_whole, common_error_t *error)
{
    const char *words[8] = {"tribo-plot", path, "--out", out};
    size_t      count    = 4;
    if (name != NULL)
    {
        words[count++] = "--name";
        words[count++] = name;
    }
    words[count] = is_whole ? "--all" : NULL;
    return sim_tool_run(words) == SIM_EXIT_OK ||
           common_error_set(error,
                            "there is no picture, but nothing is lost: tribo-sim plot %s --out %s draws it",
                            path,
                            out);
}
