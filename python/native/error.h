/// Fills in what Python raises.

#ifndef NATIVE_ERROR_H
#define NATIVE_ERROR_H

#include "native.h"

#include "tribo/status.h"

void native_error_say(native_error_t *error, const char *key, const char *text);
void native_error_status(native_error_t *error, tribo_status_t status);

#endif
