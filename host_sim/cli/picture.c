#include "cli/picture.h"

#include "cli/commands.h"
#include "support/data_path.h"
#include "support/text.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

extern char **environ;

/// Like system(): a Ctrl-C ends the drawing, and this program says what is left.
static int wait_for(pid_t process)
{
    int status          = 0;
    void (*before)(int) = signal(SIGINT, SIG_IGN);
    (void)waitpid(process, &status, 0);
    (void)signal(SIGINT, before);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? SIM_EXIT_OK : SIM_EXIT_ERROR;
}

bool sim_picture_has_ending(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot != NULL && (strcmp(dot, ".png") == 0 || strcmp(dot, ".svg") == 0 || strcmp(dot, ".html") == 0);
}

char *sim_picture_folder(common_error_t *error)
{
    const char *where  = getenv("TMPDIR");
    char       *folder = common_text_format("%s/tribo-sim-XXXXXX", where != NULL ? where : "/tmp");
    if (folder == NULL || mkdtemp(folder) == NULL)
    {
        (void)common_error_set(error, "%s: cannot be made: %s", folder != NULL ? folder : "a folder", strerror(errno));
        free(folder);
        return NULL;
    }
    return folder;
}

bool sim_picture_of(const char *path, const char *name, const char *out, common_error_t *error)
{
    const char *const words[] = {"tribo-plot", path, "--out", out, name != NULL ? "--name" : NULL, name, NULL};
    return sim_picture_draw(words) == SIM_EXIT_OK ||
           common_error_set(error, "no picture, but nothing is lost: tribo-sim plot %s --out %s draws it", path, out);
}

int sim_picture_draw(const char *const *arguments)
{
    char  program[PATH_MAX];
    pid_t process;
    common_data_path(program, "tools/tribo-plot");
    const int wrong = posix_spawn(&process, program, NULL, NULL, (char *const *)arguments, environ);
    if (wrong != 0)
    {
        common_error_t error = {""};
        (void)common_error_set(&error, "%s: cannot be started: %s", program, strerror(wrong));
        return sim_failure(error.text);
    }
    return wait_for(process);
}
