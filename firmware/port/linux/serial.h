/// A serial line, 8N1, whose reads and writes never wait.

#ifndef LINUX_SERIAL_H
#define LINUX_SERIAL_H

#include <stdbool.h>
#include <stdint.h>

/// Returns the line's file; negative, with errno, if it cannot be opened, is not a line, or does not have this rate.
int serial_open(const char *path, uint32_t baud, bool rs485);

/// Closes the line. Bytes that it has not sent yet are dropped, because a close would wait for them.
void serial_close(int file);

#endif
