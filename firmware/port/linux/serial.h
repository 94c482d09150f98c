/// A serial line, 8N1, whose reads and writes never wait.

#ifndef LINUX_SERIAL_H
#define LINUX_SERIAL_H

#include <stdbool.h>
#include <stdint.h>

/// The line's file; negative, with errno: it cannot be opened, is no line, or has no such rate.
int serial_open(const char *path, uint32_t baud, bool rs485);

/// What it has not sent yet is dropped, as a close would wait for it.
void serial_close(int file);

#endif
