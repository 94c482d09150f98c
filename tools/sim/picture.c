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
    // In one word with its option, because tribo-plot would take a name that begins with - for an option.
    char       *out_word  = common_text_format("--out=%s", out);
    char       *name_word = common_text_format("--name=%s", name != NULL ? name : "");
    char       *shell_in  = common_text_quoted(path);
    char       *shell_out = common_text_quoted(out);
    const char *words[7]  = {"tribo-plot", out_word};
    size_t      count     = 2;
    if (name != NULL)
    {
        words[count++] = name_word;
    }
    if (is_whole)
    {
        words[count++] = "--all";
    }
    words[count++] = "--";
    words[count]   = path;
    const bool ok =
        out_word != NULL && name_word != NULL && shell_in != NULL && shell_out != NULL
            ? sim_tool_run(words) == SIM_EXIT_OK ||
                  common_error_set(error,
                                   "there is no picture, but nothing is lost: tribo-sim plot %s --out %s draws it",
                                   shell_in,
                                   shell_out)
            : common_error_set(error, "out of memory");
    free(shell_in);
    free(shell_out);
    free(out_word);
    free(name_word);
    return ok;
}
