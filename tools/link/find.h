/// Finds the drives that answer where a drive may be: on serial lines of USB, and on this machine over Modbus TCP.

#ifndef LINK_FIND_H
#define LINK_FIND_H

#include <stdbool.h>

#define LINK_DEVICE_MAX 256

/// The one where a drive answers. False after a complaint if there is none, or more than one.
bool link_find_device(char device[LINK_DEVICE_MAX], int unit, int baud);

/// All of them, a line each. False after a complaint if there is none.
bool link_print_devices(int unit, int baud);

#endif
