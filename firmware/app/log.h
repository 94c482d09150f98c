/// Writes text to the log of a port, from the background.

#ifndef DRIVE_LOG_H
#define DRIVE_LOG_H

#include "port/port.h"

#include <stdint.h>

void log_text(const port_t *port, const char *text);
void log_number(const port_t *port, uint32_t number);

#endif
