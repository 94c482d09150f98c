/// Where the files are that a program came with: scenarios, tools.

#ifndef COMMON_DATA_PATH_H
#define COMMON_DATA_PATH_H

#include <limits.h>

/// The path of `name` among them, which need not exist. Found from where the program itself is, so that an installed tree may
/// move: beside it in a tree that it was built in, else where the installation puts data.
void common_data_path(char path[PATH_MAX], const char *name);

/// `path` if it exists, else `name` in the folder, if it is bare and there, with or without ".yaml". If neither exists `path` again
/// (opening it gives the error). To be freed; null if there is no memory.
char *common_data_named(const char *path, const char *folder, const char *name);

/// Where scenarios with a bare name are: the folder TRIBO_SCENARIOS if set, else the one that the program came with.
const char *common_scenario_folder(void);

#endif
