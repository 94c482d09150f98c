/// Words of a set of params by name, for messages.

#ifndef LINUX_PARAMS_NAME_H
#define LINUX_PARAMS_NAME_H

#include "app/registers.h"

/// As tribo-link and the configuration have it; of a section or a point the list's. Never null.
const char *params_name(uint32_t word);

/// Writes a line to standard error for each change of what protects that has come since the last call.
void params_name_changes(const registers_t *registers);

#endif
