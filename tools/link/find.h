/// Finds the drives that answer where a drive may be: on serial lines of USB, and on this machine over Modbus TCP.

#ifndef LINK_FIND_H
#define LINK_FIND_H

#include <stdbool.h>

#define LINK_DEVICE_MAX 256

/// Finds the only device where a drive answers. Returns false after a complaint if there is none, or more than one.
bool link_find_device(char device[LINK_DEVICE_MAX], int unit, int baud);

/// Prints all of them, one per line. Returns false after a complaint if there is none.
bool link_print_devices(int unit, int baud);

#endif
