/// Pictures, drawn by the Python program tribo-plot among the tools that tribo-sim came with.

#ifndef SIM_PICTURE_H
#define SIM_PICTURE_H

#include "support/error.h"

#include <stdbool.h>

/// Whether a file can be a picture by its name.
bool sim_picture_has_ending(const char *path);

/// A new folder for what is drawn and then forgotten; to be freed. Null with the error filled in on failure.
char *sim_picture_folder(common_error_t *error);

/// Draws the run or the table at `path`, which is called `name` there unless that is null; `is_whole` as tribo-plot --all. If it fails what is drawn stays, and the
/// error says how to draw it later.
bool sim_picture_of(const char *path, const char *name, const char *out, bool is_whole, common_error_t *error);

#endif
