/// Names the words of a set of params, for messages.

#ifndef LINUX_PARAMS_NAME_H
#define LINUX_PARAMS_NAME_H

#include "app/registers.h"

/// Returns the name of a word in tribo-link and the configuration; for a section or a point the name of its list. Never null.
const char *params_name(uint32_t word);

/// Reports on standard error which words that protect have changed since the set `told`, which is that of `*told_changes`,
/// and renews both. Call it after each frame, so that all changes of a set are reported, however many.
void params_name_changes(const registers_t *registers, params_set_t *told, uint32_t *told_changes);

#endif
