/// Where the files are that a program came with: scenarios, studies, tools.

#ifndef COMMON_DATA_PATH_H
#define COMMON_DATA_PATH_H

#include <limits.h>

/// The path of `name` among them, which need not exist. Found from where the program itself is, so that an installed tree may
/// move: beside it in a tree that it was built in, else where the installation puts data.
void common_data_path(char path[PATH_MAX], const char *name);

#endif
