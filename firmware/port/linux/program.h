/// What tribo-drive and tribo-desk do: firmware/app on a Linux board.

#ifndef LINUX_PROGRAM_H
#define LINUX_PROGRAM_H

#include "desk.h"

/// The whole program; returns its exit status. Without a desk it is on devices and lines.
int program_run(int count, char **arguments, const desk_t *desk);

#endif
