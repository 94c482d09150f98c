/// Finds the files that come with a program: scenarios, tools.

#ifndef COMMON_DATA_PATH_H
#define COMMON_DATA_PATH_H

#include <limits.h>

/// Writes the path of `name` among them, which need not exist. The path is found from the place of the program itself, so that an
/// installed tree may move: next to the program in its build tree, otherwise where the installation puts data.
void common_data_path(char path[PATH_MAX], const char *name);

/// Returns `path` if it exists; otherwise the file `name` in the folder, with or without ".yaml", if `name` has no folder of
/// its own. If neither exists it returns `path`, which gives the error when it is opened. Free the result; null if there is
/// no memory.
char *common_data_named(const char *path, const char *folder, const char *name);

/// Returns the folder of scenarios that are given by name: TRIBO_SCENARIOS if set, otherwise the folder that comes with the
/// program.
const char *common_scenario_folder(void);

#endif
