/// Pictures, drawn by tribo-plot, a Python program that is installed with tribo-sim.

#ifndef SIM_PICTURE_H
#define SIM_PICTURE_H

#include "support/error.h"

#include <stdbool.h>

/// Whether a file's name has an ending of a picture.
bool sim_picture_has_ending(const char *path);

/// Makes a temporary folder for files that are removed after drawing. The caller frees the name. Returns null with the error filled in on failure.
char *sim_picture_folder(common_error_t *error);

/// Draws the run or the table at `path`, which is called `name` there unless that is null; `is_whole` as tribo-plot --all. If drawing fails the files stay, and the
/// error says how to draw them later.
bool sim_picture_of(const char *path, const char *name, const char *out, bool is_whole, common_error_t *error);

#endif
