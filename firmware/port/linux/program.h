/// The program of tribo-drive and tribo-desk: firmware/app on a Linux board.

#ifndef LINUX_PROGRAM_H
#define LINUX_PROGRAM_H

#include "desk.h"

/// Runs the whole program and returns its exit status. Without a desk it uses devices and lines.
int program_run(int count, char **arguments, const desk_t *desk);

#endif
