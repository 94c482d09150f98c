/// Fills in what Python raises.

#ifndef NATIVE_ERROR_H
#define NATIVE_ERROR_H

#include "native.h"

#include "tribo/status.h"

void native_error_say(native_error_t *error, const char *key, const char *text);

/// Returns true if the library refuses nothing, otherwise fills in its refusal.
bool native_accepted(tribo_status_t status, native_error_t *error);

#endif
