#include "sim/tool.h"

#include "sim/commands.h"
#include "support/data_path.h"
#include "support/error.h"

#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>

extern char **environ;

/// Waits as system() does: Ctrl-C ends the program, and tribo-sim then reports what is left.
static int wait_for(pid_t process)
{
    int status          = 0;
    void (*before)(int) = signal(SIGINT, SIG_IGN);
    (void)waitpid(process, &status, 0);
    (void)signal(SIGINT, before);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? SIM_EXIT_OK : SIM_EXIT_ERROR;
}

int sim_tool_run(const char *const *arguments)
{
    char  name[40];
    char  program[PATH_MAX];
    pid_t process;
    (void)snprintf(name, sizeof name, "tools/%s", arguments[0]);
    common_data_path(program, name);
    const int wrong = posix_spawn(&process, program, NULL, NULL, (char *const *)arguments, environ);
    if (wrong != 0)
    {
        common_error_t error = {""};
        (void)common_error_set(&error, "%s: cannot be started: %s", program, strerror(wrong));
        return sim_failure(error.text);
    }
    return wait_for(process);
}
