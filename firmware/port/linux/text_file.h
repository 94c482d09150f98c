/// Reads and writes a whole number in a file of sysfs that stays open.

#ifndef LINUX_TEXT_FILE_H
#define LINUX_TEXT_FILE_H

#include <stdbool.h>
#include <stdint.h>

/// Return false if the kernel refuses, or if the file does not hold a number. They do not allocate, and repeat what a signal
/// has interrupted.
bool text_file_read(int file, int64_t *number);
bool text_file_write(int file, int64_t number);

#endif
