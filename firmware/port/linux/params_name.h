/// Words of a set of params by name, for messages.

#ifndef LINUX_PARAMS_NAME_H
#define LINUX_PARAMS_NAME_H

#include "app/registers.h"

/// As tribo-link and the configuration have it; of a section or a point the list's. Never null.
const char *params_name(uint32_t word);

/// Says on standard error what has changed of what protects since `told`, the set at the time of `*told_changes`, and renews both.
/// Called after each frame, so that all changes of a set are said, however many.
void params_name_changes(const registers_t *registers, params_set_t *told, uint32_t *told_changes);

#endif
